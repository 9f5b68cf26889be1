"""Where does the hairline run, and which skin shows the colour of hair roots?"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

from lrsr.identities.hair.anchors import (
    AZIMUTHS,
    POLAR_STEP_DEG,
    SKULL_CENTRE_MM,
    chart_angles,
    load_anchors,
)
from lrsr.identities.ramp import smoothstep

_Floats = NDArray[np.float64]

MM_PER_DEG = 1.6
"""Length of one degree on the skull, about 92 mm from its centre."""

_EAR_CLEARANCE_MM = 5.0
_REACH_DEG = 32.0
_FRAYED_MM = 13.0
"""No root stands farther than this beyond the hairline."""

_FINE = 720
_WHITE_ROOTS = 0.55
"""How much less roots colour the skin when they are white."""

# Azimuth (degrees, subject's left positive), polar angle of the natural hairline, and how strongly
# recession, widow's peak, sideburn (degrees) and nape move it.
_CONTROL = np.array(
    [
        #  az  polar rec  peak side nape
        [0.0, 60.0, -0.25, 1.0, 0.0, 0.0],
        [10.0, 60.0, -0.40, 0.2, 0.0, 0.0],
        [22.0, 59.5, -0.90, 0.0, 0.0, 0.0],
        [33.0, 59.0, -1.00, 0.0, 0.0, 0.0],
        [43.0, 62.0, -0.70, 0.0, 0.0, 0.0],
        [50.0, 69.0, -0.30, 0.0, 0.0, 0.0],
        [57.0, 80.0, -0.10, 0.0, 0.2, 0.0],
        [63.0, 93.0, 0.0, 0.0, 0.6, 0.0],
        [68.0, 103.0, 0.0, 0.0, 1.0, 0.0],
        [76.0, 105.0, 0.0, 0.0, 1.0, 0.0],
        [82.0, 96.0, 0.0, 0.0, 0.5, 0.0],
        [88.0, 88.0, 0.0, 0.0, 0.0, 0.0],
        [100.0, 86.0, 0.0, 0.0, 0.0, 0.0],
        [112.0, 92.0, 0.0, 0.0, 0.0, 0.0],
        [122.0, 110.0, 0.0, 0.0, 0.0, 0.3],
        [132.0, 126.0, 0.0, 0.0, 0.0, 0.8],
        [150.0, 131.0, 0.0, 0.0, 0.0, 1.0],
        [180.0, 130.0, 0.0, 0.0, 0.0, 1.0],
    ]
)


def hairline_polar(azimuth: _Floats, parameters: Mapping[str, Any]) -> _Floats:
    """Return the polar angle of the natural hairline, degrees.

    Args:
        azimuth: Any shape, degrees, -180..180.
        parameters: Of one head of hair, see :mod:`lrsr.identities.hair.styles`.
    """
    front = np.exp(-((_CONTROL[:, 0] / 52.0) ** 4))
    height = (
        _CONTROL[:, 1]
        - parameters["hairline_deg"] * front
        + parameters["recession_deg"] * _CONTROL[:, 2]
        + parameters["peak_deg"] * _CONTROL[:, 3]
        + parameters["sideburn_mm"] / MM_PER_DEG * _CONTROL[:, 4]
        + parameters["nape_deg"] * _CONTROL[:, 5]
    )
    grid = np.linspace(0.0, 180.0, 361)
    smooth = np.interp(grid, _CONTROL[:, 0], height)
    smooth = _blur(smooth, 7)
    tilt = parameters["tilt_deg"] * np.sin(np.deg2rad(azimuth)) * np.exp(-((azimuth / 60.0) ** 2))
    return np.asarray(np.interp(np.abs(azimuth), grid, smooth) + tilt)


class Scalp:
    """The skin on which hair can grow, prepared once for all people who share a texture layout.

    Args:
        position_map_xyz: ``(H, W, 3)`` canonical point of each texel, mm in the template's head
            frame; NaN where a texel shows no skin.
    """

    def __init__(self, position_map_xyz: NDArray[np.floating[Any]]) -> None:
        points = np.nan_to_num(np.asarray(position_map_xyz, dtype=np.float64), nan=1e4)
        azimuth, polar = chart_angles(points)
        reach = np.interp(np.abs(azimuth), _CONTROL[:, 0], _CONTROL[:, 1]) + _REACH_DEG
        radius = np.linalg.norm(points - np.asarray(SKULL_CENTRE_MM), axis=-1)
        grows = (polar < reach) & (radius < _skull_radius(azimuth, polar) + _EAR_CLEARANCE_MM)
        self._texels = np.flatnonzero(grows)
        self._polar = polar[grows]
        self._column = np.rint(azimuth[grows] % 360.0 * (_FINE / 360.0)).astype(np.intp) % _FINE
        self._stroke = np.rint(self._polar).astype(np.intp) * _FINE + self._column

    def roots(
        self, parameters: Mapping[str, Any], seed: int
    ) -> tuple[NDArray[np.intp], NDArray[np.float32]]:
        """Return which texels the hair roots cover, and how much of each.

        Args:
            parameters: Of one head of hair.
            seed: Of the ragged edge.

        Returns:
            texels: ``(n,)``, indices into the flat texture; all others are bare.
            cover: ``(n,)``, 0 = bare skin, 1 = all hair; fades over about 15 mm in strokes.
        """
        around = np.arange(_FINE, dtype=np.float64) * (360.0 / _FINE)
        azimuth = np.asarray((around + 180.0) % 360.0 - 180.0)
        inside_mm = np.take(hairline_polar(azimuth, parameters), self._column)
        inside_mm -= self._polar
        inside_mm *= MM_PER_DEG
        near = np.flatnonzero(inside_mm > -_FRAYED_MM)
        stroke = np.take(_strokes(np.random.default_rng([seed, 5])), self._stroke[near])
        cover = 9.0 * (stroke - 0.35)
        cover += inside_mm[near]
        cover = smoothstep(0.0, 1.0, cover / 15.0 + 0.45)
        bald = parameters["bald_deg"]
        if bald > 0:
            rim = np.take(bald_polar(azimuth, bald), self._column[near])
            rim_mm = (self._polar[near] - rim) * MM_PER_DEG
            cover = cover * smoothstep(0.0, 1.0, (rim_mm + 10.0 * (stroke - 0.5)) / 18.0 + 0.5)
        density = parameters["density"] * (1.0 - _WHITE_ROOTS * parameters.get("grey", 0.0))
        cover *= density + (1.0 - density) * 0.5 * (stroke - 0.5)
        return self._texels[near], np.clip(cover, 0.0, 1.0).astype(np.float32)


def bald_polar(azimuth: _Floats, bald_deg: float) -> _Floats:
    """Return the polar angle of the upper rim of a horseshoe of hair, degrees; none in front."""
    front = 24.0 * np.exp(-((azimuth / 48.0) ** 4))
    return np.asarray(bald_deg * (1.08 + 0.12 * np.cos(np.deg2rad(azimuth))) + front)


def _strokes(rng: np.random.Generator) -> _Floats:
    """Streaks along the strands, 0..1, ``(181, _FINE)``: one row a degree of polar angle."""
    knots = _blur(rng.random((36, _FINE)), 3) + 0.35 * rng.random((36, _FINE))
    knots = (knots - knots.min()) / np.ptp(knots)
    place = np.linspace(0.0, 34.999, 181)
    first, share = place.astype(np.intp), (place % 1.0)[:, None]
    return np.asarray((1.0 - share) * knots[first] + share * knots[first + 1])


def _skull_radius(azimuth: _Floats, polar: _Floats) -> _Floats:
    template = load_anchors().template
    radius = np.linalg.norm(template - np.asarray(SKULL_CENTRE_MM), axis=-1)
    rows = (azimuth % 360.0) * (AZIMUTHS / 360.0)
    columns = np.clip(polar / POLAR_STEP_DEG, 0.0, radius.shape[1] - 1.0)
    wrapped = np.concatenate([radius, radius[:1]], axis=0)
    return np.asarray(map_coordinates(wrapped, [rows, columns], order=1, mode="nearest"))


def _blur(values: _Floats, width: int) -> _Floats:
    """Running mean along the last axis, edges repeated."""
    pad = [(0, 0)] * (values.ndim - 1) + [(width // 2 + 1, width // 2)]
    total = np.cumsum(np.pad(values, pad, mode="edge"), axis=-1)
    return (total[..., width:] - total[..., :-width]) / width
