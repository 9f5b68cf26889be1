"""How is a mesh raised where a beard grows and lowered where a line runs? Along its normals."""

from typing import Any

import numpy as np
from numpy.typing import NDArray


def displace(
    vertices: NDArray[np.float64],
    faces: NDArray[np.integer[Any]],
    height: NDArray[np.floating[Any]],
) -> NDArray[np.float64]:
    """Move vertices along their area-weighted normals.

    Args:
        vertices: ``(V, 3)``, mm.
        faces: ``(F, 3)``, counter-clockwise seen from outside.
        height: ``(V,)``, mm, positive outwards.

    Returns:
        ``(V, 3)``, mm; vertices of height 0 keep their exact place.

    Example:
        >>> corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
        >>> displace(corners, np.array([[0, 1, 2]]), np.array([0.5, 0.0, 0.0]))[0]
        array([0. , 0. , 0.5])
    """
    touched = faces[(height[faces] != 0).any(axis=1)]
    a, b, c = (vertices[touched[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    corner = touched.T.ravel()
    normals = np.stack(
        [np.bincount(corner, np.tile(across[:, k], 3), len(vertices)) for k in range(3)], axis=1
    )
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.asarray(vertices + height[:, None] * normals / np.maximum(length, 1e-12))
