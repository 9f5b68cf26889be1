"""What colour had the light? What skin cannot explain.

Skin varies far more in lightness than in hue, so a face is a colour chart. Most photographs are
balanced; some are tinted. Which one this is, and how much, follows from how hues of skin and of
lights scatter: Bayes' rule with two kinds of light.
"""

import numpy as np
from numpy.typing import NDArray

_Floats = NDArray[np.float64]

_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])

# Hues are logarithms of red and of blue over green.
_SKIN = np.array([[-0.018, 0.107], [-0.563, 0.479], [-0.080, 0.101]])
"""Hue of skin, constant, linear and square in the logarithm of its luminance: cheeks and noses of
60 drawn people (:mod:`lrsr.identities.skin`)."""
_SKIN_SPREAD = 2 * np.array([[0.0055, 0.0012], [0.0012, 0.0065]])
"""Covariance about it, doubled: photographed skins differ more than drawn ones (estimated)."""
_SATURATION = 0.4
"""Standard deviation of the factor by which tone curves, and exposure, strengthen that hue. Skin of
4 well balanced photographs has 1.2 to 2 times the red; their teeth are white."""
_TINTS = np.array([[0.020, -0.025], [-0.025, 0.050]])
"""Of the lights of tinted photographs, from candles to the sky (estimated)."""
_TINTED = 0.2
"""Share of photographs that are (estimated)."""


def light_colour(colour: NDArray[np.floating]) -> tuple[float, float]:
    """Return the logarithms of red and of blue over green of the light, as far as it is sure.

    Args:
        colour: ``(3,)`` linear, skin of cheeks and nose as it was photographed, > 0.

    Example:
        >>> tuple(round(part, 3) for part in light_colour(np.array([0.45, 0.29, 0.22])))
        (-0.002, 0.001)
    """
    skin = np.maximum(np.asarray(colour, dtype=np.float64), 1e-4)
    light = float(np.clip(np.log(skin @ _LUMINANCE), np.log(0.03), np.log(0.5)))
    usual = np.array([1.0, light, light**2]) @ _SKIN
    seen = np.log(skin[[0, 2]] / skin[1]) - usual
    spread = _SKIN_SPREAD + _SATURATION**2 * np.outer(usual, usual)
    both = spread + _TINTS
    tinted = _TINTED * _density(seen, both)
    share = tinted / (tinted + (1 - _TINTED) * _density(seen, spread))
    red, blue = share * (_TINTS @ np.linalg.solve(both, seen))
    return float(red), float(blue)


def _density(offset: _Floats, covariance: _Floats) -> float:
    """Return the density of a normal distribution about 0, up to a constant."""
    far = float(offset @ np.linalg.solve(covariance, offset))
    return float(np.exp(-far / 2) / np.sqrt(np.linalg.det(covariance)))
