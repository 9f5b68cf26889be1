"""What do teeth look like? Two rows with their gums, and a tongue, as one small mesh.

Widths are the means of Wheeler's tables (Nelson and Ash, *Dental Anatomy*, 2010), heights what the
gums leave of the crowns; the arches are half ellipses as wide as MakeHuman's helper teeth allow.
Template frame: x to the subject's left, y up, z out of the face, mm, teeth in occlusion.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lrsr.identities.ramp import smoothstep

Points = NDArray[np.float64]

_UPPER_WIDTHS_MM = (8.5, 6.6, 7.6, 7.1, 6.7, 10.2)
_LOWER_WIDTHS_MM = (5.3, 5.8, 6.9, 7.0, 7.1, 10.9)
"""Of one side, from the middle to the first molar."""
_UPPER_CROWNS_MM = (9.8, 8.6, 9.5, 8.2, 7.6, 7.0)
_LOWER_CROWNS_MM = (8.4, 8.6, 9.6, 8.2, 7.6, 7.0)
_UPPER_EDGES_MM = (0.0, 0.6, 0.1, 0.8, 1.0, 1.2)
_LOWER_EDGES_MM = (0.0, 0.0, -0.3, 0.2, 0.5, 0.8)
"""How much farther from the other row the cutting edge lies than that of the first incisor."""
_UPPER_ARCH = (-75.2, 4.6, 29.5, 42.0)
_LOWER_ARCH = (-73.8, 1.9, 27.5, 40.0)
"""Height of the cutting edge, depth of the front, half width and length of the ellipse, mm."""

_COLUMNS = (0.0, 0.07, 0.3, 0.7, 0.93, 1.0)
"""Where a tooth has vertices across its width."""
_RECESS_MM = (1.3, 0.45, 0.0, 0.0, 0.45, 1.3)
"""How far it stands back there, how much its edge and, towards it, its gum is rounded."""
_EDGE_ROUNDING_MM = (1.0, 0.35, 0.0, 0.0, 0.35, 1.0)
_SCALLOP_MM = (-1.6, -0.7, 0.0, 0.0, -0.7, -1.6)
_GUM_MM = 7.0
_TEXTURE = (64, 32)
"""Rows and columns: gums above row 16, teeth to row 48 from neck to edge, tongue below."""

_ROWS = 7
_TONGUE_ROWS, _TONGUE_COLUMNS = 10, 9


class Jaws(NamedTuple):
    """Teeth, gums and tongue.

    Attributes:
        vertices: ``(V, 3)``, mm, in occlusion.
        faces: ``(F, 3)`` int32, counter-clockwise from outside.
        uv: ``(V, 2)`` float32.
        lower: ``(V,)`` bool, what the jaw carries.
    """

    vertices: Points
    faces: NDArray[np.int32]
    uv: NDArray[np.float32]
    lower: NDArray[np.bool_]


def _along_arch(lengths: Points, half_width: float, depth: float) -> tuple[Points, Points]:
    """Return points ``(n, 2)`` (x, z) and outward normals at lengths from the middle of an arch."""
    angle = np.linspace(-np.pi / 2, np.pi / 2, 721)
    curve = np.stack([half_width * np.sin(angle), depth * (np.cos(angle) - 1.0)], axis=1)
    steps = np.linalg.norm(np.diff(curve, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(steps)]) - steps.sum() / 2
    at = np.interp(lengths, along, angle)
    points = np.stack([half_width * np.sin(at), depth * (np.cos(at) - 1.0)], axis=1)
    normals = np.stack([depth * np.sin(at), half_width * np.cos(at)], axis=1)
    return points, normals / np.linalg.norm(normals, axis=1, keepdims=True)


def _grid_faces(rows: int, columns: int, start: int) -> NDArray[np.int64]:
    index = start + np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    return np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)


def _tooth(
    arch: tuple[float, float, float, float],
    span: tuple[float, float],
    crown: float,
    edge: float,
    up: float,
) -> tuple[Points, Points]:
    """Make one tooth with its gum: ``(7, 6, 3)`` points from gum to back, and their uv."""
    height, front, half_width, length = arch
    columns, recess = np.array(_COLUMNS), np.array(_RECESS_MM)
    middle, normal = _along_arch(span[0] + (span[1] - span[0]) * columns, half_width, length)
    cut = height + up * (edge + np.array(_EDGE_ROUNDING_MM))
    neck = height + up * (edge + crown + np.array(_SCALLOP_MM))
    rows = (  # y, stands back by, v
        (np.full(6, height + up * (edge + crown + _GUM_MM)), np.full(6, 0.5), 0.0),
        (neck + 0.4 * up, 0.2 + 0.5 * recess, 0.24),
        (neck, 0.5 + 0.7 * recess, 0.27),
        (0.55 * neck + 0.45 * cut, -0.1 + recess, 0.5),
        (cut, 0.35 + recess, 0.68),
        (cut + 0.4 * up, 1.9 + 0.4 * recess, 0.72),
        (neck, np.full(6, 6.0), 0.74),
    )
    points = np.zeros((_ROWS, 6, 3))
    uv = np.zeros((_ROWS, 6, 2))
    for row, (y, back, v) in enumerate(rows):
        at = middle - normal * back[:, None]
        points[row] = np.stack([at[:, 0], y, front + at[:, 1]], axis=1)
        uv[row] = np.stack([0.03 + 0.94 * columns, np.full(6, v)], axis=1)
    return points, uv


def _tongue() -> tuple[Points, Points]:
    """Make a dome behind the lower teeth, from tip to root: ``(rows, columns, 3)`` and uv."""
    t = np.linspace(0.0, 1.0, _TONGUE_ROWS)[:, None]
    s = np.linspace(-1.0, 1.0, _TONGUE_COLUMNS)[None]
    half = 19.5 * np.sqrt(np.clip(1.0 - (1.0 - np.minimum(1.0, t / 0.45 + 0.03)) ** 2.2, 0, 1))
    x = half * np.sin(0.5 * np.pi * s)
    y = -79.0 + 7.0 * np.sin(0.5 * np.pi * np.minimum(1.0, t / 0.6)) - 10.0 * s**4
    y = y - 1.5 * np.exp(-((s / 0.16) ** 2)) * np.minimum(1.0, 3 * t)
    z = -5.0 - 48.0 * t - 2.0 * s**2
    points = np.stack(np.broadcast_arrays(x, y, z), axis=-1)
    uv = np.stack(np.broadcast_arrays(0.5 + 0.47 * s, 0.8 + 0.18 * t), axis=-1)
    return points, uv


@lru_cache(maxsize=1)
def build_jaws() -> Jaws:
    """Return everybody's teeth, gums and tongue; later calls are free."""
    pieces: list[tuple[Points, Points, bool]] = []  # points, uv, whether the jaw carries them
    for below, arch, widths, crowns, edges in (
        (False, _UPPER_ARCH, _UPPER_WIDTHS_MM, _UPPER_CROWNS_MM, _UPPER_EDGES_MM),
        (True, _LOWER_ARCH, _LOWER_WIDTHS_MM, _LOWER_CROWNS_MM, _LOWER_EDGES_MM),
    ):
        up = -1.0 if below else 1.0
        ends = np.concatenate([[0.0], np.cumsum(widths)])
        for k, (crown, edge) in enumerate(zip(crowns, edges, strict=True)):
            for span in ((ends[k], ends[k + 1]), (-ends[k + 1], -ends[k])):
                pieces.append((*_tooth(arch, span, crown, edge, up), below))
    pieces.append((*_tongue(), True))
    faces, lower = [], np.zeros(0, bool)
    for grid, _, below in pieces:
        made = _grid_faces(grid.shape[0], grid.shape[1], start=len(lower))
        faces.append(made[:, ::-1] if below else made)
        lower = np.append(lower, np.full(grid.shape[0] * grid.shape[1], below))
    return Jaws(
        np.concatenate([grid.reshape(-1, 3) for grid, _, _ in pieces]),
        np.concatenate(faces).astype(np.int32),
        np.concatenate([uv.reshape(-1, 2) for _, uv, _ in pieces]).astype(np.float32),
        lower,
    )


