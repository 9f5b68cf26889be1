"""How does a baseball cap sit on this head? Over the skull, above ears and brows; hair lies flat.

The crown follows the chart of the skull (:mod:`lrsr.identities.hair.anchors`) at some distance;
hair that would stand higher than its lining is pressed under it, and bulges again below the rim.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.random import Generator
from scipy.ndimage import gaussian_filter

from lrsr.identities.day.fit import Fit
from lrsr.identities.day.mesh import Mesh, Points, join, sheet
from lrsr.identities.hair.anchors import (
    AZIMUTHS,
    POLAR_STEP_DEG,
    POLARS,
    SKULL_CENTRE_MM,
    chart_angles,
)
from lrsr.identities.head import Part
from lrsr.identities.ramp import smoothstep

_COLOURS = {
    "black": (0.013, 0.013, 0.014),
    "navy": (0.012, 0.018, 0.05),
    "grey": (0.13, 0.13, 0.135),
    "red": (0.28, 0.022, 0.025),
    "khaki": (0.25, 0.19, 0.11),
    "white": (0.62, 0.61, 0.58),
}
_ROWS = 24
_BRIM_COLUMNS, _BRIM_ROWS = 33, 12
_BRIM_DEG = 62.0
_BRIM_MM = 68.0
_STANDS_MM = (9.0, 4.5)
"""How far the cloth is off the skull, at the crown and at the rim."""
_LINING_MM = 1.5
_UNDER_BRIM_MM = 9.0
_ABOVE_EARS_MM = 7.0
_MM_PER_DEG = 1.6


def sample_cap(rng: Generator) -> dict[str, Any]:
    """Draw a cap: its colour by name, and how low it is worn, mm above the usual."""
    return {
        "colour": str(rng.choice(list(_COLOURS))),
        "lift_mm": float(rng.uniform(-4.0, 5.0)),
        "brim_deg": float(rng.uniform(2.0, 12.0)),
    }


class Crown:
    """The dome of a cap on one head, by azimuth and polar angle about the skull's centre.

    Args:
        cap: As :func:`sample_cap` draws it.
        fit: Of the head.
    """

    def __init__(self, cap: dict[str, Any], fit: Fit) -> None:
        self._fit = fit
        azimuth = np.arange(AZIMUTHS) * (360.0 / AZIMUTHS)
        height = self._rim_height(cap, np.minimum(azimuth, 360.0 - azimuth))
        polar = np.arange(POLARS) * POLAR_STEP_DEG
        down = np.minimum.accumulate(fit.chart[..., 1], axis=1) - polar * 1e-6
        self.rim_deg = np.array(
            [np.interp(-y, -column, polar) for y, column in zip(height, down, strict=True)]
        )
        radius = np.linalg.norm(fit.chart - fit.centre, axis=-1)
        share = np.clip(polar / self.rim_deg[:, None], 0.0, 1.0)
        off = _STANDS_MM[0] + (_STANDS_MM[1] - _STANDS_MM[0]) * share**2
        smooth = gaussian_filter(radius, (2.0, 1.2), mode=("wrap", "nearest"))
        self._radius = np.maximum(smooth, radius - 1.0) + off

    def _rim_height(self, cap: dict[str, Any], azimuth: Points) -> Points:
        """Return how high the rim is, mm, at azimuths of 0 (front) to 180 (back) degrees."""
        ears = max(self._fit.ear(sign)[0][1] for sign in (-1, 1)) + _ABOVE_EARS_MM
        front = 50.0 + cap["lift_mm"]
        side = max(ears, 16.0)
        return np.asarray(
            np.interp(azimuth, [0, 25, 75, 110, 180], [front, front - 2, side + 3, side, side - 10])
        )

    def radius_mm(self, azimuth: Points, polar: Points) -> Points:
        """Return how far the cloth is from the skull's centre, mm; below the rim as at the rim."""
        rows = azimuth % 360.0 * (AZIMUTHS / 360.0)
        low = np.floor(rows).astype(np.intp)
        share = rows - low
        ends = []
        for row in (low % AZIMUTHS, (low + 1) % AZIMUTHS):
            columns = np.minimum(polar, self.rim_deg[row]) / POLAR_STEP_DEG
            left = np.minimum(np.floor(columns).astype(np.intp), POLARS - 2)
            part = columns - left
            ends.append(self._radius[row, left] * (1 - part) + self._radius[row, left + 1] * part)
        return np.asarray(ends[0] * (1 - share) + ends[1] * share)

    def rim_at(self, azimuth: Points) -> Points:
        """Return the polar angle of the rim, degrees."""
        around = np.arange(AZIMUTHS + 1) * (360.0 / AZIMUTHS)
        rim = np.append(self.rim_deg, self.rim_deg[0])
        return np.asarray(np.interp(azimuth % 360.0, around, rim))

    def point(self, azimuth: Points, polar: Points, radius: Points) -> Points:
        """Return points ``(..., 3)``, mm, at angles and a distance from the skull's centre."""
        a, p = np.deg2rad(azimuth), np.deg2rad(polar)
        ray = np.stack([np.sin(a) * np.sin(p), np.cos(p) + 0 * a, np.cos(a) * np.sin(p)], axis=-1)
        return np.asarray(self._fit.centre + ray * radius[..., None])

    def press(self, hair: Part) -> Part:
        """Return hair that lies under the cap, and bulges below it."""
        offset = hair.vertices.astype(np.float64) - self._fit.centre
        azimuth, polar = chart_angles(
            hair.vertices - (self._fit.centre - np.asarray(SKULL_CENTRE_MM))
        )
        below = np.maximum(polar - self.rim_at(azimuth), 0.0) * _MM_PER_DEG
        brim = smoothstep(_BRIM_DEG, _BRIM_DEG - 12.0, np.abs(azimuth))  # which hair lies under
        bulge = below - 0.9 * brim * np.minimum(below, _UNDER_BRIM_MM)
        room = self.radius_mm(azimuth, polar) - _LINING_MM + bulge
        radius = np.linalg.norm(offset, axis=1)
        pressed = offset * np.minimum(1.0, room / np.maximum(radius, 1e-6))[:, None]
        vertices = (self._fit.centre + pressed).astype(np.float32)
        return replace(hair, vertices=vertices)


