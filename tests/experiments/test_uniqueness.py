import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from fakes.configurations import composed
from fakes.dlib_parts import install_dlib, remove_dlib
from fakes.twins import TwinMaker

from lrsr.camera import Camera
from lrsr.errors import InputError
from lrsr.experiments.uniqueness import (
    _NEAREST,
    Findings,
    Gallery,
    UniquenessSettings,
    find_distinct,
    make_roster,
    summary,
)
from lrsr.identities.morphable import RECIPE_VERSION
from lrsr.identities.population import Population
from lrsr.identities.roster import IdentityRange, Roster, write_roster
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.render import take_pictures
from lrsr.pictures.sitting import Sitting, read_gallery
from lrsr.presets import preset
from lrsr.recognition import Engine
from lrsr.rendering.scene import Film, Quality, Scene

FRONTAL = Scene(preset("lighting", "frontal"))
QUALITY = Quality(samples_per_pixel=4, texture_size=64)


def enrolled(people: IdentityRange) -> Sitting:
    return Sitting(people, FRONTAL, Film(16.0), QUALITY, "gallery")


SETTINGS = UniquenessSettings(
    gallery=enrolled(IdentityRange(count=8)),
    encoder="shipped",
    smallest_angle_deg=20.0,
    most_redraws=3,
    camera=Camera("heavy"),
)
TWINS = {(5, 0): 2}
TRIPLETS = {(5, 0): 2, (5, 1): 0, (6, 0): 2}


def gallery(
    folder: Path, model: Path, maker: TwinMaker, settings: UniquenessSettings = SETTINGS
) -> Gallery:
    cache = RenderCache(folder / "cache")
    return Gallery(settings, cache, Engine(model), maker, progress=False)


def find(
    folder: Path, model: Path, looks: dict[tuple[int, int], int], **changes: Any
) -> tuple[UniquenessSettings, Findings]:
    settings = replace(SETTINGS, **changes)
    return settings, find_distinct(settings, gallery(folder, model, TwinMaker(looks), settings))


def configured(*overrides: str) -> UniquenessSettings:
    return UniquenessSettings.from_config(composed("identities", *overrides))


def test_people_who_differ_stay_as_they_were_drawn(tmp_path: Path, tone_model: Path) -> None:
    _, findings = find(tmp_path, tone_model, {})
    assert findings.drawn == tuple((index, 0) for index in range(8))
    assert findings.outcome.rejected == ()
    assert findings.angles_deg.min() > 20
    np.testing.assert_array_equal(findings.angles_deg, findings.first_angles_deg)


def test_a_look_alike_is_redrawn(tmp_path: Path, tone_model: Path) -> None:
    _, findings = find(tmp_path, tone_model, TWINS)
    assert findings.outcome.draws == (0, 0, 0, 0, 0, 1, 0, 0)
    assert findings.first_angles_deg.min() < 20 <= findings.angles_deg.min()
    assert findings.people[5].age_years == 31.0  # who is left is described, not who was dismissed


def test_the_outcome_does_not_depend_on_how_many_follow(tmp_path: Path, tone_model: Path) -> None:
    draws = [
        find(tmp_path, tone_model, TRIPLETS, gallery=enrolled(IdentityRange(count=count)))[
            1
        ].outcome.draws
        for count in (6, 8)
    ]
    assert draws[0] == draws[1][:6] == (0, 0, 0, 0, 0, 2)


def test_the_pictures_are_those_that_verification_enrols(tmp_path: Path, tone_model: Path) -> None:
    roster = Roster("test", 0, 8, Population("female"), RECIPE_VERSION, "dlib", 11.2, {3: 2})
    path = write_roster(tmp_path / "roster.json", roster)
    words = ["identities.count=8", "identities.sex=female", f"identities.roster={path}"]
    ours = gallery(tmp_path, tone_model, TwinMaker(), configured(*words))
    theirs = read_gallery(composed("eval", *words))
    assert [ours.recipe((index, 0)) for index in range(8)] == theirs.recipes()


