import numpy as np
from lrsr.data.variety import random_expression, random_lighting, random_pose

from lrsr.rendering.scene import LIGHTINGS, POSES, environment


def test_the_same_generator_gives_the_same_pose_and_light() -> None:
    one, two = np.random.default_rng(5), np.random.default_rng(5)
    assert random_pose(one) == random_pose(two)
    assert random_lighting(one) == random_lighting(two)


def test_poses_stay_within_their_ranges_and_named_ones_occur() -> None:
    poses = [random_pose(np.random.default_rng(seed)) for seed in range(300)]
    assert max(abs(pose.yaw_deg) for pose in poses) <= 35
    assert max(abs(pose.pitch_deg) for pose in poses) <= 20
    assert max(abs(pose.roll_deg) for pose in poses) <= 5
    assert {pose.name for pose in poses} == {*POSES, "random"}


def test_every_light_can_be_metered() -> None:
    lights = [random_lighting(np.random.default_rng(seed)) for seed in range(40)]
    assert all(environment(light)[1] > 0 for light in lights)
    assert {light.name for light in lights} == {*LIGHTINGS, "random"}


def test_expressions_are_mild_and_eyes_stay_open() -> None:
    rng = np.random.default_rng(0)
    faces = [random_expression(rng) for _ in range(100)]
    assert max(max(face.units.values(), default=0.0) for face in faces) < 0.8
    assert 0.2 < max(face.units.get("eyeBlinkLeft", 0.0) for face in faces) < 0.5
    assert len({tuple(face.units) for face in faces}) > 7
    assert random_expression(np.random.default_rng(3)) == random_expression(
        np.random.default_rng(3)
    )
