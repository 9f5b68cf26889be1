"""Poses: directions, the pivot, names, and that conf says the same as the table."""

import numpy as np
import pytest
from hydra.utils import instantiate
from omegaconf import OmegaConf

from lrsr.errors import InputError
from lrsr.paths import config_folder
from lrsr.rendering.pose import PIVOT_MM, POSES, Pose, find_pose


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


def test_a_pose_refuses_nan() -> None:
    with pytest.raises(InputError, match="give finite numbers"):
        Pose("broken", yaw_deg=float("nan"))


def test_poses_are_found_by_name_and_changed() -> None:
    assert find_pose("left", yaw_deg=12.0) == Pose("left", yaw_deg=12.0)
    assert find_pose(Pose("own", 1.0)) == Pose("own", 1.0)


def test_an_unknown_pose_names_the_known() -> None:
    with pytest.raises(InputError, match="'sideways' does not exist; choose one of frontal, up"):
        find_pose("sideways")


def test_the_configuration_offers_exactly_the_table() -> None:
    files = {path.stem: path for path in (config_folder() / "pose").glob("*.yaml")}
    assert {name: instantiate(OmegaConf.load(path)) for name, path in files.items()} == POSES
