"""Bands of light, against published chromaticities and adaptation."""

import numpy as np
import pytest

from lrsr.errors import InputError
from lrsr.rendering.colour import chromaticity
from lrsr.spectra import (
    _observer,
    average,
    band_edges,
    daylight,
    photometric_unit,
    srgb_curves,
    srgb_weights,
    table,
)

EDGES = band_edges(35)


def incandescent(edges: tuple[float, ...]) -> np.ndarray:
    """Return standard illuminant A by its definition (CIE 15:2004, 3.1), of luminance 1."""
    nm = np.arange(360.0, 781.0)
    power = (560 / nm) ** 5 * np.expm1(1.435e7 / (2848 * 560)) / np.expm1(1.435e7 / (2848 * nm))
    bands = average(nm, power[None], edges)[0]
    return np.asarray(bands / (_observer(edges)[1] @ bands))


def xy(bands: np.ndarray, edges: tuple[float, ...] = EDGES) -> np.ndarray:
    xyz = _observer(edges) @ bands
    return np.asarray(xyz[:2] / xyz.sum())


def test_bands_are_equal_and_meet() -> None:
    assert list(EDGES) == list(range(380, 731, 10))
    assert len(band_edges(7)) == 8


@pytest.mark.parametrize("count", [-1, 0, 3, 6, 351])
def test_too_few_or_too_many_bands_are_refused(count: int) -> None:
    with pytest.raises(InputError, match=f"bands={count}: give 0 for three colours, or 7 to 350"):
        band_edges(count)


def test_standard_illuminants_have_their_published_chromaticities() -> None:
    assert xy(incandescent(EDGES)) == pytest.approx((0.44757, 0.40745), abs=4e-4)
    assert xy(daylight(EDGES)) == pytest.approx((0.31272, 0.32903), abs=2e-4)
    assert xy(daylight(EDGES)) == pytest.approx(chromaticity(6504), abs=5e-4)


def test_equal_energy_of_one_has_the_luminance_one() -> None:
    assert photometric_unit() == pytest.approx(106.857, abs=0.001)  # CIE 15:2004, table T.4
    assert _observer(EDGES).sum(axis=1) == pytest.approx((1, 1, 1), abs=5e-4)


@pytest.mark.parametrize("count", [7, 14, 70, 350])
def test_however_many_bands_white_is_white_and_red_is_red(count: int) -> None:
    edges = band_edges(count)
    assert srgb_weights(edges) @ daylight(edges) == pytest.approx((1, 1, 1), abs=1e-9)
    red = srgb_weights(edges) @ incandescent(edges)
    fine = srgb_weights(band_edges(350)) @ incandescent(band_edges(350))
    assert red == pytest.approx(fine, abs=0.03 if count == 7 else 0.005)


def test_an_observer_adapts_as_bradford_says() -> None:
    # From A to D65, as printed by B. Lindbloom ("Chromatic Adaptation"), Bradford's method.
    printed = np.array(
        [
            [0.8446965, -0.1179225, 0.3948108],
            [-0.1366303, 1.1041226, 0.1291718],
            [0.0798489, -0.1348999, 3.1924009],
        ]
    )
    adapted = srgb_weights(EDGES, tuple(incandescent(EDGES).tolist()))
    back = np.linalg.pinv(_observer(EDGES))
    found = np.linalg.solve(srgb_weights(EDGES) @ back, adapted @ back)
    # His A, from another table, has 0.1 % more of Z.
    assert found == pytest.approx(printed, abs=0.007)


def test_the_light_that_an_observer_is_adapted_to_is_grey_of_its_luminance() -> None:
    lamp = incandescent(EDGES)
    weights = srgb_weights(EDGES, tuple(lamp.tolist()))
    assert weights @ (0.3 * lamp) == pytest.approx((0.3, 0.3, 0.3), abs=1e-9)
    plain = srgb_weights(EDGES, tuple(daylight(EDGES).tolist()))
    np.testing.assert_allclose(plain, srgb_weights(EDGES), atol=1e-12)


def test_reflectances_have_the_colour_that_their_bands_have() -> None:
    nm = table("cie_1931")[0]
    rising = np.interp(nm, (400, 700), (0.2, 0.9))
    bands = average(nm, rising[None], EDGES)[0] * daylight(EDGES)
    assert srgb_curves() @ rising == pytest.approx(srgb_weights(EDGES) @ bands, abs=2e-3)


def test_a_curve_is_nothing_beyond_its_table() -> None:
    ones = average(np.array([400.0, 500.0]), np.ones((2, 2)), EDGES)
    assert ones[:, 2:12].tolist() == [[1.0] * 10] * 2
    assert not ones[:, :2].any()
    assert not ones[:, 12:].any()