def build_cap(cap: dict[str, Any], crown: Crown) -> Part:
    """Make the part "cap", of the same faces for everybody.

    Args:
        cap: As :func:`sample_cap` draws it.
        crown: Of the same cap, on the head.
    """
    mesh = join([_dome(crown), _brim(cap, crown)])
    albedo = np.broadcast_to(np.asarray(_COLOURS[cap["colour"]], np.float32), (4, 4, 3)).copy()
    return Part(
        "cap",
        "cloth",
        mesh.vertices.astype(np.float32),
        mesh.faces.astype(np.int32),
        mesh.uv.astype(np.float32),
        albedo,
    )


def _dome(crown: Crown) -> Mesh:
    azimuth = np.asarray(np.arange(AZIMUTHS) * (360.0 / AZIMUTHS), dtype=np.float64)
    share = np.linspace(0.0, 1.0, _ROWS)[:, None]
    polar = share * crown.rim_deg
    around = np.broadcast_to(azimuth, polar.shape)
    radius = crown.radius_mm(around, polar)
    seam = np.abs((around + 30.0) % 60.0 - 30.0) * np.sin(np.deg2rad(np.maximum(polar, 8.0)))
    radius = radius - 0.7 * np.exp(-((seam / 1.6) ** 2))  # of six panels
    edge = crown.point(azimuth, crown.rim_deg, radius[-1] - 3.0)  # turned in
    return sheet(np.concatenate([crown.point(around, polar, radius), edge[None]]), closed=True)


def _brim(cap: dict[str, Any], crown: Crown) -> Mesh:
    """A curved shield that begins under the front of the rim."""
    across = np.linspace(-1.0, 1.0, _BRIM_COLUMNS)
    azimuth = across * _BRIM_DEG
    rim = crown.rim_at(azimuth)
    base = crown.point(azimuth, rim, crown.radius_mm(azimuth, rim) - 1.0)
    out = np.linspace(0.0, 1.0, _BRIM_ROWS)[:, None]
    length = _BRIM_MM * (1.0 - np.abs(across) ** 2.6)
    drop = np.tan(np.deg2rad(cap["brim_deg"])) * length * out + 5.0 * out * across**2
    top = np.broadcast_to(base, (_BRIM_ROWS, *base.shape)).copy()
    top[..., 2] += out * length
    top[..., 1] -= drop + 1.5 * out**2
    top[..., 0] *= 1.0 + 0.04 * np.sin(np.pi * out)
    bottom = top[::-1] - [0.0, 2.0, 0.0]
    return sheet(np.concatenate([top, bottom]))
