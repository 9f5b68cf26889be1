"""How different do two colours look? CIEDE2000, in units of what one can just see.

G. Sharma, W. Wu and E. N. Dalal, "The CIEDE2000 color-difference formula: implementation notes,
supplementary test data, and mathematical observations", Color Research and Application 30, 2005.
"""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_RGB_TO_XYZ = np.array(
    [
        [0.4123908, 0.3575843, 0.1804808],
        [0.2126390, 0.7151687, 0.0721923],
        [0.0193308, 0.1191948, 0.9505322],
    ]
)  # IEC 61966-2-1


def lab(linear: FloatArray) -> FloatArray:
    """Return CIE L*a*b* of linear sRGB, whose white is L* = 100.

    Args:
        linear: ``(..., 3)``, 1 = white.

    Example:
        >>> lab(np.array([1.0, 1.0, 1.0])).round(3).tolist()
        [100.0, 0.0, 0.0]
    """
    xyz = linear @ _RGB_TO_XYZ.T / _RGB_TO_XYZ.sum(axis=1)
    steep = xyz > (6 / 29) ** 3
    f = np.where(steep, np.cbrt(np.where(steep, xyz, 1.0)), xyz * (29 / 6) ** 2 / 3 + 4 / 29)
    x, y, z = np.moveaxis(f, -1, 0)
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=-1)


def ciede2000(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return ΔE00 of colours in L*a*b*, ``(..., 3)`` each.

    Example:
        >>> ciede2000(np.array([50.0, 2.6772, -79.7751]), np.array([50.0, 0.0, -82.7485])).round(4)
        np.float64(2.0425)
    """
    (l1, a1, b1), (l2, a2, b2) = np.moveaxis(first, -1, 0), np.moveaxis(second, -1, 0)
    stretch = 1 + 0.5 * (1 - _share((np.hypot(a1, b1) + np.hypot(a2, b2)) / 2))
    c1, c2 = np.hypot(stretch * a1, b1), np.hypot(stretch * a2, b2)
    h1 = np.degrees(np.arctan2(b1, stretch * a1)) % 360
    h2 = np.degrees(np.arctan2(b2, stretch * a2)) % 360
    grey = c1 * c2 == 0
    turn = np.where(grey, 0.0, (h2 - h1 + 180) % 360 - 180)
    turn = np.where((turn == -180) & (h2 > h1), 180.0, turn)
    hue = np.where(grey, h1 + h2, _mean_hue(h1, h2))
    light, chroma = (l1 + l2) / 2, (c1 + c2) / 2
    offset = (light - 50) ** 2
    by_light = (l2 - l1) / (1 + 0.015 * offset / np.sqrt(20 + offset))
    by_chroma = (c2 - c1) / (1 + 0.045 * chroma)
    by_hue = 2 * np.sqrt(c1 * c2) * np.sin(np.radians(turn / 2))
    by_hue = by_hue / (1 + 0.015 * chroma * _hue_weight(hue))
    twist = 2 * _share(chroma) * np.sin(np.radians(60 * np.exp(-(((hue - 275) / 25) ** 2))))
    squares = by_light**2 + by_chroma**2 + by_hue**2 - twist * by_chroma * by_hue
    return np.asarray(np.sqrt(np.maximum(squares, 0)))


def _share(chroma: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(chroma**7 / (chroma**7 + 25.0**7)))


def _mean_hue(h1: FloatArray, h2: FloatArray) -> FloatArray:
    far = np.abs(h1 - h2) > 180
    return np.asarray(
        np.where(far, (h1 + h2 + np.where(h1 + h2 < 360, 360, -360)) / 2, (h1 + h2) / 2)
    )


def _hue_weight(hue: FloatArray) -> FloatArray:
    terms = ((-0.17, 1, -30), (0.24, 2, 0), (0.32, 3, 6), (-0.20, 4, -63))
    waves = [share * np.cos(np.radians(times * hue + shift)) for share, times, shift in terms]
    return np.asarray(1 + sum(waves))
