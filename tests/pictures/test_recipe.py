"""What changes the pixels is in the key, and nothing else; seeds are those of ever."""

import json
import subprocess
import sys
from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest
from fakes.scenes import (
    DAYS,
    EXPRESSIONS,
    LENSES,
    LIGHTINGS,
    POSES,
    ROOMS,
    SKINS,
    STANDPOINTS,
    recipe,
)

from lrsr.errors import InputError
from lrsr.identities.day.another_day import AnotherDay
from lrsr.identities.face.expression import Expression
from lrsr.identities.person import Person
from lrsr.identities.population import Population
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.recipe import KINDS, Kind, Recipe, derived_seed, digest
from lrsr.rendering.lens import Lens
from lrsr.rendering.lighting import Lighting
from lrsr.rendering.lights import Light
from lrsr.rendering.pose import Pose
from lrsr.rendering.scene import Film, Quality, Scene
from lrsr.rendering.standpoint import Standpoint
from lrsr.rendering.surfaces import Surface

RECIPE = recipe(3)
VERSIONS = {"renderer": "1"}
WOMEN = Population("female")
OTHERS: dict[str, Any] = {
    "index": 4,
    "split": "train",
    "draw": 1,
    "population": WOMEN,
    "pose": "left",
    "lighting": "side",
    "lens": "thin",
    "standpoint": "scface_far",
    "expression": "smile",
    "another_day": "glasses",
    "ipd_px": 9.0,
    "scale": 2,
    "bands": 35,
    "shift_px": (0.5, 0.0),
    "nearer": 0.01,
    "samples_per_pixel": 16,
    "max_depth": 8,
    "texture_size": 64,
    "skin": "subsurface",
    "seed": 1,
}


def changed(**changes: Any) -> Recipe:
    return recipe(**{"index": 3, **changes})


def key(one: Recipe, **versions: str) -> str:
    return RenderCache.key(one, {**VERSIONS, **versions})


@pytest.mark.parametrize("name", OTHERS)
def test_whatever_changes_the_pixels_changes_the_key(name: str) -> None:
    assert key(changed(**{name: OTHERS[name]})) != key(RECIPE)


def test_every_field_is_such_a_thing() -> None:
    parts = [each.name for part in (Person, Scene, Film, Quality) for each in fields(part)]
    assert {*OTHERS} == {*parts, "seed"}
    assert {each.name for each in fields(Recipe)} == {"person", "scene", "film", "quality", "seed"}


def test_few_samples_are_not_what_older_caches_keep_of_them() -> None:
    asked = [changed(samples_per_pixel=number).plain(VERSIONS) for number in (15, 16)]
    assert [one["quality"].get("few") for one in asked] == [True, None]


@pytest.mark.parametrize("name", ["renderer", "identities", "variant"])
def test_new_code_makes_new_pictures(name: str) -> None:
    assert key(RECIPE, **{name: "2"}) != key(RECIPE)


def test_equal_recipes_have_equal_keys_seeds_and_hashes() -> None:
    again = changed()
    assert again == RECIPE
    assert hash(again) == hash(RECIPE)
    assert key(again) == key(RECIPE)
    assert again.seeded(7, "probe") == RECIPE.seeded(7, "probe")


def test_whole_numbers_numbers_with_a_point_and_numpys_are_one_picture() -> None:
    same = recipe(
        np.int64(3),
        draw=np.int32(0),
        ipd_px=np.float32(8),
        scale=np.int8(1),
        samples_per_pixel=np.uint16(2048),
        seed=np.int64(0),
        pose=Pose("frontal", yaw_deg=0, pitch_deg=np.float64(0)),
    )
    assert same == changed(ipd_px=8) == changed(ipd_px=8.0) == RECIPE
    assert key(same) == key(RECIPE)
    assert same.seeded(np.int64(7), "probe") == RECIPE.seeded(7, "probe")


