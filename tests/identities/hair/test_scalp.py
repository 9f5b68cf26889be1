from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from lrsr.identities.hair.anchors import SKULL_CENTRE_MM, _chart_directions, load_anchors
from lrsr.identities.hair.scalp import Scalp, bald_polar, hairline_polar
from lrsr.identities.hair.styles import style_parameters
from lrsr.identities.morphable import template
from lrsr.identities.skin.canvas import FloatMap


def make_hair(style: str = "crop", **changes: Any) -> dict[str, Any]:
    return style_parameters(style, np.random.default_rng(3)) | changes


def covered(points: NDArray[np.floating[Any]], hair: dict[str, Any], seed: int) -> FloatMap:
    mask = np.zeros(points.shape[:2], np.float32)
    texels, cover = Scalp(points).roots(hair, seed)
    mask.ravel()[texels] = cover
    return mask


def test_hairline_is_symmetrical_without_tilt() -> None:
    azimuth = np.linspace(0.0, 180.0, 91)
    hair = make_hair(tilt_deg=0.0)
    np.testing.assert_array_equal(hairline_polar(azimuth, hair), hairline_polar(-azimuth, hair))


def test_hairline_meets_the_forehead_two_thirds_up() -> None:
    hair = make_hair(hairline_deg=0.0, peak_deg=0.0, recession_deg=0.0, tilt_deg=0.0)
    row = int(hairline_polar(np.array([0.0]), hair)[0] // 3)
    assert load_anchors().template[0, row, 1] == pytest.approx(68.0, abs=8.0)


@pytest.mark.parametrize(
    ("name", "azimuth", "lower"),
    [
        ("hairline_deg", 0.0, False),
        ("recession_deg", 33.0, False),
        ("peak_deg", 0.0, True),
        ("sideburn_mm", 70.0, True),
        ("nape_deg", 160.0, True),
    ],
)
def test_each_number_moves_its_part_of_the_hairline(name: str, azimuth: float, lower: bool) -> None:
    at = np.array([azimuth])
    less, more = (hairline_polar(at, make_hair(**{name: value}))[0] for value in (0.0, 10.0))
    assert (more > less) == lower
    elsewhere = np.array([100.0])
    assert hairline_polar(elsewhere, make_hair(**{name: 0.0})) == pytest.approx(
        hairline_polar(elsewhere, make_hair(**{name: 10.0})), abs=0.2
    )


def test_crown_is_covered_and_face_is_bare() -> None:
    skin = template().skin
    mask = covered(skin[None], make_hair(density=1.0), 0)[0]
    crown = skin[:, 1] > 100.0
    face = (skin[:, 1] < 40.0) & (np.abs(skin[:, 0]) < 50.0) & (skin[:, 2] > -30.0)
    assert mask[crown].min() > 0.9
    assert mask[face].max() == 0.0
    assert mask.dtype == np.float32


def test_ears_are_bare() -> None:
    skin = template().skin
    ears = skin[load_anchors().ears]
    outer = ears[np.abs(ears[:, 0]) > 80.0]
    assert covered(outer[None], make_hair(), 0).max() == 0.0


def test_texels_without_skin_are_bare() -> None:
    nowhere = np.full((2, 2, 3), np.nan)
    assert covered(nowhere, make_hair(), 0).tolist() == [[0.0, 0.0], [0.0, 0.0]]


def test_hairline_fades_over_millimetres() -> None:
    hair = make_hair(density=1.0, tilt_deg=0.0)
    azimuth, offset_mm = np.deg2rad(np.linspace(-20, 20, 400)), np.linspace(-12.0, 12.0, 97)
    line = hairline_polar(np.rad2deg(azimuth), hair)
    polar = np.deg2rad(line[:, None] + offset_mm[None, :] / 1.6)
    points = np.asarray(SKULL_CENTRE_MM) + 90.0 * np.stack(
        [
            np.sin(polar) * np.sin(azimuth)[:, None],
            np.cos(polar),
            np.sin(polar) * np.cos(azimuth)[:, None],
        ],
        axis=-1,
    )
    mean = covered(points, hair, 0).mean(axis=0)
    assert mean[0] > 0.95
    assert mean[-1] < 0.02
    width_mm = offset_mm[np.argmax(mean < 0.1)] - offset_mm[np.argmax(mean < 0.9)]
    assert 4.0 < width_mm < 12.0


def test_horseshoe_leaves_the_crown_bare() -> None:
    hair = make_hair("horseshoe", bald_deg=50.0)
    centre = np.asarray(SKULL_CENTRE_MM)
    crown = centre + 90.0 * _chart_directions()[:, :8]
    assert covered(crown, hair, 0).max() == 0.0
    behind = centre + 90.0 * _chart_directions()[55:65, 30:35]
    assert covered(behind, hair, 0).min() > 0.4
    assert bald_polar(np.array([0.0]), 50.0)[0] > hairline_polar(np.array([0.0]), hair)[0]


def test_thin_hair_lets_skin_through() -> None:
    crown = template().skin[template().skin[:, 1] > 90.0][None]
    dense, thin = (covered(crown, make_hair(density=d), 0).mean() for d in (1.0, 0.3))
    assert dense > 0.95
    assert thin == pytest.approx(0.3, abs=0.05)


def test_white_roots_colour_the_skin_less() -> None:
    crown = template().skin[template().skin[:, 1] > 90.0][None]
    dark, white = (covered(crown, make_hair(density=1.0, grey=g), 0).mean() for g in (0.0, 1.0))
    assert white < 0.6 * dark


def test_seed_decides_the_ragged_edge() -> None:
    skin = template().skin[None]
    first, again, other = (covered(skin, make_hair(), seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert np.abs(first - other).max() > 0.1
