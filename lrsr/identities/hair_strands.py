"""How does hair stop looking like a cap? Thousands of thin ribbons on, over and past its shell.

The layout (which column, which stretch of it, how wide, how twisted) is the same for all heads, so
faces and texture coordinates are shared; the shell under it and the style move it.
"""

from collections.abc import Mapping
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lrsr.identities.hair_shell import BEYOND_MM, COLUMNS, ROWS, Shell

Floats = NDArray[np.float64]

RIBBONS = 3600
POINTS = 8
_EDGE_SHARE = 0.45


class Layout(NamedTuple):
    """Where ribbons lie on the shell, for all heads.

    Attributes:
        column: ``(RIBBONS, POINTS)``, 0..COLUMNS - 1.
        row: ``(RIBBONS, POINTS)``, 0..ROWS + 2.
        half_width_mm: ``(RIBBONS, POINTS)``.
        twist: ``(RIBBONS,)`` radians about the strand.
        rise: ``(RIBBONS, POINTS)``, 0..1, share of the style's flyaway height.
        phase: ``(RIBBONS,)`` of the curls, radians.
    """

    column: Floats
    row: Floats
    half_width_mm: Floats
    twist: Floats
    rise: Floats
    phase: Floats


@lru_cache(maxsize=1)
def layout() -> Layout:
    """Return the fixed layout of the ribbons."""
    rng = np.random.default_rng(20)
    along = np.linspace(0.0, 1.0, POINTS)[None, :]
    count = np.arange(RIBBONS)
    u = (count * 0.6180339887498949) % 1.0
    edge = (count % 20) < round(20 * _EDGE_SHARE)
    last = ROWS - 1.0
    start = np.where(edge, rng.uniform(0.55, 0.9, RIBBONS), rng.uniform(0.0, 0.85, RIBBONS)) * last
    reach = np.where(
        edge,
        last + rng.uniform(-2.0, 1.9, RIBBONS) - start,
        rng.uniform(0.12, 0.38, RIBBONS) * last,
    )
    row = np.minimum(start[:, None] + reach[:, None] * along, last + len(BEYOND_MM) - 0.01)
    drift = rng.normal(0.0, 1.6, (RIBBONS, 1))
    column = np.clip(u[:, None] * (COLUMNS - 1) + drift * along, 0.0, COLUMNS - 1.001)
    width = rng.uniform(0.5, 1.5, (RIBBONS, 1)) * np.sin(np.pi * (0.12 + 0.86 * along)) ** 0.7
    rise = rng.beta(1.2, 2.4, (RIBBONS, 1)) * np.sin(np.pi * (0.9 * along + 0.02))
    return Layout(
        column,
        row,
        width,
        rng.normal(0.0, 0.45, RIBBONS),
        rise,
        rng.uniform(0.0, 2.0 * np.pi, RIBBONS),
    )


def lay_strands(parameters: Mapping[str, Any], shell: Shell, rng: np.random.Generator) -> Floats:
    """Return the ribbons' vertices, ``(RIBBONS, POINTS, 2, 3)`` mm: left and right edge."""
    plan = layout()
    stacked = np.concatenate([shell.points, shell.outward, shell.height[..., None]], axis=-1)
    sampled = _sample(stacked, plan.column, plan.row)
    centre, outward, height = sampled[..., :3], sampled[..., 3:6], sampled[..., 6]
    tangent = np.gradient(centre, axis=1)
    tangent /= np.maximum(np.linalg.norm(tangent, axis=-1, keepdims=True), 1e-6)
    across = np.cross(outward, tangent)
    across /= np.maximum(np.linalg.norm(across, axis=-1, keepdims=True), 1e-6)
    above = np.cross(tangent, across)
    if parameters["sunk_mm"] > 0:
        off = np.zeros_like(height)
        curl = 0.0
    else:
        thick = np.clip(height / 4.0, 0.15, 1.0)
        off = 0.35 + parameters["flyaway_mm"] * plan.rise * thick
        off = off + np.clip(0.6 - height, 0.0, 2.5) * 0.8
        curl = parameters["curl_mm"] * np.clip(height / 8.0, 0.0, 1.0)
    turns = plan.phase[:, None] + np.linspace(0.0, 4.5, POINTS)[None, :] * (
        1.0 + 0.3 * rng.normal(size=(RIBBONS, 1))
    )
    centre = centre + outward * (off + 0.5 * curl * (1 + np.cos(turns)))[..., None]
    centre = centre + across * (curl * np.sin(turns))[..., None]
    tilt = plan.twist[:, None, None]
    half = (np.cos(tilt) * across + np.sin(tilt) * above) * plan.half_width_mm[..., None]
    return np.stack([centre - half, centre + half], axis=2)


def strand_faces() -> NDArray[np.int32]:
    """Return the ribbons' triangles, ``(F, 3)``, outer side counter-clockwise."""
    first = np.arange(RIBBONS)[:, None] * (2 * POINTS) + 2 * np.arange(POINTS - 1)[None, :]
    left, right, next_left, next_right = first, first + 1, first + 2, first + 3
    faces = np.stack(
        [
            np.stack([left, next_left, right], axis=-1),
            np.stack([right, next_left, next_right], axis=-1),
        ],
        axis=2,
    )
    return faces.reshape(-1, 3).astype(np.int32)


def strand_uv() -> NDArray[np.float32]:
    """Return the ribbons' texture coordinates, ``(RIBBONS * POINTS * 2, 2)``."""
    plan = layout()
    u = plan.column[:, :1] / (COLUMNS - 1.0) + np.zeros((1, POINTS))
    v = np.clip(plan.row / (ROWS - 1.0), 0.0, 1.0)
    step = np.array([-0.0006, 0.0006])
    uv = np.stack(
        [np.clip(u[..., None] + step, 0.0, 1.0), np.broadcast_to(v[..., None], (*v.shape, 2))],
        axis=-1,
    )
    return uv.reshape(-1, 2).astype(np.float32)


def _sample(grid: Floats, column: Floats, row: Floats) -> Floats:
    c0 = np.clip(column.astype(np.intp), 0, grid.shape[0] - 2)
    r0 = np.clip(row.astype(np.intp), 0, grid.shape[1] - 2)
    fc, fr = (column - c0)[..., None], (row - r0)[..., None]
    near = grid[c0, r0] * (1 - fr) + grid[c0, r0 + 1] * fr
    far = grid[c0 + 1, r0] * (1 - fr) + grid[c0 + 1, r0 + 1] * fr
    return near * (1 - fc) + far * fc
