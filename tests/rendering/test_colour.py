"""Colour temperatures against the chromaticities that the CIE prints."""

import numpy as np
import pytest

from lrsr.errors import InputError
from lrsr.rendering.colour import LUMINANCE, chromaticity, rgb_of_kelvin, unit_luminance


@pytest.mark.parametrize(
    ("kelvin", "wanted"),
    [
        (2856, (0.44757, 0.40745)),  # illuminant A
        (3000, (0.43694, 0.40409)),  # black body, from CIE 1931 observer and Planck's law
        (5003, (0.34567, 0.35850)),  # D50
        (5503, (0.33242, 0.34743)),  # D55
        (6504, (0.31272, 0.32903)),  # D65
        (7504, (0.29902, 0.31485)),  # D75
    ],
)
def test_chromaticities_are_the_cies(kelvin: float, wanted: tuple[float, float]) -> None:
    assert chromaticity(kelvin) == pytest.approx(wanted, abs=4e-4)


def test_daylight_of_6504_k_is_white() -> None:
    np.testing.assert_allclose(rgb_of_kelvin(6504), 1.0, atol=2e-3)


def test_hotter_is_bluer_and_every_light_has_luminance_one() -> None:
    colours = np.array([rgb_of_kelvin(kelvin) for kelvin in range(2000, 25000, 250)])
    np.testing.assert_allclose(colours @ LUMINANCE, 1.0)
    ratio = colours[:, 2] / colours[:, 0]
    assert (np.diff(ratio) > 0).all()
    assert (colours >= 0).all()


def test_luminance_is_scaled_to_one() -> None:
    assert unit_luminance((3, 0, 0)) == pytest.approx([1 / 0.2126, 0, 0])


@pytest.mark.parametrize("kelvin", [0.0, 1999.0, 25001.0, float("nan")])
def test_other_temperatures_are_refused(kelvin: float) -> None:
    with pytest.raises(InputError, match="give 2000 to 25000, or rgb"):
        chromaticity(kelvin)
    with pytest.raises(InputError, match="give 2000 to 25000, or rgb"):
        rgb_of_kelvin(kelvin)