def test_the_name_of_a_pose_or_a_lighting_is_not_in_the_key_and_its_numbers_are() -> None:
    named = changed(pose="left", lighting="above")
    mine = replace(POSES["left"], name="mine"), replace(LIGHTINGS["above"], name="mine")
    assert key(changed(pose=mine[0], lighting=mine[1])) == key(named)
    turned = replace(POSES["left"], yaw_deg=31)
    assert key(changed(pose=turned, lighting="above")) != key(named)
    filled = replace(LIGHTINGS["above"], fill_share=0.9)
    assert key(changed(pose="left", lighting=filled)) != key(named)


def test_a_named_expression_is_its_face_units() -> None:
    mine = replace(EXPRESSIONS["smile"], name="mine")
    assert key(changed(expression=mine)) == key(changed(expression="smile"))
    assert key(changed(expression=Expression("none"))) == key(RECIPE)


def test_a_named_day_is_its_numbers_and_a_later_one_is_another_picture() -> None:
    worn, mine = changed(another_day="glasses"), replace(DAYS["glasses"], name="mine")
    assert key(changed(another_day=mine)) == key(worn)
    assert key(changed(another_day=mine.later(1))) != key(worn)
    assert changed(another_day=mine.later(1)).seeded(7, "probe") != worn.seeded(7, "probe")


def test_a_day_on_which_nothing_changes_is_the_day_of_enrolment() -> None:
    same = changed(another_day=AnotherDay("mine", day=5))
    assert key(same) == key(RECIPE)
    assert same.seeded(7, "probe").seed == RECIPE.seeded(7, "probe").seed


def test_a_named_skin_is_its_numbers() -> None:
    mine = replace(SKINS["subsurface"], name="mine")
    assert key(changed(skin=mine)) == key(changed(skin="subsurface"))
    assert key(changed(skin=replace(mine, reach_mm=6))) != key(changed(skin="subsurface"))
    assert len({key(changed(skin=skin)) for skin in SKINS}) == len(SKINS)


def test_a_lens_is_its_surfaces_and_a_standpoint_its_place() -> None:
    mine = replace(LENSES["single"], name="mine")
    assert key(changed(lens=mine)) == key(changed(lens="single"))
    assert key(changed(lens=Lens("none"))) == key(RECIPE)
    slower = replace(LENSES["single"], f_number=8.0)
    assert key(changed(lens=slower)) != key(changed(lens="single"))
    place = replace(STANDPOINTS["scface_far"], name="mine")
    assert key(changed(standpoint=place)) == key(changed(standpoint="scface_far"))
    assert key(changed(standpoint=Standpoint("eyes", height_m=1.6))) == key(RECIPE)


def test_a_lens_of_whole_numbers_is_that_of_numbers_with_a_point() -> None:
    rows = [(0, 0, "air", 1, True), (3, 1, "N-BK7", 2), (-3, 2.6, "air", 2)]
    whole = Lens("own", tuple(Surface(*row) for row in rows))
    point = [(0.0, 0.0, "air", 1.0, True), (3.0, 1.0, "N-BK7", 2.0), (-3.0, 2.6, "air", 2.0)]
    same = Lens("own", tuple(Surface(*row) for row in point))
    assert changed(lens=whole) == changed(lens=same)
    assert key(changed(lens=whole)) == key(changed(lens=same))
    seeds = {changed(lens=lens).seeded(7, "probe").seed for lens in (whole, same)}
    assert len(seeds) == 1


def test_keys_are_those_of_other_days_and_machines() -> None:
    """Whoever changes what a recipe says makes everybody's caches useless: then say so here."""
    assert key(RECIPE) == "afbf363782007f4c92fb5b28e1c68e0e92ad5f942b192ea31fefa04376b0cc8d"
    others = {**OTHERS, "another_day": "none", "shift_px": (0.0, 0.0), "nearer": 0.0}
    assert (
        key(changed(**others)) == "b2a7cfba4293010620957b9bd1f2745fa063b547e1296d9a45f2db8bacffe5e4"
    )


