"""How does hair stop looking like a cap? Thousands of thin ribbons on, over and past its shell.

The layout (which column, which stretch of it, how wide, how twisted) is the same for all heads, so
faces and texture coordinates are shared; the shell under it and the style move it.
"""

from collections.abc import Mapping
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from lrsr.identities.hair_paths import COLUMNS
from lrsr.identities.hair_shell import BEYOND_MM, ROWS, Shell

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]

RIBBONS = 3600
POINTS = 8
CURLY_FROM_MM = 2.0
"""Curls of at least this radius take short ribbons of several turns, smaller ones long strands."""

_EDGE_SHARE = 0.45
_CURLY_REACH = 0.4


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
    half_width_mm: Singles
    twist: Singles
    rise: Singles
    phase: Singles


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
        width.astype(np.float32),
        rng.normal(0.0, 0.45, RIBBONS).astype(np.float32),
        rise.astype(np.float32),
        rng.uniform(0.0, 2.0 * np.pi, RIBBONS).astype(np.float32),
    )


def lay_strands(parameters: Mapping[str, Any], shell: Shell, rng: np.random.Generator) -> Singles:
    """Return the ribbons' vertices, ``(RIBBONS, POINTS, 2, 3)`` mm: left and right edge."""
    plan = layout()
    curly = parameters["curl_mm"] >= CURLY_FROM_MM
    stacked = np.concatenate([shell.points, shell.outward, shell.height[..., None]], axis=-1)
    sampled = _sampler(curly) @ stacked.reshape(-1, 7).astype(np.float32)
    sampled = sampled.reshape(RIBBONS, POINTS, 7)
    centre, outward, height = sampled[..., :3], sampled[..., 3:6], sampled[..., 6]
    tangent = _unit(_along(centre))
    across = _unit(_cross(outward, tangent))
    if parameters["sunk_mm"] <= 0:
        thick = np.clip(height / 4.0, 0.15, 1.0)
        off = 0.35 + parameters["flyaway_mm"] * plan.rise * thick
        off += np.clip(0.6 - height, 0.0, 2.5) * 0.8
        curl = parameters["curl_mm"] * np.clip(height / 8.0, 0.0, 1.0)
        turns = np.linspace(0.0, 8.0 if curly else 4.5, POINTS, dtype=np.float32)[None, :]
        turns = turns * rng.uniform(0.6, 1.4, (RIBBONS, 1)).astype(np.float32)
        turns += plan.phase[:, None]
        centre = centre + outward * (off + 0.5 * curl * (1 + np.cos(turns)))[..., None]
        centre += across * (curl * np.sin(turns))[..., None]
    tilt = plan.twist[:, None, None]
    half = np.cos(tilt) * across + np.sin(tilt) * _cross(tangent, across)
    half *= plan.half_width_mm[..., None]
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


def strand_uv() -> Singles:
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


@lru_cache(maxsize=2)
def _sampler(curly: bool) -> Any:
    """Sparse ``(RIBBONS * POINTS, COLUMNS * (ROWS + 3))``: the shell, bilinear, at the ribbons."""
    plan = layout()
    rows = ROWS + len(BEYOND_MM)
    row = plan.row
    if curly:
        end = row[:, -1:]
        row = end + (row - end) * _CURLY_REACH
    column, row = plan.column.ravel(), row.ravel()
    c0 = np.clip(column.astype(np.int64), 0, COLUMNS - 2)
    r0 = np.clip(row.astype(np.int64), 0, rows - 2)
    fc, fr = column - c0, row - r0
    corners = [c0 * rows + r0, c0 * rows + r0 + 1, (c0 + 1) * rows + r0, (c0 + 1) * rows + r0 + 1]
    weights = [(1 - fc) * (1 - fr), (1 - fc) * fr, fc * (1 - fr), fc * fr]
    place = np.tile(np.arange(len(column)), 4)
    values = np.concatenate(weights).astype(np.float32)
    return sparse.csr_matrix(
        (values, (place, np.concatenate(corners))), shape=(len(column), COLUMNS * rows)
    )


def _along(points: Singles) -> Singles:
    """Differences along the ribbon, one-sided at its ends."""
    step = np.empty_like(points)
    step[:, 1:-1] = points[:, 2:] - points[:, :-2]
    step[:, 0] = points[:, 1] - points[:, 0]
    step[:, -1] = points[:, -1] - points[:, -2]
    return step


def _cross(a: Singles, b: Singles) -> Singles:
    result = np.empty_like(a)
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        result[..., i] = a[..., j] * b[..., k] - a[..., k] * b[..., j]
    return result


def _unit(vectors: Singles) -> Singles:
    length = np.sqrt(np.einsum("...c,...c->...", vectors, vectors))
    scaled: Singles = vectors / np.maximum(length, 1e-6)[..., None]
    return scaled
