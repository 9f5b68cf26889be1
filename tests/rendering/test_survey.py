"""An egg with eyes whose distances, normals and parts are known by formula."""

from dataclasses import replace

import numpy as np
import pytest
from fakes.scenes import Studio, scene
from oracles.heads import ellipsoid_part, stand_in

from lrsr.errors import InputError
from lrsr.identities.head import Head
from lrsr.rendering.geometry import place_camera
from lrsr.rendering.pose import Pose
from lrsr.rendering.scene import Film
from lrsr.rendering.survey import Survey

FILM = Film(32)
RADIUS_MM = 80.0


@pytest.fixture(scope="module")
def seen(renderer: Studio) -> Survey:
    return renderer.survey(stand_in(), scene(), FILM)


@pytest.fixture(scope="module")
def sphere() -> Head:
    ball = ellipsoid_part(
        "skin", "skin", (RADIUS_MM,) * 3, (0, 0, -60), np.ones((2, 2, 3)), 96, 192
    )
    return replace(stand_in(ipd_mm=64.0), parts=(ball,))


def test_the_pupils_are_as_far_away_as_the_camera_stands(renderer: Studio) -> None:
    head = replace(stand_in(), parts=stand_in().parts[1:])  # the egg's shell covers them
    seen = renderer.survey(head, scene(), FILM)
    viewpoint = place_camera(head.pupils, FILM.ipd_px)
    for (x, y), depth_mm in zip(
        np.rint(viewpoint.project(head.pupils)).astype(int),
        viewpoint.depth_mm(head.pupils),
        strict=True,
    ):
        assert 1000 * seen.depth_m[y, x] == pytest.approx(depth_mm, abs=0.2)  # of facets


@pytest.mark.parametrize("pose", ["frontal", "left", "up"])
def test_a_spheres_normals_and_depth_are_those_of_the_formula(
    renderer: Studio, sphere: Head, pose: str
) -> None:
    seen = renderer.survey(sphere, scene(pose), FILM)
    side = len(seen.depth_m)
    slope = (np.arange(side) - side / 2 + 0.5) / seen.focal_px
    x, y = np.meshgrid(slope, -slope)
    depth_mm = 1000 * seen.depth_m.astype(float)
    points = np.stack([x * depth_mm, y * depth_mm, -depth_mm], axis=-1)
    centre = seen.to_camera[:3, :3] @ [0, 0, -60] + seen.to_camera[:3, 3]
    offset = (points - centre)[seen.parts > 0]
    distance = np.linalg.norm(offset, axis=1)
    np.testing.assert_allclose(distance, RADIUS_MM, atol=0.06)  # of facets
    facing = (offset / distance[:, None] * seen.normals[seen.parts > 0]).sum(axis=1)
    assert facing.min() > np.cos(np.deg2rad(1.0))
    widest = 2 * RADIUS_MM * seen.focal_px / -centre[2]
    assert np.ptp(np.flatnonzero(seen.parts.any(axis=0))) == pytest.approx(widest, abs=2)


def test_normals_have_length_one_and_look_at_the_camera(seen: Survey) -> None:
    inside = seen.parts > 0
    np.testing.assert_allclose(np.linalg.norm(seen.normals[inside], axis=1), 1, atol=1e-5)
    assert (seen.normals[inside, 2] > -0.2).all()
    assert not seen.normals[~inside].any()
    assert not seen.depth_m[~inside].any()


def test_masks_partition_the_frame(seen: Survey) -> None:
    masks = np.stack([seen.parts == 0, *(seen.mask(name) for name in seen.names)])
    assert (masks.sum(axis=0) == 1).all()
    assert masks.any(axis=(1, 2)).all()
    left, right = (seen.mask(f"{side}_eye_ball").nonzero()[1].mean() for side in ("left", "right"))
    assert left < right


def test_a_finer_film_sees_the_same_with_more_pixels(renderer: Studio, sphere: Head) -> None:
    coarse = renderer.survey(sphere, scene(), FILM)
    fine = renderer.survey(sphere, scene(), replace(FILM, scale=2))
    assert fine.focal_px == pytest.approx(2 * coarse.focal_px)
    side = len(coarse.depth_m)
    depth = fine.depth_m.reshape(side, 2, side, 2).mean(axis=(1, 3))
    middle = np.s_[48:80, 48:80]
    np.testing.assert_allclose(depth[middle], coarse.depth_m[middle], atol=5e-5)


def test_the_flow_is_where_the_points_of_the_head_go(renderer: Studio, sphere: Head) -> None:
    pose, film = Pose("turned", 8, -5, 3), replace(FILM, shift_px=(2.5, -1.25), nearer=0.02)
    first = renderer.survey(sphere, scene(), FILM)
    flow = first.flow(renderer.survey(sphere, scene(pose), film))
    assert (np.isnan(flow).all(axis=2) == (first.parts == 0)).all()
    there = place_camera(
        sphere.pupils,
        film.ipd_px,
        offset_mm=pose.frame_offset_mm(),
        nearer=film.nearer,
        shift_px=film.shift_px,
    )
    here = place_camera(sphere.pupils, FILM.ipd_px)
    for x, y in ((64, 60), (50, 70), (80, 52)):
        ray = np.array([x - first.axis_px[0], first.axis_px[1] - y, -first.focal_px])
        ray /= np.linalg.norm(ray)
        offset = here.centre_mm - [0, 0, -60]
        along = -ray @ offset
        reach = along - np.sqrt(along**2 - offset @ offset + RADIUS_MM**2)
        (wanted,) = there.project(pose.turn((here.centre_mm + reach * ray)[None]))
        np.testing.assert_allclose(flow[y, x], wanted - (x, y), atol=0.01)


def test_the_light_does_not_matter_and_lamps_are_nothing(renderer: Studio, seen: Survey) -> None:
    lit = renderer.survey(stand_in(), scene(lighting="room_blue"), FILM)
    np.testing.assert_array_equal(lit.parts, seen.parts)
    np.testing.assert_allclose(lit.depth_m, seen.depth_m, atol=1e-6)


def test_a_lens_that_bends_light_is_refused(renderer: Studio) -> None:
    with pytest.raises(InputError, match="lens=single: what lies behind a pixel"):
        renderer.survey(stand_in(), scene(lens="single"), FILM)


def test_an_unknown_part_has_no_mask(seen: Survey) -> None:
    with pytest.raises(ValueError, match="hat"):
        seen.mask("hat")