FROZEN: dict[str, tuple[dict[str, Any], Kind, int, int]] = {
    "somebody": ({}, "probe", 1599039098, 566611520),
    "enrolled": ({"ipd_px": 64.0}, "gallery", 1857065767, 3837010860),
    "the last": ({"index": 499}, "probe", 2010008236, 3116991726),
    "train": ({"split": "train", "index": 7}, "probe", 1879193062, 3180642549),
    "validation": ({"split": "validation", "index": 7}, "probe", 4176764438, 683218416),
    "left": ({"index": 3, "pose": "left", "lighting": "side"}, "probe", 2510976753, 4161630569),
    "down": ({"index": 3, "pose": "down", "lighting": "above"}, "probe", 996170188, 1367394246),
    "up": ({"index": 3, "pose": "up", "lighting": "below"}, "probe", 906584331, 1329907381),
    "room": ({"index": 3, "lighting": "room_blue"}, "probe", 668279401, 89700911),
    "x2": ({"index": 3, "scale": 2}, "probe", 4127041018, 1097421957),
    "x4": ({"index": 3, "scale": 4}, "probe", 3212078042, 544202230),
    "larger": ({"index": 3, "ipd_px": 11.5}, "probe", 3168972288, 454511587),
    "redrawn": ({"index": 3, "draw": 2}, "probe", 422255497, 564872262),
    "woman": ({"index": 3, "population": WOMEN}, "probe", 2243065004, 1249215310),
    "young man": (
        {"index": 3, "population": Population("male", ("asian",), (25, 40)), "draw": 1},
        "probe",
        578155501,
        575093565,
    ),
    "smile": ({"index": 3, "expression": "smile"}, "probe", 19330221, 3118806420),
    "blink": ({"index": 3, "expression": "blink"}, "probe", 3221826723, 3033668332),
    "thin": ({"index": 3, "lens": "thin"}, "probe", 1708607593, 2797467432),
    "single": ({"index": 3, "lens": "single"}, "probe", 2307275180, 2014368985),
    "double gauss": ({"index": 3, "lens": "double_gauss"}, "probe", 2109688467, 786875883),
    "far": ({"index": 3, "standpoint": "scface_far"}, "probe", 624606058, 1531978592),
    "all": (
        {
            "index": 3,
            "pose": "left",
            "lighting": "below",
            "ipd_px": 13,
            "scale": 2,
            "draw": 1,
            "population": WOMEN,
            "expression": "smile",
            "lens": "single",
            "standpoint": "scface_near",
        },
        "gallery",
        888318651,
        2481240131,
    ),
}
"""Seeds that ``lrsr eval`` of version 0.1.0 (commit 0bd3d20) gave to pictures of runs 0 and 7."""


@pytest.mark.parametrize("name", FROZEN)
def test_the_noise_of_a_picture_is_that_of_before(name: str) -> None:
    asked, kind, *wanted = FROZEN[name]
    assert [recipe(**asked).seeded(run, kind).seed for run in (0, 7)] == wanted


@pytest.mark.parametrize(
    "change",
    [
        {"pose": Pose("frontal", yaw_deg=5)},
        {"lighting": replace(LIGHTINGS["frontal"], fill_share=0.9)},
        {"skin": "subsurface"},
        {"samples_per_pixel": 16},
        {"bands": 35},
    ],
    ids=lambda change: next(iter(change)),
)
def test_scenes_of_the_same_names_differ_in_light_and_not_in_noise(change: dict[str, Any]) -> None:
    assert changed(**change).seeded(7, "probe").seed == RECIPE.seeded(7, "probe").seed
    assert key(changed(**change).seeded(7, "probe")) != key(RECIPE.seeded(7, "probe"))


def test_a_seed_changes_nothing_else() -> None:
    seeded = RECIPE.seeded(7, "probe")
    assert replace(seeded, seed=0) == RECIPE
    assert seeded.seeded(7, "probe") == seeded


def test_an_enrolled_picture_and_a_probe_have_other_noise() -> None:
    assert len({RECIPE.seeded(0, kind).seed for kind in KINDS}) == len(KINDS)


