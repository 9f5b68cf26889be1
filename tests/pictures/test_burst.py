"""Frames lie within the ranges that were asked for, and follow from seed, person and number."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from fakes.scenes import POSES, recipe

from lrsr.errors import InputError
from lrsr.identities.face.expression import NEUTRAL, Expression
from lrsr.pictures.burst import STILL, Burst
from lrsr.pictures.recipe import Recipe
from lrsr.presets import preset, presets

FIRST = recipe(3, pose="left", samples_per_pixel=64)
MOVING = Burst(
    "test", 0.1, 0.02, yaw_deg=2, pitch_deg=1, roll_deg=0.5, units={"jawOpen": 0.3, "eyeBlink": 0.2}
)


def frames(first: Recipe = FIRST, seed: int = 0, count: int = 200) -> list[Recipe]:
    return [MOVING.frame(first, number, seed) for number in range(1, count)]


def test_the_first_frame_is_the_recipe() -> None:
    assert MOVING.frame(FIRST, 0, 0) is FIRST


def test_who_holds_still_differs_in_nothing() -> None:
    assert STILL.frame(FIRST, 5, 0) == FIRST == preset("burst", "still").frame(FIRST, 5, 0)


def test_all_that_moves_fills_its_range_and_leaves_it_never() -> None:
    drawn = frames()
    ranges = {
        0.8: [one.film.shift_px[0] for one in drawn],
        0.80001: [one.film.shift_px[1] for one in drawn],
        0.02: [one.film.nearer for one in drawn],
        2.0: [one.scene.pose.yaw_deg - POSES["left"].yaw_deg for one in drawn],
        1.0: [one.scene.pose.pitch_deg for one in drawn],
        0.5: [one.scene.pose.roll_deg for one in drawn],
    }
    for reach, values in ranges.items():
        assert 0.9 * reach < np.abs(values).max() <= reach + 1e-9
        assert abs(np.mean(values)) < 4 * reach / np.sqrt(3 * len(values))
    opened = [one.scene.expression.units["jawOpen"] for one in drawn]
    assert 0 < min(opened) < max(opened) <= 0.3
    assert {*drawn[0].scene.expression.units} == {"eyeBlinkLeft", "eyeBlinkRight", "jawOpen"}


def test_a_person_moves_alike_under_every_light_and_on_every_film() -> None:
    lit = recipe(3, pose="left", lighting="below", scale=4)
    for here, there in zip(frames(count=4), frames(lit, count=4), strict=True):
        assert there.scene.pose == here.scene.pose
        assert there.scene.expression == here.scene.expression
        assert there.film == replace(here.film, scale=4)


def test_another_person_frame_or_seed_moves_otherwise() -> None:
    others = [*frames(count=3), *frames(recipe(4, pose="left"), count=3), *frames(seed=1, count=3)]
    assert len({one.film.shift_px for one in others}) == 6


def test_what_a_face_does_is_added_to_what_it_did() -> None:
    smiling = recipe(3, expression=Expression("half", {"jawOpen": 0.9}))
    added = [
        (then.scene.expression.units["jawOpen"], now.scene.expression.units["jawOpen"])
        for then, now in zip(frames(recipe(3)), frames(smiling), strict=True)
    ]
    assert all(now == pytest.approx(min(1.0, 0.9 + then), abs=1e-4) for then, now in added)
    assert NEUTRAL.adding({}) == NEUTRAL


@pytest.mark.parametrize("name", presets("burst"))
def test_every_shipped_burst_is_one(name: str) -> None:
    assert preset("burst", name).name == name


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"shift_ipds": 0.25}, "burst.shift_ipds=0.25: wanted 0 to 0.24"),
        ({"nearer": -0.1}, "burst.nearer=-0.1: wanted 0 to 0.5"),
        ({"yaw_deg": 91}, "burst.yaw_deg=91: wanted 0 to 90"),
        ({"roll_deg": "a"}, "burst.roll_deg=a: wanted a number"),
        ({"units": {"jawOpened": 0.1}}, "face unit 'jawOpened' does not exist"),
        ({"units": {"jawOpen": 1.1}}, "expression.jawOpen=1.1: wanted 0 to 1"),
        ({"units": 3}, "burst.units=3: wanted burst.units.SETTING="),
    ],
    ids=str,
)
def test_a_burst_that_cannot_be_is_refused(wrong: dict[str, Any], says: str) -> None:
    with pytest.raises(InputError, match=says):
        Burst(**wrong)
