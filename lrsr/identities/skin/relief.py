"""How is a mesh raised where a beard grows and lowered where a line runs? Along its normals.

What is too fine for the mesh stays in a map of heights, which turns the normals only.
"""

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

_MESH_DETAIL_MM = 1.6
"""Standard deviation of the blur that leaves what the vertices, about 2 mm apart, can carry."""


def split_heights(
    heights: NDArray[np.float32], pixel_mm: float
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Share a relief between mesh and map.

    Args:
        heights: ``(H, W)``, mm.
        pixel_mm: Size of a pixel, mm, > 0.

    Returns:
        coarse: ``(H, W)``, for the vertices, mm.
        fine: ``(H, W)``, for the map; the two add up to ``heights``.
    """
    coarse = np.asarray(cv2.GaussianBlur(heights, (0, 0), _MESH_DETAIL_MM / pixel_mm))
    return coarse, heights - coarse


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
    moving = height != 0
    touched = faces[moving[faces].any(axis=1)]
    a, b, c = (vertices.T[:, touched[:, k]] for k in range(3))
    across = np.cross(b - a, c - a, axis=0)
    corner = touched.T.ravel()
    normals = np.stack(
        [np.bincount(corner, np.tile(along, 3), len(vertices))[moving] for along in across], axis=1
    )
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    moved = vertices.copy()
    moved[moving] += height[moving, None] * normals / np.maximum(length, 1e-12)
    return moved