@pytest.mark.parametrize("change", [{"population": Population("male")}, {"draw": 2}], ids=str)
def test_somebody_else_has_another_name_and_other_noise(change: dict[str, Any]) -> None:
    other = changed(**change)
    assert other.person.id != RECIPE.person.id
    assert other.seeded(0, "probe").seed != RECIPE.seeded(0, "probe").seed


def test_any_pose_and_any_lighting_become_plain_values() -> None:
    lights = (Light(10.0, 20.0), Light(-30.0, 40.0))
    mine = {"pose": Pose("mine", yaw_deg=12.5), "lighting": Lighting("mine", lights)}
    plain = changed(**mine).plain(VERSIONS)
    assert json.loads(json.dumps(plain))["pose"]["yaw_deg"] == 12.5
    turned = changed(**{**mine, "pose": Pose("mine", yaw_deg=12.6)})
    relit = changed(**{**mine, "lighting": Lighting("mine", (lights[0], Light(-30.0, 41.0)))})
    assert len({key(changed(**mine)), key(turned), key(relit)}) == 3


@pytest.mark.parametrize("lighting", [*LIGHTINGS, *ROOMS])
@pytest.mark.parametrize("lens", LENSES)
def test_every_preset_is_plain(lighting: str, lens: str) -> None:
    for skin in SKINS:
        plain = changed(lighting=lighting, lens=lens, skin=skin, pose="up").plain(VERSIONS)
        assert "name" not in json.dumps(plain)
        assert digest(json.loads(json.dumps(plain))) == digest(plain)


def test_a_digest_is_the_sha_256_of_the_canonical_json() -> None:
    # printf '{"a":1,"b":[2.5,"c"]}' | sha256sum
    wanted = "f989c384ab7cb3797986cece780337f1491bcf05b8ec18412a9fe11e83d66e18"
    assert digest({"b": [2.5, "c"], "a": 1}) == wanted


def test_the_order_of_a_mapping_does_not_change_its_digest() -> None:
    assert digest({"a": 1, "b": {"c": 2, "d": 3}}) == digest({"b": {"d": 3, "c": 2}, "a": 1})


def test_a_digest_has_no_room_for_what_is_no_number() -> None:
    with pytest.raises(ValueError, match="not JSON compliant"):
        digest({"a": float("nan")})
    with pytest.raises(TypeError, match="not JSON serializable"):
        digest({"a": object()})


@pytest.mark.parametrize(
    ("seed", "message"),
    [
        (2**32, "seed=4294967296: wanted 0 to 4294967295"),
        (-1, "seed=-1: wanted 0 to"),
        (0.5, "seed=0.5: wanted a whole number"),
        (True, "seed=[Tt]rue: wanted a whole number"),
    ],
)
def test_a_seed_out_of_range_is_refused(seed: int, message: str) -> None:
    with pytest.raises(InputError, match=message):
        replace(RECIPE, seed=seed)


def test_the_seed_of_a_run_is_a_whole_number() -> None:
    with pytest.raises(InputError, match="seed=x: wanted a whole number"):
        RECIPE.seeded("x", "probe")  # type: ignore[arg-type]  # wrong on purpose


def test_seeds_differ_between_pictures_and_not_between_runs() -> None:
    pictures = [("test", i, pose) for i in range(50) for pose in ("frontal", "left")]
    seeds = [derived_seed(0, *picture) for picture in pictures]
    assert len(set(seeds)) == len(pictures)
    assert all(0 <= seed < 2**32 for seed in seeds)
    assert seeds == [derived_seed(0, *picture) for picture in pictures]
    assert derived_seed(1, *pictures[0]) != seeds[0]


def test_a_seed_depends_on_what_a_value_holds() -> None:
    assert derived_seed(0, Pose("a", 1.0)) != derived_seed(0, Pose("a", 2.0))


def test_a_recipe_costs_nothing_heavy() -> None:
    script = "import sys, lrsr.pictures.recipe; print(*{'torch', 'mitsuba'} & set(sys.modules))"
    loaded = subprocess.run([sys.executable, "-c", script], capture_output=True, check=True)
    assert loaded.stdout == b"\n"
