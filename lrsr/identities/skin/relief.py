"""How is a mesh raised where a beard grows and lowered where a line runs? Along its normals.

What is too fine for the mesh stays in a map of heights, which turns the normals only.
"""

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from lrsr.identities.planes import cross, dot

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
    moving = np.flatnonzero(height)
    corner = np.take(height != 0, faces).T
    touched = np.take(faces, np.flatnonzero(corner[0] | corner[1] | corner[2]), axis=0).T
    axes = np.ascontiguousarray(vertices.T)
    a, b, c = (np.take(axes, corners, axis=1) for corners in touched)
    corners = touched.ravel()
    sums = (
        np.bincount(corners, np.concatenate([part] * 3), len(vertices))
        for part in cross(b - a, c - a)
    )
    normals: NDArray[np.float64] = np.stack([np.take(total, moving) for total in sums])
    axes[:, moving] += height[moving] * normals / np.maximum(np.sqrt(dot(normals, normals)), 1e-12)
    return np.ascontiguousarray(axes.T)
