"""How is a thing put together of tubes and sheets? Meshes of one topology, joined into one part."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Points = NDArray[np.float64]


class Mesh(NamedTuple):
    """Triangles in space.

    Attributes:
        vertices: ``(V, 3)``, mm.
        faces: ``(F, 3)``.
        uv: ``(V, 2)`` in [0, 1].
    """

    vertices: Points
    faces: NDArray[np.int64]
    uv: Points


def sheet(points: Points, *, closed: bool = False) -> Mesh:
    """Span a grid of points.

    Args:
        points: ``(R, C, 3)``, mm; counter-clockwise outside if columns go to the right and rows
            down.
        closed: The last column meets the first; they are one place with two texture coordinates.
    """
    if closed:
        points = np.concatenate([points, points[:, :1]], axis=1)
    rows, columns = points.shape[:2]
    v, u = np.meshgrid(np.linspace(0, 1, rows), np.linspace(0, 1, columns), indexing="ij")
    corner = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    a, b, c, d = corner, corner + columns, corner + columns + 1, corner + 1
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return Mesh(points.reshape(-1, 3), faces, np.stack([u, v], axis=-1).reshape(-1, 2))


def tube(
    path: Points,
    across: ArrayLike,
    half_mm: tuple[float, float],
    *,
    closed: bool = False,
    sides: int = 10,
    squareness: float = 2.0,
) -> Mesh:
    """Lay a rod along a path.

    Args:
        path: ``(N, 3)``, mm.
        across: ``(3,)`` or ``(N, 3)``: about the direction of the second half axis of its section.
        half_mm: Half axes of the section, the second one along ``across``.
        closed: The path is a ring.
        sides: Corners of the section.
        squareness: 2 for an ellipse, more for a box with round edges.
    """
    path = np.asarray(path, dtype=np.float64)
    if closed:
        along = np.roll(path, -1, axis=0) - np.roll(path, 1, axis=0)
    else:
        along = np.gradient(path, axis=0)
    along = _unit(along)
    up = np.broadcast_to(np.asarray(across, dtype=np.float64), path.shape)
    up = _unit(up - (up * along).sum(axis=1, keepdims=True) * along)
    right = np.cross(up, along)
    angle = np.linspace(0.0, 2 * np.pi, sides, endpoint=False)
    x, y = (np.sign(wave) * np.abs(wave) ** (2 / squareness) for wave in _waves(angle))
    ring = half_mm[0] * x[:, None, None] * right + half_mm[1] * y[:, None, None] * up
    rings = path + ring
    if closed:
        rings = np.concatenate([rings, rings[:, :1]], axis=1)
    body = sheet(np.concatenate([rings, rings[:1]]))
    if closed:
        return body
    return join([body, _lid(path[0], rings[::-1, 0]), _lid(path[-1], rings[:, -1])])


def _waves(angle: Points) -> tuple[Points, Points]:
    return np.cos(angle), np.sin(angle)


def _lid(middle: Points, rim: Points) -> Mesh:
    count = len(rim)
    around = np.arange(count)
    faces = np.stack([np.full(count, count), around, (around + 1) % count], axis=1)
    return Mesh(np.vstack([rim, middle]), faces, np.full((count + 1, 2), 0.5))


def join(meshes: list[Mesh]) -> Mesh:
    """Make one mesh of several, in their order."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    return Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([mesh.faces + at for mesh, at in zip(meshes, starts, strict=False)]),
        np.concatenate([mesh.uv for mesh in meshes]),
    )


def _unit(vectors: Points) -> Points:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.maximum(length, 1e-12))
