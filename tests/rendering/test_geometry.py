"""The arithmetic of the reference camera, against its data sheet and the paper."""

import math

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from lrsr.images import scale_points
from lrsr.rendering.geometry import (
    _FRAME_DROP_IPDS,
    AXIS_P1435LE,
    Viewpoint,
    distance_m,
    film_size_px,
    place_camera,
    world_to_head,
)
from lrsr.rendering.pose import Pose

PUPILS = np.array([[-31.5, 0.0, 0.0], [31.5, 0.0, 0.0]])


def ipd_on_film(viewpoint: Viewpoint, pupils: np.ndarray, scale: int = 1) -> float:
    left, right = viewpoint.project(pupils, scale)
    return float(np.hypot(*(right - left)))


def test_a_pixel_is_as_high_as_the_data_sheet_makes_it() -> None:
    # 51° over 1080 rows behind 3 mm
    height_um = 2 * 3000 * math.tan(math.radians(51 / 2)) / 1080
    assert AXIS_P1435LE.pitch_um == pytest.approx(height_um, abs=0.01)


def test_eight_pixels_are_nine_metres_away() -> None:
    assert distance_m(8, 63.0) == pytest.approx(8.9, abs=0.05)


@given(st.floats(1, 200), st.floats(50, 80))
def test_half_the_distance_doubles_the_pixels(ipd_px: float, ipd_mm: float) -> None:
    assert distance_m(2 * ipd_px, ipd_mm) == pytest.approx(distance_m(ipd_px, ipd_mm) / 2)


@pytest.mark.parametrize(("ipd_px", "ipd_mm"), [(0, 63), (-1, 63), (8, 0), (math.nan, 63)])
def test_distance_refuses_what_is_not_positive(ipd_px: float, ipd_mm: float) -> None:
    with pytest.raises(ValueError, match="must be positive"):
        distance_m(ipd_px, ipd_mm)


@pytest.mark.parametrize(("ipd_px", "side"), [(8, 32), (11, 44), (14, 56), (8.4, 32), (3, 16)])
def test_film_is_four_ipds_square(ipd_px: float, side: int) -> None:
    assert film_size_px(ipd_px) == side


def test_film_size_refuses_no_ipd() -> None:
    with pytest.raises(ValueError, match="must be positive"):
        film_size_px(0)


uneven = st.floats(-3, 3)


@given(st.floats(4, 128), st.floats(50, 80), uneven, uneven, st.sampled_from([1, 2, 4]))
def test_every_person_has_the_ipd_that_was_asked_for(
    ipd_px: float, ipd_mm: float, y: float, z: float, scale: int
) -> None:
    pupils = np.array([[-ipd_mm / 2, -y, z], [ipd_mm / 2, y, -z]])
    viewpoint = place_camera(pupils, ipd_px)
    assert ipd_on_film(viewpoint, pupils, scale) == pytest.approx(scale * ipd_px, abs=1e-3)


@given(st.floats(4, 128), st.floats(0.5, 20))
def test_a_given_distance_keeps_the_ipd(ipd_px: float, camera_m: float) -> None:
    viewpoint = place_camera(PUPILS, ipd_px, camera_m=camera_m)
    assert viewpoint.centre_mm[2] == pytest.approx(1000 * camera_m)
    assert ipd_on_film(viewpoint, PUPILS) == pytest.approx(ipd_px, abs=1e-6)


def test_the_camera_stands_where_the_reference_camera_must() -> None:
    assert place_camera(PUPILS, 8).centre_mm[2] == pytest.approx(1000 * distance_m(8, 63.0))


def test_the_frames_centre_is_below_the_pupils() -> None:
    middle = place_camera(PUPILS, 10).project(PUPILS).mean(axis=0)
    assert middle == pytest.approx([19.5, 19.5 - 10 * _FRAME_DROP_IPDS])


@pytest.mark.parametrize("scale", [2, 4])
def test_finer_films_show_the_same_frame(scale: int) -> None:
    points = np.random.default_rng(0).uniform(-80, 80, (20, 3))
    viewpoint = place_camera(PUPILS, 8)
    coarse = torch.from_numpy(viewpoint.project(points))
    expected = scale_points(coarse, scale).numpy()
    np.testing.assert_allclose(viewpoint.project(points, scale), expected)


def test_the_frame_follows_an_offset() -> None:
    still = place_camera(PUPILS, 8).project(PUPILS)
    moved = place_camera(PUPILS, 8, offset_mm=(63.0, 63.0)).project(PUPILS)
    np.testing.assert_allclose(moved - still, [[-8, 8], [-8, 8]], atol=1e-9)


@pytest.mark.parametrize("camera_m", [0.0, -1.0])
def test_camera_refuses_to_stand_in_the_face(camera_m: float) -> None:
    with pytest.raises(ValueError, match="distance must be positive"):
        place_camera(PUPILS, 8, camera_m=camera_m)


def test_the_camera_goes_back_where_the_head_came_from() -> None:
    pose = Pose("any", 33, -21, 8)
    points = np.random.default_rng(0).uniform(-100, 100, (10, 3))
    homogeneous = np.concatenate([pose.turn(points), np.ones((10, 1))], axis=1)
    np.testing.assert_allclose((homogeneous @ world_to_head(pose).T)[:, :3], points, atol=1e-9)
