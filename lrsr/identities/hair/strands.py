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

from lrsr.identities.hair.paths import COLUMNS
from lrsr.identities.hair.shell import BEYOND_MM, ROWS, Shell
from lrsr.identities.hair.texture import RIBBON_COLUMNS, SHELL_COLUMNS, TEXTURE_SHAPE
from lrsr.identities.planes import cross, dot

_Floats = NDArray[np.float64]
_Singles = NDArray[np.float32]

_RIBBONS = 10800
_POINTS = 6
_CURLY_FROM_MM = 2.0
"""Curls of at least this radius take short ribbons of a turn each, smaller ones long strands."""

_CURLY_REACH = 4.5
_CURLY_WIDTH = 1.6
_KINDS = 20
_EDGES = 9
_FINE = 2
_FLYAWAY = 1
_PARTED = 0.02
_PARTED_REACH = 4.0


class _Layout(NamedTuple):
    """Where ribbons lie on the shell, for all heads.

    Attributes:
        column: ``(RIBBONS, POINTS)``, 0..COLUMNS - 1.
        row: ``(RIBBONS, POINTS)``, 0..ROWS + 2.
        stubble_row: Likewise, of clipped heads: short, evenly spread.
        half_width_mm: ``(RIBBONS, POINTS)``.
        twist: ``(RIBBONS,)`` radians about the strand.
        rise: ``(RIBBONS, POINTS)``, 0..1, share of the style's flyaway height.
        stray: ``(RIBBONS, POINTS)``, how far it leaves its column, share of the flyaway height.
        phase: ``(RIBBONS,)`` of the curls, radians.
    """

    column: _Floats
    row: _Floats
    stubble_row: _Floats
    half_width_mm: _Singles
    twist: _Singles
    rise: _Singles
    stray: _Singles
    phase: _Singles


@lru_cache(maxsize=1)
def _layout() -> _Layout:
    """Return the fixed layout of the ribbons.

    Of 20 ribbons 9 carry the edge, a fine one goes past it, a fine one frays the open edge of
    parted hair and one flies off; the others lie on the shell.
    """
    rng = np.random.default_rng(20)
    along = np.linspace(0.0, 1.0, _POINTS)[None, :]
    count = np.arange(_RIBBONS)
    kind = count % _KINDS
    edge, fine = kind < _EDGES, kind >= _KINDS - _FINE
    baby = kind == _KINDS - 1
    flyaway = (kind >= _EDGES) & (kind < _EDGES + _FLYAWAY)
    u = (count * 0.6180339887498949) % 1.0
    open_edge = np.where(u < 0.5, _PARTED * u * 2.0, 1.0 - _PARTED * (1.0 - u) * 2.0)
    u = np.where(baby, open_edge, u)
    last = ROWS - 1.0
    start = (
        np.where(edge, rng.uniform(0.5, 0.92, _RIBBONS), rng.uniform(0.0, 0.85, _RIBBONS)) * last
    )
    start = np.where(fine, last - rng.uniform(0.0, 4.0, _RIBBONS), start)
    end = np.where(edge, last - 1.0 + 3.6 * rng.beta(3.0, 3.0, _RIBBONS), 0.0)
    end = np.where(fine, last + rng.uniform(0.5, 2.95, _RIBBONS), end)
    body = start + rng.uniform(0.12, 0.38, _RIBBONS) * last
    end = np.where(edge | fine, end, np.minimum(body, last))
    start = np.where(baby, rng.uniform(0.0, 0.5, _RIBBONS) * last, start)
    end = np.where(baby, start + rng.uniform(3.0, 8.0, _RIBBONS), end)
    row = start[:, None] + (end - start)[:, None] * along
    drift = rng.normal(0.0, 1.4, (_RIBBONS, 1))
    column = np.clip(u[:, None] * (COLUMNS - 1) + drift * along, 0.0, COLUMNS - 1.001)
    stubble = np.sqrt(rng.random((_RIBBONS, 1))) * (last + 1.2)
    stubble = stubble + rng.uniform(0.5, 1.2, (_RIBBONS, 1)) * along
    width = rng.uniform(0.2, 0.5, _RIBBONS) * np.where(fine, 0.5, 1.0)
    half = width[:, None] * np.sin(np.pi * (0.14 + 0.8 * along)) ** 0.7
    rise = rng.beta(1.2, 2.4, (_RIBBONS, 1)) * np.where(flyaway, 2.2, 1.0)[:, None]
    stray = rng.normal(0.0, 1.0, (_RIBBONS, 1)) * np.where(flyaway, 4.0, 1.0)[:, None]
    towards_face = np.where(u < 0.5, -1.0, 1.0) * rng.uniform(0.2, 1.0, _RIBBONS)
    stray = np.where(baby[:, None], _PARTED_REACH * towards_face[:, None], stray)
    return _Layout(
        column,
        row,
        np.minimum(stubble, last + len(BEYOND_MM) - 0.01),
        half.astype(np.float32),
        rng.normal(0.0, 0.45, _RIBBONS).astype(np.float32),
        (rise * np.sin(np.pi * (0.9 * along + 0.02))).astype(np.float32),
        (stray * along**2).astype(np.float32),
        rng.uniform(0.0, 2.0 * np.pi, _RIBBONS).astype(np.float32),
    )