def paint_jaws(age: float, shade: float) -> NDArray[np.float32]:
    """Paint the one texture that all teeth share, the gums and the tongue.

    Args:
        age: 0 (25 years) to 1 (old).
        shade: A person's own: standard normal, > 0 is darker.

    Returns:
        ``(64, 32, 3)`` float32, linear reflectance: young incisors about 0.5, between Vita A1 and
        A3 (O'Brien et al. 1990 measured Munsell values of 7 to 8.5).
    """
    height, width = _TEXTURE
    v = ((np.arange(height) + 0.5) / height)[:, None, None]
    u = ((np.arange(width) + 0.5) / width)[None, :, None]
    dark = np.clip(0.45 * age + 0.12 * shade, -0.2, 0.7)
    edge = np.array([0.52, 0.47, 0.39]) * (1.0 - dark * np.array([0.35, 0.45, 0.62]))
    neck = np.array([0.47, 0.38, 0.26]) * (1.0 - dark * np.array([0.35, 0.45, 0.62]))
    tooth = neck + (edge - neck) * smoothstep(0.25, 0.55, v)
    gap = np.minimum(u, 1.0 - u)
    tooth = tooth * (0.5 + 0.5 * smoothstep(0.03, 0.09, gap))
    tooth = tooth * (1.0 - 0.45 * smoothstep(0.69, 0.73, v))
    gum = np.array([0.36, 0.15, 0.14]) * (0.85 + 0.15 * smoothstep(0.03, 0.2, gap))
    tongue = np.array([0.34, 0.125, 0.12]) * (1.0 - 0.55 * smoothstep(0.82, 0.97, v))
    tongue = tongue * (1.0 - 0.25 * np.exp(-(((u - 0.5) / 0.05) ** 2)))
    texture = gum + (tooth - gum) * smoothstep(0.245, 0.265, v)
    texture = np.where(v > 0.765, tongue, texture)
    return np.ascontiguousarray(texture, dtype=np.float32)