def test_a_redraw_is_counted_on_from_the_roster(tmp_path: Path, tone_model: Path) -> None:
    roster = Roster("test", 0, 8, Population(), RECIPE_VERSION, "dlib", 11.2, {3: 2})
    path = write_roster(tmp_path / "roster.json", roster)
    people = IdentityRange(count=8, roster=str(path))
    made = gallery(tmp_path, tone_model, TwinMaker(), replace(SETTINGS, gallery=enrolled(people)))
    assert made.recipe((3, 1)).person.id == "test-00003-draw3"
    assert made.recipe((4, 1)).person.id == "test-00004-draw1"


def test_nobody_is_rendered_twice(tmp_path: Path, tone_model: Path) -> None:
    maker = TwinMaker(TWINS)
    made = gallery(tmp_path, tone_model, maker)
    find_distinct(SETTINGS, made)
    made.source([(5, 0), (5, 1)]).load(0, 2)
    assert len(maker.rendered) == len(set(maker.rendered)) == 9


def test_enrolled_pictures_are_not_compressed(tmp_path: Path, tone_model: Path) -> None:
    source = gallery(tmp_path, tone_model, TwinMaker()).source([(0, 0)])
    assert (source.camera.compression, source.recipes[0].film) == ("none", Film(16.0))
    cache, clean = RenderCache(tmp_path / "cache"), Camera("none")
    (plain,) = take_pictures(source.recipes, cache, clean, maker=TwinMaker())
    assert torch.equal(source.load(0, 1)[0].image, plain.image)


def test_rows_come_in_the_order_that_was_asked_for(tmp_path: Path, tone_model: Path) -> None:
    made = gallery(tmp_path, tone_model, TwinMaker())
    rows = made.embed([(2, 0), (0, 0), (1, 0)])
    assert rows.shape == (3, 147)
    for row, one in zip(rows, [(2, 0), (0, 0), (1, 0)], strict=True):
        np.testing.assert_array_equal(row, made.embeddings[one])
        assert made.people[one] is not None


def test_who_cannot_be_told_apart_is_reported(tmp_path: Path, tone_model: Path) -> None:
    looks = {(5, draw): 2 for draw in range(4)}
    settings, findings = find(tmp_path, tone_model, looks)
    (stuck,) = summary(findings)["unresolved"]
    assert stuck.startswith("test-00005")
    roster = make_roster(settings, findings, RECIPE_VERSION)
    assert roster.unresolved == (5,)


def test_a_roster_says_who_was_redrawn_and_how_often(tmp_path: Path, tone_model: Path) -> None:
    settings, findings = find(tmp_path, tone_model, TRIPLETS)
    assert make_roster(settings, findings, RECIPE_VERSION) == Roster(
        "test", 0, 8, Population(), RECIPE_VERSION, "shipped", 20.0, {5: 2, 6: 1}
    )


def test_a_roster_gone_on_from_leads_to_itself(tmp_path: Path, tone_model: Path) -> None:
    settings, findings = find(tmp_path, tone_model, TRIPLETS)
    roster = make_roster(settings, findings, RECIPE_VERSION)
    path = write_roster(tmp_path / "roster.json", roster)
    people = IdentityRange(count=8, roster=str(path))
    settings, again = find(tmp_path, tone_model, TRIPLETS, gallery=enrolled(people))
    assert set(again.outcome.draws) == {0}
    assert make_roster(settings, again, RECIPE_VERSION) == roster
    np.testing.assert_array_equal(again.angles_deg, findings.angles_deg)


def test_a_summary_names_pairs_and_the_dismissed(tmp_path: Path, tone_model: Path) -> None:
    _, findings = find(
        tmp_path, tone_model, TRIPLETS, gallery=enrolled(IdentityRange(start=2, count=6))
    )
    told = summary(findings)
    assert told["people"] == told["compared"] == 6
    assert told["angles_deg"]["pairs"] == 15
    assert [(line["who"], line["too_near_to"]) for line in told["rejected"]] == [
        ("test-00005", "test-00002"),
        ("test-00006", "test-00002"),
    ]
    assert all(line["angle_deg"] < 20 for line in told["rejected"])
    names = {"test-00002", "test-00003", "test-00004", "test-00005-draw1", "test-00006-draw1"}
    shown = {pair[end] for pair in told["nearest_pairs"] for end in ("first", "second")}
    assert shown == {*names, "test-00007"}