def lay_strands(parameters: Mapping[str, Any], shell: Shell, rng: np.random.Generator) -> _Singles:
    """Return the ribbons' vertices, ``(RIBBONS, POINTS, 2, 3)`` mm: left and right edge."""
    plan = _layout()
    stubble = parameters["stubble_mm"] > 0
    curly = _is_curly(parameters)
    stacked = np.concatenate([shell.points, shell.outward, shell.height[..., None]], axis=-1)
    sampler = _sampler("stubble" if stubble else "curly" if curly else "straight")
    sampled = (sampler @ stacked.reshape(-1, 7).astype(np.float32)).T
    planes = np.ascontiguousarray(sampled).reshape(7, _RIBBONS, _POINTS)
    centre, outward, height = planes[:3], planes[3:6], planes[6]
    tangent = _unit(np.gradient(centre, axis=2))
    across = _unit(cross(outward, tangent))
    if stubble:
        along = np.linspace(0.0, 1.0, _POINTS, dtype=np.float32)
        up = rng.uniform(0.3, 1.0, (_RIBBONS, 1)).astype(np.float32) * along
        centre = centre + outward * (0.1 - height + parameters["stubble_mm"] * up)
        centre += across * (0.5 * plan.stray)
    elif parameters["sunk_mm"] <= 0:
        off, aside = _loosen(parameters, height, rng)
        centre = centre + outward * off
        centre += across * aside
    tilt = plan.twist[:, None]
    half = np.cos(tilt) * across + np.sin(tilt) * cross(tangent, across)
    half *= (_CURLY_WIDTH if curly else 1.0) * plan.half_width_mm
    return np.ascontiguousarray(np.stack([centre - half, centre + half]).transpose(2, 3, 0, 1))


def _is_curly(parameters: Mapping[str, Any]) -> bool:
    """Whether short hair curls; long hair waves."""
    return bool(parameters["curl_mm"] >= _CURLY_FROM_MM and parameters["hang"] == 0.0)


def _loosen(
    parameters: Mapping[str, Any], height: _Singles, rng: np.random.Generator
) -> tuple[_Singles, _Singles]:
    """Curl strands and let some fly: shifts off the shell and along it, mm."""
    plan = _layout()
    curly = _is_curly(parameters)
    thick = np.clip(height / 4.0, 0.15, 1.0)
    off = 0.35 + parameters["flyaway_mm"] * plan.rise * thick
    off += np.clip(0.6 - height, 0.0, 2.5) * 0.8
    curl = parameters["curl_mm"] * np.clip(height / 8.0, 0.0, 1.0)
    turns = np.linspace(0.0, 7.0 if curly else 4.5, _POINTS, dtype=np.float32)[None, :]
    turns = turns * rng.uniform(0.6, 1.4, (_RIBBONS, 1)).astype(np.float32)
    turns += plan.phase[:, None]
    off += 0.5 * curl * (1 + np.cos(turns))
    aside = curl * np.sin(turns) + 0.22 * parameters["flyaway_mm"] * plan.stray
    return off, aside


def strand_faces() -> NDArray[np.int32]:
    """Return the ribbons' triangles, ``(F, 3)``, outer side counter-clockwise."""
    first = np.arange(_RIBBONS)[:, None] * (2 * _POINTS) + 2 * np.arange(_POINTS - 1)[None, :]
    two_triangles = np.array([0, 2, 1, 1, 2, 3])  # left, right, next left, next right
    return np.asarray((first[..., None] + two_triangles).reshape(-1, 3), dtype=np.int32)


def strand_uv() -> _Singles:
    """Return the ribbons' texture coordinates, ``(RIBBONS * POINTS * 2, 2)``."""
    plan = _layout()
    shade = plan.column[:, :1] / (COLUMNS - 1.0)
    shade = shade + np.random.default_rng(21).normal(0.0, 0.02, (_RIBBONS, 1))
    first = SHELL_COLUMNS + 1.0 + (RIBBON_COLUMNS - 2.0) * np.clip(shade, 0.0, 1.0)
    u = first / TEXTURE_SHAPE[1] + np.zeros((1, _POINTS))
    v = np.clip(plan.row / (ROWS - 1.0), 0.0, 1.0)
    u = np.clip(u[..., None] + np.array([-0.0002, 0.0002]), 0.0, 1.0)
    uv = np.stack([u, np.broadcast_to(v[..., None], u.shape)], axis=-1)
    return uv.reshape(-1, 2).astype(np.float32)


@lru_cache(maxsize=3)
def _sampler(kind: str) -> Any:
    """Sparse ``(RIBBONS * POINTS, COLUMNS * (ROWS + 3))``: the shell, bilinear, at the ribbons."""
    plan = _layout()
    rows = ROWS + len(BEYOND_MM)
    row = plan.stubble_row if kind == "stubble" else plan.row
    if kind == "curly":
        start = plan.stubble_row[:, :1]
        row = np.minimum(start + (plan.stubble_row - start) * _CURLY_REACH, rows - 1.01)
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


def _unit(vectors: _Singles) -> _Singles:
    """Shorten or lengthen vectors ``(3, ...)`` to 1."""
    length = np.maximum(np.sqrt(dot(vectors, vectors)), 1e-6)
    return np.asarray(vectors / length, dtype=np.float32)
