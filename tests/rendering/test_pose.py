"""Poses: directions, the pivot, and what is refused."""

import numpy as np
import pytest
from fakes.scenes import POSES

from lrsr.errors import InputError
from lrsr.rendering.pose import PIVOT_MM, Pose


@pytest.mark.parametrize(
    ("pose", "nose", "crown"),
    [
        (Pose("left", yaw_deg=90), (1, 0, 0), (0, 1, 0)),
        (Pose("up", pitch_deg=90), (0, 1, 0), (0, 0, -1)),
        (Pose("tipped", roll_deg=90), (0, 0, 1), (1, 0, 0)),
    ],
    ids=lambda value: getattr(value, "name", ""),
)
def test_positive_angles_turn_as_documented(pose: Pose, nose: tuple, crown: tuple) -> None:
    np.testing.assert_allclose(pose.rotation() @ [0, 0, 1], nose, atol=1e-12)
    np.testing.assert_allclose(pose.rotation() @ [0, 1, 0], crown, atol=1e-12)


def test_a_pose_is_rigid() -> None:
    rotation = Pose("any", 33, -21, 8).rotation()
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(rotation) == pytest.approx(1)


def test_the_pivot_stays_where_it_is() -> None:
    np.testing.assert_allclose(Pose("any", 33, -21, 8).turn(PIVOT_MM[None]), PIVOT_MM[None])


def test_a_frontal_head_does_not_move() -> None:
    assert POSES["frontal"].frame_offset_mm() == (0.0, 0.0)


@pytest.mark.parametrize("angle", [float("nan"), float("inf"), "steep", True], ids=str)
def test_a_pose_refuses_what_is_no_angle(angle: float) -> None:
    with pytest.raises(InputError, match=rf"(?i)pose\.yaw_deg={angle}: wanted a number"):
        Pose("broken", yaw_deg=angle)


def test_no_head_turns_round_twice() -> None:
    with pytest.raises(InputError, match=r"pose\.pitch_deg=-200\.0: wanted -180 to 180 degrees"):
        Pose("own", 180, -200)
