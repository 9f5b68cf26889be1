"""Does a head's skin pass through itself? Nose and lips, on every second line of the mesh.

Catmull-Clark leaves the lines of the first round in the mesh of the second, so a quarter of the
quads, corner by corner, is a coarser head whose vertices lie on the fine one. Two sheets that cross
deeply enough to be seen cross there too.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lrsr.identities.face.template import template
from lrsr.identities.shape.basis import load_basis

Points = NDArray[np.float64]
Faces = NDArray[np.int64]

_REACH_MM = 2.4
_APART_MM = 4.0
_CELL_MM = 1.5
_LIPS_X_MM = 24.0


@lru_cache(maxsize=1)
def coarse_faces() -> Faces:
    """Return triangles of the coarse head, vertices at one place under one index: ``(F / 4, 3)``.

    Four quads of the fine mesh in a row make one of the coarse; each starts at one of its corners.
    """
    surface = load_basis().surface
    quads = surface.twin[surface.faces[::2, 0]].reshape(-1, 4)
    triangles = np.stack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]], axis=1).reshape(-1, 3)
    head = np.repeat(surface.region[::2].reshape(-1, 4)[:, 0] == 0, 2)
    return np.asarray(triangles[head], dtype=np.int64)


def edges_cross(one: Points, other: Points) -> NDArray[np.bool_]:
    """Tell which triangles have an edge that passes through another triangle.

    Moeller and Trumbore, "Fast, minimum storage ray/triangle intersection" (1997), for the three
    edges; triangles in one plane do not count as crossing.

    Args:
        one: ``(n, 3, 3)`` corners, whose edges are taken.
        other: ``(n, 3, 3)`` corners.

    Returns:
        ``(n,)``.
    """
    a = other[:, 0]
    first, second = other[:, 1] - a, other[:, 2] - a
    crossing = np.zeros(len(one), bool)
    for k in range(3):
        start = one[:, k]
        along = one[:, (k + 1) % 3] - start
        normal = np.cross(along, second)
        determinant = np.einsum("nc,nc->n", first, normal)
        inverse = 1.0 / np.where(np.abs(determinant) < 1e-14, np.inf, determinant)
        offset = start - a
        u = np.einsum("nc,nc->n", offset, normal) * inverse
        turned = np.cross(offset, first)
        v = np.einsum("nc,nc->n", along, turned) * inverse
        t = np.einsum("nc,nc->n", second, turned) * inverse
        within = (u >= 0) & (v >= 0) & (u + v <= 1) & (t >= 0) & (t <= 1) & (inverse != 0)
        crossing |= within
    return crossing


def crossing_pairs(
    vertices: Points,
    faces: Faces,
    reach_mm: float = _REACH_MM,
    usual: Points | None = None,
    apart_mm: float = 0.0,
) -> Faces:
    """Find pairs of triangles that cross and share no corner.

    Args:
        vertices: ``(V, 3)``, mm.
        faces: ``(F, 3)``.
        reach_mm: Only triangles whose centres are nearer than this are compared.
        usual: ``(F, 3)`` centres of the triangles on the template, mm, or None.
        apart_mm: Only triangles that are as far apart there are compared.

    Returns:
        ``(n, 2)`` indices of faces, the smaller first.
    """
    corners = vertices[faces]
    low, high = corners.min(axis=1), corners.max(axis=1)
    tree = cKDTree(corners.mean(axis=1), balanced_tree=False, compact_nodes=False)
    pairs = tree.query_pairs(reach_mm, output_type="ndarray")
    if usual is not None:
        away = usual[pairs[:, 0]] - usual[pairs[:, 1]]
        pairs = pairs[np.einsum("nc,nc->n", away, away) >= apart_mm**2]
    one, other = pairs[:, 0], pairs[:, 1]
    touching = np.ones(len(pairs), bool)
    for axis in range(3):
        touching &= low[one, axis] <= high[other, axis]
        touching &= low[other, axis] <= high[one, axis]
    pairs = pairs[touching]
    shared = (faces[pairs[:, 0], :, None] == faces[pairs[:, 1], None, :]).any(axis=(1, 2))
    pairs = pairs[~shared]
    p, q = corners[pairs[:, 0]], corners[pairs[:, 1]]
    return np.asarray(pairs[edges_cross(p, q) | edges_cross(q, p)], dtype=np.int64)


@lru_cache(maxsize=1)
def nose_faces() -> tuple[Faces, Points]:
    """Return the coarse triangles around the nostrils and their centres on the template, mm."""
    centre = template().skin[coarse_faces()].mean(axis=1)
    x, y, z = np.abs(centre[:, 0]), centre[:, 1], centre[:, 2]
    inside = (x < 17.0) & (y > -51.0) & (y < -40.0) & (z > 6.0)
    return coarse_faces()[inside], centre[inside]


def count_nose_crossings(skin: Points) -> int:
    """Count pairs of coarse triangles that cross where nostrils collapse; the template has none.

    Pairs that lie less than 4 mm apart on the template are creases, and do not count.

    Args:
        skin: ``(V, 3)`` render vertices, mm.
    """
    faces, usual = nose_faces()
    return len(crossing_pairs(skin, faces, usual=usual, apart_mm=_APART_MM))


class _Lips(NamedTuple):
    upper: NDArray[np.int64]
    lower: NDArray[np.int64]


@lru_cache(maxsize=1)
def _lips() -> _Lips:
    """Vertices of the lips' surfaces that face each other on the template, up to their borders."""
    skin = template().skin
    faces = coarse_faces()
    corners = skin[faces]
    up = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 1]
    centre = corners.mean(axis=1)
    near = (np.abs(centre[:, 0]) < _LIPS_X_MM) & (centre[:, 2] > -2.0)
    upper = near & (up < 0) & (centre[:, 1] > -74.0) & (centre[:, 1] < -65.0)
    lower = near & (up > 0) & (centre[:, 1] < -73.0) & (centre[:, 1] > -81.0)
    return _Lips(np.unique(faces[upper]), np.unique(faces[lower]))


def lip_overlap_mm(skin: Points) -> float:
    """Return how deep the lips press into each other where they do so most.

    Real lips at rest flatten against each other; meshes pass through each other instead, which
    shows only when it is deep. Both faces of the mouth's slit are looked at from above, in cells of
    1.5 mm: by how much the lower lip's highest point there lies above the upper lip's lowest.

    Args:
        skin: ``(V, 3)`` render vertices, mm.
    """
    lips = _lips()
    points = np.concatenate([skin[lips.upper], skin[lips.lower]])
    cell = np.floor((points[:, [0, 2]] - points[:, [0, 2]].min(axis=0)) / _CELL_MM).astype(np.int64)
    key = cell[:, 0] * (cell[:, 1].max() + 1) + cell[:, 1]
    n = len(lips.upper)
    ceiling, floor = np.full(key.max() + 1, np.inf), np.full(key.max() + 1, -np.inf)
    np.minimum.at(ceiling, key[:n], points[:n, 1])
    np.maximum.at(floor, key[n:], points[n:, 1])
    both = np.isfinite(ceiling) & np.isfinite(floor)
    depth = np.sort((floor - ceiling)[both])
    return float(max(0.0, depth[-3:].mean())) if depth.size else 0.0
