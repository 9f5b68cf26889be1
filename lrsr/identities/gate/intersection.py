"""Does a head's skin pass through itself? Nose and lips, on every second line of the mesh."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lrsr.identities.gate.coarse import Faces, Points, coarse_head
from lrsr.identities.planes import cross, dot

_REACH_MM = 2.4
_APART_MM = 4.0
_CELL_MM = 1.5
_LIPS_X_MM = 24.0


def _edges_cross(one: Points, other: Points) -> NDArray[np.bool_]:
    """Tell which triangles have an edge that passes through another triangle.

    Moeller and Trumbore, "Fast, minimum storage ray/triangle intersection" (1997), for the three
    edges; triangles in one plane do not count as crossing.

    Args:
        one: ``(n, 3, 3)`` corners, whose edges are taken.
        other: ``(n, 3, 3)`` corners.

    Returns:
        ``(n,)``.
    """
    a, b, c = np.ascontiguousarray(other.transpose(1, 2, 0))
    first, second = b - a, c - a
    starts = np.ascontiguousarray(one.transpose(1, 2, 0))
    crossing = np.zeros(len(one), bool)
    for start, end in zip(starts, np.roll(starts, -1, axis=0), strict=True):
        along, offset = end - start, start - a
        normal, turned = cross(along, second), cross(offset, first)
        determinant = dot(first, normal)
        inverse = 1.0 / np.where(np.abs(determinant) < 1e-14, np.inf, determinant)
        u, v, t = dot(offset, normal), dot(along, turned), dot(second, turned)
        u, v, t = u * inverse, v * inverse, t * inverse
        crossing |= (u >= 0) & (v >= 0) & (u + v <= 1) & (t >= 0) & (t <= 1) & (inverse != 0)
    return crossing


def _crossing_pairs(
    vertices: Points, faces: Faces, usual: Points, *, reach_mm: float, apart_mm: float
) -> Faces:
    """Find pairs of triangles that cross and share no corner.

    Args:
        vertices: ``(V, 3)``, mm.
        faces: ``(F, 3)``.
        usual: ``(F, 3)`` centres of the triangles on the template, mm.
        reach_mm: Only triangles whose centres are nearer than this are compared.
        apart_mm: Only triangles that are as far apart there are compared.

    Returns:
        ``(n, 2)`` indices of faces, the smaller first.
    """
    corners = np.take(vertices, faces, axis=0)
    tree = cKDTree(corners.mean(axis=1), balanced_tree=False, compact_nodes=False)
    pairs = tree.query_pairs(reach_mm, output_type="ndarray")
    away = np.take(usual, pairs[:, 0], axis=0) - np.take(usual, pairs[:, 1], axis=0)
    pairs = pairs[np.einsum("nc,nc->n", away, away) >= apart_mm**2]
    one, other = pairs.T
    touching = np.ones(len(pairs), bool)
    for low, high in zip(corners.min(axis=1).T, corners.max(axis=1).T, strict=True):
        touching &= np.take(low, one) <= np.take(high, other)
        touching &= np.take(low, other) <= np.take(high, one)
    pairs = pairs[touching]
    shared = (faces[pairs[:, 0], :, None] == faces[pairs[:, 1], None, :]).any(axis=(1, 2))
    pairs = pairs[~shared]
    p, q = corners[pairs[:, 0]], corners[pairs[:, 1]]
    return np.asarray(pairs[_edges_cross(p, q) | _edges_cross(q, p)], dtype=np.int64)


@lru_cache(maxsize=1)
def _nose_faces() -> tuple[Faces, Points]:
    """Return the coarse triangles around the nostrils and their centres on the template, mm."""
    head = coarse_head()
    x, y, z = head.folded()
    inside = (x < 17.0) & (y > -51.0) & (y < -40.0) & (z > 6.0)
    return head.faces[inside], head.centres[inside]


def count_nose_crossings(skin: Points) -> int:
    """Count pairs of coarse triangles that cross where nostrils collapse; the template has none.

    Pairs that lie less than 4 mm apart on the template are creases, and do not count.

    Args:
        skin: ``(V, 3)`` render vertices, mm.
    """
    faces, usual = _nose_faces()
    return len(_crossing_pairs(skin, faces, usual, reach_mm=_REACH_MM, apart_mm=_APART_MM))


@lru_cache(maxsize=1)
def _lips() -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Vertices of upper and lower lip that face each other on the template, up to their borders."""
    head = coarse_head()
    x, y, z = head.folded()
    up = head.across[:, 1]
    near = (x < _LIPS_X_MM) & (z > -2.0)
    upper = near & (up < 0) & (y > -74.0) & (y < -65.0)
    lower = near & (up > 0) & (y < -73.0) & (y > -81.0)
    return np.unique(head.faces[upper]), np.unique(head.faces[lower])


def lip_overlap_mm(skin: Points) -> float:
    """Return how deep the lips press into each other where they do so most.

    Real lips at rest flatten against each other; meshes pass through each other instead, which
    shows only when it is deep. Both faces of the mouth's slit are looked at from above, in cells of
    1.5 mm: by how much the lower lip's highest point there lies above the upper lip's lowest.

    Args:
        skin: ``(V, 3)`` render vertices, mm.
    """
    upper, lower = _lips()
    points = np.concatenate([skin[upper], skin[lower]])
    cell = np.floor((points[:, [0, 2]] - points[:, [0, 2]].min(axis=0)) / _CELL_MM).astype(np.int64)
    key = cell[:, 0] * (cell[:, 1].max() + 1) + cell[:, 1]
    n = len(upper)
    ceiling, floor = np.full(key.max() + 1, np.inf), np.full(key.max() + 1, -np.inf)
    np.minimum.at(ceiling, key[:n], points[:n, 1])
    np.maximum.at(floor, key[n:], points[n:, 1])
    both = np.isfinite(ceiling) & np.isfinite(floor)
    depth = np.sort((floor - ceiling)[both])
    return float(max(0.0, depth[-3:].mean())) if depth.size else 0.0