def test_the_histogram_counts_every_pair_once(tmp_path: Path, tone_model: Path) -> None:
    _, findings = find(tmp_path, tone_model, {})
    told = summary(findings)
    assert sum(told["histogram"]["pairs"]) == told["angles_deg"]["pairs"] == 28
    edges = told["histogram"]["edges_deg"]
    assert (edges[0], edges[-1], len(edges)) == (0.0, 180.0, 181)
    for low, count in zip(edges, told["histogram"]["pairs"], strict=False):
        assert count == ((low <= findings.angles_deg) & (findings.angles_deg < low + 1)).sum()


def test_the_nearest_pairs_are_few_and_sorted(tmp_path: Path, tone_model: Path) -> None:
    told = summary(find(tmp_path, tone_model, {})[1])
    angles = [pair["angle_deg"] for pair in told["nearest_pairs"]]
    assert len(angles) == _NEAREST
    assert angles == sorted(angles)
    assert angles[0] == pytest.approx(told["angles_deg"]["min"], abs=1e-3)


@pytest.mark.parametrize("count", [1, 2, 8])
def test_a_summary_survives_json(tmp_path: Path, tone_model: Path, count: int) -> None:
    told = summary(find(tmp_path, tone_model, {}, gallery=enrolled(IdentityRange(count=count)))[1])
    assert json.loads(json.dumps(told, allow_nan=False)) == told


def test_one_person_alone_is_compared_with_nobody(tmp_path: Path, tone_model: Path) -> None:
    told = summary(find(tmp_path, tone_model, {}, gallery=enrolled(IdentityRange(count=1)))[1])
    assert (told["people"], told["compared"]) == (1, 0)
    assert told["angles_deg"] == {"pairs": 0}
    assert told["nearest_pairs"] == []


def test_no_smallest_angle_describes_everybody_as_drawn(tmp_path: Path, tone_model: Path) -> None:
    _, findings = find(tmp_path, tone_model, TWINS, smallest_angle_deg=0.0)
    assert set(findings.outcome.draws) == {0}
    (first, second) = (findings.pairs[0].first, findings.pairs[0].second)
    assert (first, second) == (2, 5)


@pytest.mark.parametrize(
    ("installed", "encoder", "angle"), [(True, "dlib", 11.2), (False, "shipped", 20.0)]
)
def test_auto_takes_dlib_and_its_angle_where_it_is(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, installed: bool, encoder: str, angle: float
) -> None:
    if installed:
        install_dlib(monkeypatch, tmp_path)
    else:
        remove_dlib(monkeypatch)
    settings = configured()
    assert (settings.encoder, settings.smallest_angle_deg) == (encoder, angle)
    assert settings.gallery.people.count == 60


def test_a_given_angle_stays() -> None:
    assert configured("encoder=shipped", "smallest_angle_deg=0").smallest_angle_deg == 0.0
    assert configured("encoder=shipped", "smallest_angle_deg=7.5").smallest_angle_deg == 7.5


@pytest.mark.parametrize(
    ("overrides", "says"),
    [
        (["encoder=facenet"], "encoder=facenet: wanted one of auto"),
        (["smallest_angle_deg=90"], "smallest_angle_deg=90.0: wanted 0 to 90"),
        (["smallest_angle_deg=-1"], "smallest_angle_deg=-1.0: wanted 0 to 90"),
        (["smallest_angle_deg=nan"], "smallest_angle_deg=nan: wanted a number"),
        (["smallest_angle_deg=wide"], "smallest_angle_deg=wide: wanted a number"),
        (["most_redraws=-1"], "most_redraws=-1: wanted at least 0"),
        (["most_redraws=1.5"], "most_redraws=1.5: wanted a whole number"),
        (["identities.count=0"], "identities.count=0: wanted at least 1"),
        (["identities.sex=woman"], "identities.sex=woman"),
        (["identities.roster=none.json"], "cannot read none.json"),
        (["gallery.ipd_px=2"], "gallery.ipd_px=2.*: wanted at least 4"),
    ],
    ids=lambda value: value[0] if isinstance(value, list) else None,
)
def test_a_setting_out_of_range_is_named_with_what_was_wanted(
    overrides: list[str], says: str
) -> None:
    with pytest.raises(InputError, match=says):
        configured(*(["encoder=shipped"] if "encoder" not in overrides[0] else []), *overrides)
