"""What colour is light of a colour temperature? Linear sRGB, whose white is daylight of 6504 K."""

import numpy as np
from numpy.typing import NDArray

from lrsr.errors import InputError
from lrsr.spectra import XYZ_TO_RGB

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
"""Of linear sRGB (BT.709)."""

_COOLEST_K, _HOTTEST_K = 2000.0, 25000.0
"""Cooler light is redder than any sRGB colour; the formulas end at the hottest."""

_DAYLIGHT_K = 4000.0
"""From here on daylight, below a black body: what a lamp and what a window are named by."""


def chromaticity(kelvin: float) -> tuple[float, float]:
    """Return the CIE 1931 (x, y) of light of that colour temperature.

    A black body's by Krystek 1985 (rational fit in u, v) below ``_DAYLIGHT_K``; from there on
    that of the CIE's daylight (CIE 15:2004, equations 3.2 to 3.4), which is a little greener.

    Args:
        kelvin: 2000..25000 K.

    Raises:
        InputError: It is outside that range.

    Example:
        >>> [round(value, 3) for value in chromaticity(6504)]
        [0.313, 0.329]
    """
    if not _COOLEST_K <= kelvin <= _HOTTEST_K:
        raise InputError(
            f"colour temperature {kelvin} K: give {_COOLEST_K:.0f} to {_HOTTEST_K:.0f}, or rgb"
        )
    t = float(kelvin)
    if t < _DAYLIGHT_K:
        u = 0.860117757 + 1.54118254e-4 * t + 1.28641212e-7 * t**2
        u /= 1 + 8.42420235e-4 * t + 7.08145163e-7 * t**2
        v = 0.317398726 + 4.22806245e-5 * t + 4.20481691e-8 * t**2
        v /= 1 - 2.89741816e-5 * t + 1.61456053e-7 * t**2
        return 3 * u / (2 * u - 8 * v + 4), 2 * v / (2 * u - 8 * v + 4)
    terms = (-4.6070e9, 2.9678e6, 99.11, 0.244063)
    if t > 7000:
        terms = (-2.0064e9, 1.9018e6, 247.48, 0.237040)
    x = sum(term / t**power for term, power in zip(terms, (3, 2, 1, 0), strict=True))
    return x, -3 * x**2 + 2.870 * x - 0.275


def rgb_of_kelvin(kelvin: float) -> tuple[float, float, float]:
    """Return linear sRGB of luminance 1.

    Raises:
        InputError: The temperature is outside 2000..25000 K.

    Example:
        >>> [round(value, 2) for value in rgb_of_kelvin(6504)]
        [1.0, 1.0, 1.0]
    """
    x, y = chromaticity(kelvin)
    rgb = XYZ_TO_RGB @ (x / y, 1.0, (1 - x - y) / y)
    red, green, blue = unit_luminance(np.clip(rgb, 0, None)).tolist()
    return red, green, blue


def unit_luminance(rgb: NDArray[np.float64] | tuple[float, float, float]) -> NDArray[np.float64]:
    """Scale a colour ``(3,)`` so that its luminance is 1."""
    colour = np.asarray(rgb, dtype=np.float64)
    return np.asarray(colour / (colour @ LUMINANCE))
