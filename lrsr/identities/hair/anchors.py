"""Where on a head does hair stand? A chart of the skull: azimuth and polar angle to skin points.

Rays leave the skull's centre of the *template* head and end on its skin, ears removed. Each end is
kept as a weighted sum of skin vertices, so that one sparse product carries the whole chart to any
other head of the same topology. Where a ray meets nothing (the ear's root, an eye socket) the chart
is interpolated along the azimuth.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.spatial import cKDTree

from lrsr.paths import asset

_Floats = NDArray[np.float64]

AZIMUTHS = 120
POLARS = 51
POLAR_STEP_DEG = 3.0
SKULL_CENTRE_MM = (0.0, 25.0, -82.0)
"""Centre of the chart in the template's head frame; polar 90 degrees is just above the ears."""

ASSET_NAME = "hair_anchors.npz"
_REACH_MM = 175.0
_CANDIDATES = 48


@dataclass(frozen=True)
class Anchors:
    """The chart, ready for any head of the template's topology.

    Attributes:
        matrix: Sparse ``(AZIMUTHS * POLARS, V)``; rows sum to 1; times vertices = chart points.
        ears: Indices of skin vertices that belong to the ears.
        template: ``(AZIMUTHS, POLARS, 3)`` chart points of the template itself, mm.
    """

    matrix: Any
    ears: NDArray[np.int32]
    template: _Floats

    def locate(self, skin_vertices: NDArray[np.float32]) -> _Floats:
        """Return the chart of one head.

        Args:
            skin_vertices: ``(V, 3)``, mm, in the template's topology.

        Returns:
            ``(AZIMUTHS, POLARS, 3)``, mm; azimuth 0 is the face, 90 degrees the subject's left.
        """
        points: _Floats = self.matrix @ np.asarray(skin_vertices, dtype=np.float64)
        return points.reshape(AZIMUTHS, POLARS, 3)


def _chart_directions() -> _Floats:
    """Return the rays of the chart, ``(AZIMUTHS, POLARS, 3)`` unit vectors."""
    azimuth = np.deg2rad(np.arange(AZIMUTHS) * 360.0 / AZIMUTHS)[:, None]
    polar = np.deg2rad(np.arange(POLARS) * POLAR_STEP_DEG)[None, :]
    x, z = np.sin(azimuth) * np.sin(polar), np.cos(azimuth) * np.sin(polar)
    return np.stack([x, np.broadcast_to(np.cos(polar), x.shape), z], axis=-1)


def chart_angles(points: NDArray[np.floating[Any]]) -> tuple[_Floats, _Floats]:
    """Return azimuth (-180..180) and polar angle (0..180), degrees, of canonical points.

    Args:
        points: ``(..., 3)``, mm, in the template's head frame.

    Example:
        >>> azimuth, polar = chart_angles(np.array([0.0, 25.0, 0.0]))
        >>> float(azimuth), round(float(polar), 6)
        (0.0, 90.0)
    """
    offset = np.asarray(points, dtype=np.float64) - np.asarray(SKULL_CENTRE_MM)
    azimuth = np.rad2deg(np.arctan2(offset[..., 0], offset[..., 2]))
    polar = np.rad2deg(np.arctan2(np.hypot(offset[..., 0], offset[..., 2]), offset[..., 1]))
    return azimuth, polar


def build_anchors(
    vertices: _Floats, faces: NDArray[np.int32], ear_vertices: NDArray[np.int32]
) -> Anchors:
    """Cast the rays of the chart on a template head (once, when the assets are made).

    Args:
        vertices: ``(V, 3)`` skin of the template, head frame, mm.
        faces: ``(F, 3)`` triangles.
        ear_vertices: Indices of the vertices of the ears, whose triangles no ray may meet.
    """
    is_ear = np.zeros(len(vertices), dtype=bool)
    is_ear[ear_vertices] = True
    skull = faces[~is_ear[faces].any(axis=1)]
    rays = _chart_directions().reshape(-1, 3)
    triangle, weights = _outermost_hits(vertices, skull, rays)
    hit = (triangle >= 0).reshape(AZIMUTHS, POLARS)
    index = np.repeat(np.arange(len(rays)), 3)
    found = sparse.csr_matrix(
        (weights.ravel(), (index, skull[np.maximum(triangle, 0)].ravel())),
        shape=(len(rays), len(vertices)),
    )
    matrix = (_filling(hit) @ found).astype(np.float32).tocsr()
    template = (matrix @ vertices).reshape(AZIMUTHS, POLARS, 3)
    return Anchors(matrix, np.asarray(ear_vertices, dtype=np.int32), template)


