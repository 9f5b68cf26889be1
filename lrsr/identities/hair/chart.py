"""Which point of this head is at an azimuth and a polar angle, and how wide is it at a height?"""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, maximum_filter

from lrsr.identities.hair.anchors import AZIMUTHS, POLAR_STEP_DEG

_Floats = NDArray[np.float64]

_LEVELS_MM = np.arange(100.0, -284.0, -4.0)
"""Heights of the tables of :func:`measure_skin` and :func:`measure_ears`."""

_FIRST_POLAR = 14


def flatten(azimuth: _Floats, polar: _Floats) -> _Floats:
    """Map azimuth and polar angle to the flattened chart: ``(..., 2)`` degrees, left and front."""
    angle = np.deg2rad(azimuth)
    return np.stack([polar * np.sin(angle), polar * np.cos(angle)], axis=-1)


def sample_chart(chart: _Floats, azimuth: _Floats, polar: _Floats) -> _Floats:
    """Return points of the chart at any angles, bilinear: ``(..., 3)``."""
    return _bilinear(chart, azimuth * (AZIMUTHS / 360.0), polar / POLAR_STEP_DEG)


def sample_level(table: _Floats, azimuth: _Floats, y: _Floats) -> _Floats:
    """Return values of a table ``(AZIMUTHS, levels)`` at any azimuths, degrees, and heights, mm."""
    level = (_LEVELS_MM[0] - y) / (_LEVELS_MM[0] - _LEVELS_MM[1])
    return _bilinear(table[..., None], azimuth * (AZIMUTHS / 360.0), level)[..., 0]


def measure_skin(chart: _Floats, centre: _Floats) -> _Floats:
    """Return how far the skin is from the skull's vertical axis: ``(AZIMUTHS, levels)``, mm."""
    below = chart[:, _FIRST_POLAR:]
    radius = np.hypot(below[..., 0] - centre[0], below[..., 2] - centre[2])
    height = np.minimum.accumulate(below[..., 1], axis=1)
    ramp = np.arange(height.shape[1]) * 1e-6
    return np.stack(
        [np.interp(_LEVELS_MM, (height[a] - ramp)[::-1], radius[a][::-1]) for a in range(AZIMUTHS)]
    )


def measure_ears(ears: NDArray[np.float32], centre: _Floats) -> _Floats:
    """Return how far the ears reach from that axis: ``(AZIMUTHS, levels)``, mm; 0 elsewhere."""
    flat = ears[:, [0, 2]] - centre[[0, 2]]
    azimuth = np.rad2deg(np.arctan2(flat[:, 0], flat[:, 1])) % 360.0
    row = (azimuth * (AZIMUTHS / 360.0)).astype(np.intp) % AZIMUTHS
    level = (_LEVELS_MM[0] - ears[:, 1]) / (_LEVELS_MM[0] - _LEVELS_MM[1])
    column = np.clip(level.astype(np.intp), 0, len(_LEVELS_MM) - 1)
    reach = np.zeros((AZIMUTHS, len(_LEVELS_MM)))
    np.maximum.at(reach, (row, column), np.linalg.norm(flat, axis=1))
    grown = maximum_filter(reach, size=(5, 5), mode=("wrap", "nearest"))
    return np.asarray(gaussian_filter(grown, (1.2, 1.5), mode=("wrap", "nearest")))


def _bilinear(table: _Floats, row: _Floats, column: _Floats) -> _Floats:
    """Sample ``(R, C, n)``: rows wrap around, columns stop at the ends."""
    column = np.clip(column, 0.0, table.shape[1] - 1.001)
    r0, c0 = np.floor(row).astype(np.intp), np.floor(column).astype(np.intp)
    fr, fc = (row - r0)[..., None], (column - c0)[..., None]
    r0, r1 = r0 % table.shape[0], (r0 + 1) % table.shape[0]
    near = table[r0, c0] * (1 - fc) + table[r0, c0 + 1] * fc
    far = table[r1, c0] * (1 - fc) + table[r1, c0 + 1] * fc
    return np.asarray(near * (1 - fr) + far * fr)
