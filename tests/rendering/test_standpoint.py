"""Cameras above the door: heights, distances, the IPD and where landmarks fall."""

import math
from dataclasses import replace

import numpy as np
import pytest
from fakes.scenes import STANDPOINTS, Studio
from oracles.heads import dots, stand_in

from lrsr.errors import InputError
from lrsr.presets import preset
from lrsr.rendering.geometry import Viewpoint, place_camera
from lrsr.rendering.lighting import Lighting
from lrsr.rendering.pose import Pose
from lrsr.rendering.standpoint import Standpoint

CLOUDY = Lighting("cloudy", (), fill_share=1.0)
PUPILS = np.array([[-31.5, 0.0, 0.0], [31.5, 0.0, 0.0]])


def test_scface_looks_down_on_a_standing_subject() -> None:
    far = STANDPOINTS["scface_far"]
    viewpoint = place_camera(PUPILS, 8, camera_m=far.camera_m, above_m=far.above_m)
    # 2.25 m of camera over 1.6 m of eyes, 4.2 m away along the floor
    assert viewpoint.elevation_deg == pytest.approx(math.degrees(math.atan2(0.65, 4.2)))
    assert viewpoint.centre_mm[1] == pytest.approx(650, abs=15)  # the frame is 12.6 mm lower
    assert viewpoint.centre_mm[2] == pytest.approx(4200, abs=3)


@pytest.mark.parametrize("name", STANDPOINTS)
@pytest.mark.parametrize("ipd_px", [8.0, 21.5])
def test_every_standpoint_keeps_the_ipd(name: str, ipd_px: float) -> None:
    place = STANDPOINTS[name]
    uneven = np.array([[-33.0, 0.4, 0.3], [30.0, -0.5, -0.2]])
    viewpoint = place_camera(uneven, ipd_px, camera_m=place.camera_m, above_m=place.above_m)
    left, right = viewpoint.project(uneven)
    assert np.hypot(*(right - left)) == pytest.approx(ipd_px, abs=1e-3)


def test_from_above_the_chin_comes_nearer_to_the_eyes_and_the_crown_shows() -> None:
    face = np.array([[0.0, 0.0, 0.0], [0.0, -110.0, 0.0], [0.0, 110.0, -90.0]])
    level, high = (
        place_camera(PUPILS, 32, camera_m=1.2, above_m=above).project(face)[:, 1]
        for above in (0.0, 0.65)
    )
    assert (high - level)[1] - (high - level)[0] < -5  # less face below the eyes: y grows downwards
    assert high[2] - high[0] < level[2] - level[0] - 5  # more head above them


def test_projection_is_that_of_rotated_points() -> None:
    viewpoint = Viewpoint(np.array([100.0, 500.0, 900.0]), 32, 1000.0, elevation_deg=30.0)
    points = np.random.default_rng(0).uniform(-80, 80, (20, 3))
    tilt = math.radians(30)
    turn = np.array(
        [[1, 0, 0], [0, math.cos(tilt), -math.sin(tilt)], [0, math.sin(tilt), math.cos(tilt)]]
    )
    level = Viewpoint(np.zeros(3), 32, 1000.0)
    wanted = level.project((points - viewpoint.centre_mm) @ turn.T)
    np.testing.assert_allclose(viewpoint.project(points), wanted)
    local = (
        np.pad(points, ((0, 0), (0, 1)), constant_values=1) @ np.linalg.inv(viewpoint.to_world()).T
    )
    np.testing.assert_allclose(viewpoint.depth_mm(points), -local[:, 2])
    np.testing.assert_allclose(level.project(local[:, :3]), wanted)


@pytest.fixture(scope="module")
def dot_renderer() -> Studio:
    """Return a renderer of its own for the dots, whose scene is loaded once."""
    return Studio()


@pytest.mark.parametrize("f_number", [None, 8.0], ids=["pinhole", "double gauss"])
@pytest.mark.parametrize("pose", ["frontal", "left"])
def test_landmarks_are_where_the_picture_shows_them(
    dot_renderer: Studio, pose: str, f_number: float | None
) -> None:
    result = dot_renderer.render(
        dots(stand_in(3).landmarks),
        pose=pose,
        lighting=CLOUDY,
        ipd_px=16,
        scale=4,
        samples_per_pixel=1024,
        standpoint="scface_near",
        lens=preset("lens", "double_gauss", f_number=f_number) if f_number else "pinhole",
    )
    darkness = 1 - result.image[1].numpy() / result.image[1].numpy().max()
    for x, y in result.landmarks_px.numpy():
        column, row = round(float(x)), round(float(y))
        window = darkness[row - 7 : row + 8, column - 7 : column + 8].clip(0.05) - 0.05
        seen = (np.mgrid[-7:8, -7:8] * window).sum(axis=(1, 2)) / window.sum()
        assert seen == pytest.approx([y - row, x - column], abs=0.15)


def test_a_pose_turns_the_high_camera_around_the_head(dot_renderer: Studio) -> None:
    """A chin lifted by the camera's elevation shows the camera the face from the front."""
    place = STANDPOINTS["scface_near"]
    lifted = Pose("lifted", pitch_deg=math.degrees(math.atan2(place.above_m, 1.0)))
    points = stand_in(3).landmarks
    ask = {"lighting": CLOUDY, "ipd_px": 16.0, "samples_per_pixel": 64}
    high = dot_renderer.render(dots(points), pose=lifted, standpoint=place, **ask)
    level = dot_renderer.render(dots(points), camera_m=place.camera_m, **ask)
    shape = [result.landmarks_px - result.landmarks_px.mean(0) for result in (high, level)]
    np.testing.assert_allclose(shape[0], shape[1], atol=0.5)


def test_names_do_not_matter_to_what_is_recorded() -> None:
    assert Standpoint("a", 4.2, 2.25).record() == STANDPOINTS["scface_far"].record()
    higher = replace(STANDPOINTS["scface_far"], height_m=2.5)
    assert higher.record() != Standpoint("a", 4.2, 2.25).record()


@pytest.mark.parametrize(
    ("broken", "message"),
    [
        ({"distance_m": 0.0}, r"standpoint\.distance_m=0: wanted a distance > 0"),
        ({"height_m": math.inf}, r"standpoint\.height_m=inf: wanted a number"),
        ({"eye_height_m": math.nan}, r"standpoint\.eye_height_m=nan: wanted a number"),
    ],
    ids=["distance", "height", "eyes"],
)
def test_a_standpoint_refuses_what_cannot_be(broken: dict[str, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Standpoint("bad", **broken)


def test_a_camera_cannot_be_higher_than_it_is_far(dot_renderer: Studio) -> None:
    ask = {"ipd_px": 64.0, "standpoint": Standpoint("tower", height_m=30.0)}
    with pytest.raises(InputError, match=r"'tower': a camera 28\.4 m above the eyes cannot be 1"):
        dot_renderer.render(dots(stand_in(0).landmarks), **ask)