def anchor_arrays(anchors: Anchors) -> dict[str, NDArray[Any]]:
    """Return the arrays that :func:`load_anchors` reads, for ``numpy.savez_compressed``."""
    return {
        "data": anchors.matrix.data.astype(np.float32),
        "indices": anchors.matrix.indices.astype(np.int32),
        "indptr": anchors.matrix.indptr.astype(np.int32),
        "vertex_count": np.array(anchors.matrix.shape[1]),
        "ears": anchors.ears,
        "template": anchors.template.astype(np.float32),
    }


@lru_cache(maxsize=1)
def load_anchors() -> Anchors:
    """Return the shipped chart of the template head (read once)."""
    with np.load(asset(ASSET_NAME)) as arrays:
        shape = (AZIMUTHS * POLARS, int(arrays["vertex_count"]))
        matrix = sparse.csr_matrix(
            (arrays["data"], arrays["indices"], arrays["indptr"]), shape=shape
        )
        return Anchors(matrix, arrays["ears"], arrays["template"].astype(np.float64))


def _outermost_hits(
    vertices: _Floats, faces: NDArray[np.int32], rays: _Floats
) -> tuple[NDArray[np.int64], _Floats]:
    """Return per ray the index of the outermost triangle hit (-1: none) and its barycentrics.

    Only the triangles whose centroids lie nearest in direction are tried.
    """
    corners = vertices[faces] - np.asarray(SKULL_CENTRE_MM)
    centroids = corners.mean(axis=1)
    directions = centroids / np.linalg.norm(centroids, axis=1, keepdims=True)
    _, near = cKDTree(directions).query(rays, k=min(_CANDIDATES, len(faces)))
    a = corners[near, 0]
    e1, e2 = corners[near, 1] - a, corners[near, 2] - a
    h = np.cross(rays[:, None, :], e2)
    determinant = np.einsum("rkc,rkc->rk", e1, h)
    safe = np.where(np.abs(determinant) < 1e-12, 1.0, determinant)
    u = np.einsum("rkc,rkc->rk", -a, h) / safe
    q = np.cross(-a, e1)
    v = np.einsum("rc,rkc->rk", rays, q) / safe
    t = np.einsum("rkc,rkc->rk", e2, q) / safe
    eps = 1e-6
    inside = (u >= -eps) & (v >= -eps) & (u + v <= 1 + eps) & (t > 1.0) & (t < _REACH_MM)
    inside &= np.abs(determinant) >= 1e-12
    best = np.argmax(np.where(inside, t, -1.0), axis=1)
    row = np.arange(len(rays))
    triangle = np.where(inside.any(axis=1), near[row, best], -1)
    weights = np.stack([1 - u[row, best] - v[row, best], u[row, best], v[row, best]], axis=1)
    return triangle, np.clip(weights, 0.0, 1.0)


def _filling(hit: NDArray[np.bool_]) -> Any:
    """Return the sparse matrix that interpolates missing chart points along the azimuth."""
    azimuth = np.arange(AZIMUTHS)
    before, after = np.empty(hit.shape, np.intp), np.empty(hit.shape, np.intp)
    for polar in range(POLARS):
        good = np.flatnonzero(hit[:, polar])
        after[:, polar] = good[np.searchsorted(good, azimuth) % len(good)]
        before[:, polar] = good[np.searchsorted(good, azimuth, side="right") - 1]
    share = (azimuth[:, None] - before) % AZIMUTHS / np.maximum((after - before) % AZIMUTHS, 1)
    columns = np.concatenate([before, after]) * POLARS + np.arange(POLARS)
    rows = np.tile(np.arange(hit.size), 2)
    values = np.concatenate([1.0 - share, share]).ravel()
    return sparse.csr_matrix((values, (rows, columns.ravel())), shape=(hit.size, hit.size))
