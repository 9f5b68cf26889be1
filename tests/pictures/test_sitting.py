"""A group is pictured alike by every command: names become values, seeds follow from the run's."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fakes.configurations import composed
from fakes.scenes import EXPRESSIONS, LENSES, LIGHTINGS, POSES, SKINS, STANDPOINTS, recipe, scene
from omegaconf import DictConfig

from lrsr.errors import InputError
from lrsr.identities.person import Person
from lrsr.identities.population import Population
from lrsr.identities.roster import IdentityRange, Roster, write_roster
from lrsr.pictures.burst import Burst
from lrsr.pictures.sitting import (
    Sitting,
    _read_scene,
    read_gallery,
    read_people,
    read_probes,
    read_quality,
)
from lrsr.presets import preset
from lrsr.rendering.scene import Film, Quality

SITTING = Sitting(IdentityRange(start=5, count=3), scene(), Film(), Quality())


def config(*overrides: str) -> DictConfig:
    return composed("render", "out=x", *overrides)


def test_everyone_is_pictured_alike_but_for_the_noise() -> None:
    recipes = SITTING.recipes()
    assert [one.person for one in recipes] == [Person("test", index) for index in (5, 6, 7)]
    assert {replace(one, person=Person("test", 5), seed=0) for one in recipes} == {
        recipe(5, samples_per_pixel=512)
    }
    assert len({one.seed for one in recipes}) == 3


def test_a_reference_is_the_same_scene_on_a_finer_film_with_noise_of_its_own() -> None:
    probes, references = SITTING.recipes(), SITTING.recipes(4)
    for probe, reference in zip(probes, references, strict=True):
        assert reference.film == Film(8.0, 4)
        assert replace(reference, film=probe.film, seed=probe.seed) == probe
        assert reference.seed != probe.seed
    with pytest.raises(InputError, match="scale=8: wanted one of"):
        replace(SITTING, film=Film(scale=2)).recipes(4)


def test_a_picture_has_the_seed_of_its_run_and_kind() -> None:
    first = SITTING.recipes()[0]
    assert first == replace(first, seed=0).seeded(0, "probe")
    assert replace(SITTING, seed=7).recipes()[0] == first.seeded(7, "probe")
    assert replace(SITTING, seed=np.int64(7)) == replace(SITTING, seed=7)
    assert replace(SITTING, kind="gallery").recipes()[0] == first.seeded(0, "gallery")


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"kind": "mugshot"}, "kind=mugshot: wanted one of probe, gallery"),
        ({"seed": -1}, "seed=-1: wanted 0 to 4294967295"),
        ({"seed": 2**32}, "seed=4294967296: wanted 0 to"),
        ({"seed": 0.5}, "seed=0.5: wanted a whole number"),
    ],
    ids=str,
)
def test_a_sitting_that_cannot_be_is_refused(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        replace(SITTING, **wrong)


def test_a_sitting_is_recorded_in_plain_values() -> None:
    asked = scene("left", "room_blue", "single", "scface_far", "smile")
    plain = json.loads(json.dumps(replace(SITTING, scene=asked).describe()))
    assert plain["people"]["start"] == 5
    assert plain["scene"]["pose"] == {
        "name": "left",
        "yaw_deg": 30.0,
        "pitch_deg": 0.0,
        "roll_deg": 0.0,
    }
    assert plain["scene"]["lighting"]["name"] == "room_blue"
    assert len(plain["scene"]["lens"]["surfaces"]) == 3
    assert plain["scene"]["standpoint"]["distance_m"] == 4.2
    assert plain["scene"]["expression"]["name"] == "smile"
    assert plain["quality"]["skin"]["name"] == "reflective"


def test_what_is_named_on_the_command_line_is_what_is_pictured() -> None:
    names = {"pose": "left", "lighting": "room_blue", "lens": "single"}
    names |= {"standpoint": "scface_far", "expression": "smile", "another_day": "cap"}
    given = config(*(f"{group}={name}" for group, name in names.items()))
    assert _read_scene(given) == scene(**names)
    assert _read_scene(config()) == scene()


def test_one_number_changes_one_number() -> None:
    changes = ["pose.yaw_deg=10", "lighting.fill_share=0.5", "lens=single", "lens.f_number=8"]
    changes += ["standpoint.distance_m=3", "expression=blink", "+expression.units.jawOpen=0.2"]
    assert _read_scene(config(*changes)) == scene(
        replace(POSES["frontal"], yaw_deg=10),
        replace(LIGHTINGS["frontal"], fill_share=0.5),
        replace(LENSES["single"], f_number=8),
        replace(STANDPOINTS["level"], distance_m=3),
        replace(
            EXPRESSIONS["blink"], units={"eyeBlinkLeft": 1, "eyeBlinkRight": 1, "jawOpen": 0.2}
        ),
    )


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("pose.yaw_deg=steep", r"pose\.yaw_deg=steep: wanted a number"),
        ("+pose.tilt_deg=3", r"pose: .*'tilt_deg'"),
        ("lighting.fill_share=2", "lighting 'frontal': fill_share=2"),
        ("lighting=map", r"lighting\.map must be given: add lighting\.map="),
        ("+expression.units.jawOpen=2", r"expression\.jawOpen=2: wanted 0 to 1"),
        ("expression.strength=2", r"expression\.strength=2: wanted 0 to 1"),
    ],
)
def test_a_wrong_number_names_the_setting(override: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        _read_scene(config(override))


def test_quality_is_what_the_group_says() -> None:
    assert read_quality(config()) == Quality(512, 5, 1024)
    slow = read_quality(config("rendering=subsurface", "rendering.texture_size=64"))
    assert slow == Quality(2048, 5, 64, SKINS["subsurface"])
    tone = read_quality(config("rendering=volumetric", "rendering/skin=tone"))
    assert tone.skin == SKINS["subsurface_tone"]
    with pytest.raises(InputError, match=r"rendering\.texture_size=32: wanted 64 to 8192"):
        read_quality(config("rendering.texture_size=32"))
    with pytest.raises(InputError, match=r"rendering.*samples"):
        read_quality(config("+rendering.samples=32"))


def test_people_are_who_the_group_says(tmp_path: Path) -> None:
    assert read_people(config()) == IdentityRange(count=4)
    from lrsr.identities.morphable import RECIPE_VERSION

    women = Population("female")
    roster = Roster("test", 0, 3, women, RECIPE_VERSION, "dlib", 11.2, {1: 2})
    path = write_roster(tmp_path / "roster.json", roster)
    given = ["identities/population=women", "identities.count=3", f"identities.roster={path}"]
    people = read_people(config(*given)).people()
    assert [person.draw for person in people] == [0, 2, 0]
    assert {person.population for person in people} == {women}
    with pytest.raises(InputError, match=r"identities\.roster covers test 0 to 2, not 3"):
        read_people(config(*given, "identities.count=4"))
    with pytest.raises(InputError, match=r"identities\.count: Value 'many'"):
        read_people(config("identities.count=many"))
    with pytest.raises(InputError, match=r"identities\.start=-1: wanted 0 to"):
        read_people(config("identities.start=-1"))


def test_the_enrolled_picture_is_that_of_the_gallery_whatever_else_is_asked() -> None:
    asked = [
        "pose=up",
        "lighting=side",
        "expression=smile",
        "another_day=cap",
        "lens=single",
        "ipd_px=9",
    ]
    enrolled = read_gallery(config(*asked, "standpoint=scface_far", "seed=3"))
    assert enrolled.scene == scene()
    assert enrolled.film == Film(64.0)
    assert (enrolled.kind, enrolled.seed) == ("gallery", 3)
    assert enrolled.quality == Quality(64)
    assert read_gallery(config("rendering=subsurface")).quality.skin == SKINS["subsurface"]
    with pytest.raises(InputError, match=r"gallery\.ipd_px=3.0: wanted at least 4"):
        read_gallery(config("gallery.ipd_px=3"))
    with pytest.raises(InputError, match=r"gallery\.samples_per_pixel=many: wanted a whole number"):
        read_gallery(config("gallery.samples_per_pixel=many"))


def test_every_frame_has_noise_of_its_own_and_the_first_is_what_it_always_was() -> None:
    moving = replace(SITTING, burst=Burst(shift_ipds=0.1))
    assert moving.recipes(frame=0) == moving.recipes() == SITTING.recipes()
    frames = [recipe for frame in range(3) for recipe in moving.recipes(frame=frame)]
    assert len({one.seed for one in frames}) == 9
    assert len({one.film.shift_px for one in frames}) == 7  # the first of all have not moved
    still = [SITTING.recipes(frame=frame)[0] for frame in range(3)]
    assert {replace(one, seed=0) for one in still} == {replace(still[0], seed=0)}
    assert len({one.seed for one in still}) == 3


def test_frames_move_as_the_group_says() -> None:
    assert read_probes(config(), Film()).burst == preset("burst", "video")
    asked = read_probes(config("burst=still", "burst.yaw_deg=3"), Film()).burst
    assert asked == Burst("still", yaw_deg=3)
