from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from lrsr.identities.morphable import template
from lrsr.identities.shape.basis import load_basis
from lrsr.identities.skin import regions
from lrsr.identities.skin.canvas import FloatMap


def _at(function: Callable[[FloatMap], FloatMap], *points: tuple[float, float, float]) -> FloatMap:
    return function(np.array(points, dtype=np.float32))


@pytest.mark.parametrize(
    ("outline", "within_mm"),
    [(regions._lip_outline(), 0.6), (regions._lid_rim(-1), 0.8), (regions._lid_rim(1), 0.8)],
    ids=["lips", "right eye", "left eye"],
)
def test_outlines_lie_on_the_template(outline: NDArray[np.float64], within_mm: float) -> None:
    skin = template().skin
    near = skin[(skin[:, 2] > -20) & (skin[:, 1] > -95) & (skin[:, 1] < 10)]
    distance = np.linalg.norm(near[:, None, :2] - outline[None], axis=2).min(axis=0)
    assert distance.max() < within_mm


def test_the_lids_close_around_the_templates_pupils() -> None:
    for side, pupil in ((-1, template().eyes.pupils[0]), (1, template().eyes.pupils[1])):
        rim = regions._lid_rim(side)
        assert rim[:, 0].min() < pupil[0] < rim[:, 0].max()
        assert rim[:, 1].min() < pupil[1] < rim[:, 1].max()


def test_the_mouth_landmarks_are_on_the_lips() -> None:
    corners = template().skin[load_basis().surface.landmarks[1:]]
    pixels = regions.FACE.to_pixels(corners)
    assert (regions.lip_mask(corners, pixels) > 0.15).all()


def test_lips_are_symmetric_and_inside_their_outline() -> None:
    points = np.random.default_rng(0).uniform((-40, -95, 0), (40, -55, 10), (2000, 3))
    lips = regions.lip_mask(points, regions.FACE.to_pixels(points))
    mirrored = points * (-1, 1, 1)
    np.testing.assert_allclose(
        regions.lip_mask(mirrored, regions.FACE.to_pixels(mirrored)), lips, atol=0.16
    )
    middle, below = np.array([[0.0, -78.0, 8.0], [0.0, -92.0, 8.0]])
    assert regions.lip_mask(middle, regions.FACE.to_pixels(middle[None]))[0] > 0.99
    assert regions.lip_mask(below, regions.FACE.to_pixels(below[None]))[0] < 0.01


def test_lips_meet_on_a_line() -> None:
    on, off = _at(regions.lip_contact, (0.0, -73.4, 8.0), (0.0, -80.0, 8.0))
    assert on > 0.9
    assert off < 0.01


def test_the_front_is_in_front() -> None:
    assert _at(regions.front, (0, 0, 0), (0, 0, -150)).tolist() == [1.0, 0.0]


def test_a_blob_is_one_at_its_centre_and_mirrored() -> None:
    points = np.array([[30.0, 5.0, 0.0], [-30.0, 5.0, 0.0], [40.0, 5.0, 0.0]])
    there, mirrored, beside = regions.blob(points, (30.0, 5.0, 0.0), (10.0, 5.0, 5.0))
    assert (there, mirrored) == (1.0, 1.0)
    assert beside == pytest.approx(np.exp(-0.5))


@pytest.mark.parametrize(
    ("name", "point"),
    [
        ("cheeks", (38, -34, -8)),
        ("nose", (0, -42, 18)),
        ("ears", (82, -18, -95)),
        ("lids", (31, 4, -3)),
        ("chin", (0, -102, 5)),
        ("forehead", (0, 52, 5)),
        ("circles", (26, -11, -3)),
    ],
)
def test_each_region_is_strongest_in_its_place(name: str, point: tuple[int, int, int]) -> None:
    masks = regions.pigment_regions(np.array([[point]], dtype=np.float32))
    assert masks[name][0, 0] > 0.6
    assert max(mask.max() for key, mask in masks.items() if key != name) < masks[name][0, 0]


def test_the_lid_margin_follows_the_lids() -> None:
    on, off = np.array([[-31.7, 2.9], [-31.7, 12.0]])
    pixels = regions.FACE.to_pixels(np.stack([on, off])[None])
    assert regions.lid_margin(pixels, 2.0)[0, 0] > 0.5
    assert regions.lid_margin(pixels, 2.0)[0, 1] == 0
    lower = regions.FACE.to_pixels(np.array([[[-31.5, -5.7]]]))
    assert regions.lid_margin(lower, 2.0)[0, 0] > 0.5
    assert regions.lid_margin(lower, 2.0, upper=True)[0, 0] == 0
