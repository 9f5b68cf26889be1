from functools import cache
from typing import Any

import numpy as np
import pytest

from lrsr.errors import InputError
from lrsr.presets import preset
from lrsr.rendering.environment import environment
from lrsr.training.variety import Variety

POSES = ["frontal", "up", "down", "left"]
LIGHTINGS = ["frontal", "above", "below", "side"]
EXPRESSIONS = ["blink", "frown", "grin", "mouth_open", "smile", "squint", "surprise"]


named = cache(preset)  # hundreds of varieties are made of the same few files


def variety(**changes: Any) -> Variety:
    given = {
        "poses": [named("pose", name) for name in POSES],
        "lightings": [named("lighting", name) for name in LIGHTINGS],
        "expressions": [named("expression", name) for name in EXPRESSIONS],
        "named_share": 0.3,
        "expression_share": 1.0,
        "turned_deg": [35, 20, 5],
    }
    return Variety(**{**given, **changes})


def test_the_same_generator_gives_the_same_pose_light_and_face() -> None:
    one, two = np.random.default_rng(5), np.random.default_rng(5)
    for draw in (variety().pose, variety().lighting, variety().expression):
        assert draw(one) == draw(two)


def test_poses_stay_within_their_ranges_and_named_ones_occur() -> None:
    poses = [variety().pose(np.random.default_rng(seed)) for seed in range(300)]
    assert max(abs(pose.yaw_deg) for pose in poses) <= 35
    assert max(abs(pose.pitch_deg) for pose in poses) <= 20
    assert max(abs(pose.roll_deg) for pose in poses) <= 5
    assert {pose.name for pose in poses} == {*POSES, "random"}


def test_every_light_can_be_metered() -> None:
    lights = [variety().lighting(np.random.default_rng(seed)) for seed in range(40)]
    assert all(environment(light)[1] > 0 for light in lights)
    assert {light.name for light in lights} == {*LIGHTINGS, "random"}


def test_expressions_are_mild_and_eyes_stay_open() -> None:
    rng = np.random.default_rng(0)
    faces = [variety().expression(rng) for _ in range(100)]
    assert max(max(face.units.values(), default=0.0) for face in faces) < 0.8
    assert 0.2 < max(face.units.get("eyeBlinkLeft", 0.0) for face in faces) < 0.5
    assert len({tuple(face.units) for face in faces}) > 7


def test_a_share_of_the_faces_acts() -> None:
    rng, some = np.random.default_rng(0), variety(expression_share=0.5)
    acting = sum(bool(some.expression(rng).units) for _ in range(100))
    assert 30 < acting < 70
    assert not variety(expression_share=0).expression(rng).units


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"expression_share": 1.5}, "data.variety.expression_share=1.5: wanted 0 to 1"),
        ({"named_share": -1}, "data.variety.named_share=-1.0: wanted 0 to 1"),
        (
            {"turned_deg": [35, 20]},
            r"data.variety.turned_deg=\[35.0, 20.0\]: wanted yaw, pitch, roll",
        ),
        ({"poses": []}, r"data.variety.poses=\[\]: wanted at least one"),
    ],
    ids=str,
)
def test_impossible_settings_are_refused(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        variety(**wrong)
