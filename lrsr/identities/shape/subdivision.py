"""How does a coarse mesh of quads become a smooth one? By a sparse matrix, once for all heads.

Catmull and Clark, "Recursively generated B-spline surfaces on arbitrary topological meshes",
Computer-Aided Design 10 (1978). The rules are linear in the positions, so for a fixed topology two
rounds are one matrix: a new head costs one sparse product, whatever its shape.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

Quads = NDArray[np.int64]
"""``(F, 4)`` corners, counter-clockwise seen from outside."""


class _Subdivision(NamedTuple):
    """One round, or several rounds, of subdivision of a fixed topology.

    Attributes:
        matrix: ``(V_new, V_old)`` float64; each row sums to 1. The old vertices come first.
        quads: ``(F_new, 4)``: four for each old one, in its order; the k-th starts at corner k.
    """

    matrix: sparse.csr_matrix
    quads: Quads


def sides(quads: Quads) -> Quads:
    """List the four sides of each quad, corner and next corner: ``(F, 4)`` to ``(4 F, 2)``."""
    return np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2)


def _edges(quads: Quads) -> tuple[Quads, Quads, Quads]:
    """Return unique edges ``(E, 2)``, the edge of each side ``(F, 4)``, faces per edge ``(E,)``."""
    ordered = np.sort(sides(quads), axis=1)
    keys = ordered[:, 0] * (ordered.max() + 1) + ordered[:, 1]  # as their order, and faster sorted
    _, first, inverse, counts = np.unique(
        keys, return_index=True, return_inverse=True, return_counts=True
    )
    return ordered[first], inverse.reshape(quads.shape), counts


def _incidence(corners: Quads, n_vertices: int) -> sparse.csr_matrix:
    """Return ``(n, n_vertices)`` with a 1 at each of the ``(n, k)`` corners, repeats added up."""
    rows = np.repeat(np.arange(len(corners)), corners.shape[1])
    ones = np.ones(corners.size)
    return sparse.csr_matrix((ones, (rows, corners.ravel())), shape=(len(corners), n_vertices))


def _new_quads(quads: Quads, side_edges: Quads, n_vertices: int, n_edges: int) -> Quads:
    """Split every quad in four: corner, the edge after it, the centre, the edge before it."""
    after = n_vertices + side_edges
    before = np.roll(after, 1, axis=1)
    centre = n_vertices + n_edges + np.arange(len(quads))
    centres = np.broadcast_to(centre[:, None], quads.shape)
    return np.stack([quads, after, centres, before], axis=-1).reshape(-1, 4)


def _split_linearly(quads: Quads, n_vertices: int) -> _Subdivision:
    """Split every quad in four without moving anything: the rule for texture coordinates.

    Args:
        quads: ``(F, 4)``.
        n_vertices: How many vertices there are, > every index in ``quads``.

    Returns:
        Old vertices, then edge midpoints, then face centres.
    """
    edges, side_edges, _ = _edges(quads)
    middle, centre = _incidence(edges, n_vertices), _incidence(quads, n_vertices)
    matrix = sparse.vstack([sparse.identity(n_vertices), middle / 2, centre / 4], format="csr")
    return _Subdivision(matrix, _new_quads(quads, side_edges, n_vertices, len(edges)))


def _split_smoothly(quads: Quads, n_vertices: int) -> _Subdivision:
    """Build one round of Catmull-Clark.

    An open border follows the cubic B-spline of its own vertices (DeRose et al. 1998, eq. 1-2); a
    vertex where more than two border edges meet stays where it is.

    Args:
        quads: ``(F, 4)``, at most two per edge.
        n_vertices: How many vertices there are, > every index in ``quads``.

    Returns:
        Moved old vertices, then edge points, then face points.
    """
    linear = _split_linearly(quads, n_vertices)
    edges, side_edges, counts = _edges(quads)
    middle, centre = linear.matrix[n_vertices : -len(quads)], linear.matrix[-len(quads) :]
    border = counts == 1

    faces_of_edge = _incidence(side_edges, len(edges)).T.tocsr()
    inner = sparse.diags(np.where(border, 0.0, 0.5))
    edge_points = sparse.diags(np.where(border, 1.0, 0.5)) @ middle + inner @ (
        sparse.diags(1.0 / counts) @ faces_of_edge @ centre
    )

    faces_of_vertex = _incidence(quads, n_vertices).T.tocsr()
    edges_of_vertex = _incidence(edges, n_vertices).T.tocsr()
    valence = np.maximum(np.asarray(edges_of_vertex.sum(axis=1)).ravel(), 1.0)
    n_faces = np.maximum(np.asarray(faces_of_vertex.sum(axis=1)).ravel(), 1.0)
    smooth = (
        sparse.diags(1.0 / (n_faces * valence)) @ faces_of_vertex @ centre
        + sparse.diags(2.0 / valence**2) @ edges_of_vertex @ middle
        + sparse.diags((valence - 3.0) / valence)
    )
    border_edges = edges_of_vertex @ sparse.diags(border.astype(np.float64))
    n_border = np.asarray(border_edges.sum(axis=1)).ravel()
    rim = sparse.diags(np.full(n_vertices, 0.5)) + border_edges @ middle / 4.0
    is_inner, is_rim = n_border == 0, n_border == 2
    used = np.asarray(faces_of_vertex.sum(axis=1)).ravel() > 0
    vertex_points = (
        sparse.diags((is_inner & used).astype(np.float64)) @ smooth
        + sparse.diags(is_rim.astype(np.float64)) @ rim
        + sparse.diags((~(is_rim | (is_inner & used))).astype(np.float64))
    )
    matrix = sparse.vstack([vertex_points, edge_points, centre], format="csr")
    return _Subdivision(matrix, linear.quads)


def subdivide(quads: Quads, n_vertices: int, rounds: int, *, smooth: bool) -> _Subdivision:
    """Chain ``rounds`` rounds into one matrix.

    Args:
        quads: ``(F, 4)``.
        n_vertices: How many vertices there are.
        rounds: >= 0; each makes four quads of one.
        smooth: Catmull-Clark; else straight halving (texture coordinates).

    Returns:
        The product matrix ``(V_new, n_vertices)`` and the final quads ``(F 4^rounds, 4)``.
    """
    split = _split_smoothly if smooth else _split_linearly
    total = _Subdivision(sparse.identity(n_vertices, format="csr"), quads)
    for _ in range(rounds):
        step = split(total.quads, total.matrix.shape[0])
        total = _Subdivision(sparse.csr_matrix(step.matrix @ total.matrix), step.quads)
    return total


def triangulate(quads: Quads) -> NDArray[np.int64]:
    """Cut every quad along its first diagonal: ``(F, 4)`` to ``(2 F, 3)``, same winding.

    Example:
        >>> triangulate(np.array([[0, 1, 2, 3]])).tolist()
        [[0, 1, 2], [0, 2, 3]]
    """
    return np.stack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]], axis=1).reshape(-1, 3)
