"""What does a head see of its photograph? Light, depth, and the place of each texel on it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
import torch
from numpy.typing import NDArray

from lrsr.identities.photographs.perspective import Perspective
from lrsr.identities.shape.position_map import Raster, cover, draw_triangles
from lrsr.images import srgb_to_linear

Points = NDArray[np.float64]
Map = NDArray[np.float32]

_IPD_PX = 200.0
"""Photographs that are larger are reduced to this: finer than a texel."""
_DEPTH_PX = 512
"""Most rows of the map of depths."""
_TOLERANCE_MM = 3.0
"""What lies no farther behind the nearest surface is seen."""
_MARGIN_PX = 4


class Mesh(NamedTuple):
    """Triangles: ``(V, 3)`` mm in the head frame, ``(F, 3)``, and ``(V, 2)`` on their texture."""

    vertices: Points
    faces: NDArray[np.int32]
    uv: NDArray[np.float32]

    def normals(self) -> Points:
        """Return the normal of each vertex ``(V, 3)``, averaged over its triangles by area."""
        first, second, third = (self.vertices[self.faces[:, k]] for k in range(3))
        across = np.cross(second - first, third - first)
        corner = self.faces.T.ravel()
        summed = [
            np.bincount(corner, np.tile(across[:, k], 3), len(self.vertices)) for k in range(3)
        ]
        normals = np.stack(summed, axis=1)
        return np.asarray(normals / np.maximum(np.linalg.norm(normals, axis=1)[:, None], 1e-9))


class Texels(NamedTuple):
    """What the texels of a mesh see of a photograph.

    Attributes:
        px: ``(S, S, 2)`` float32 (x, y) on it.
        facing: ``(S, S)`` float32, cosine of normal and direction to the camera.
        normals: ``(S, S, 3)`` float32, head frame.
        visible: ``(S, S)`` bool, nothing lies before them.
    """

    px: Map
    facing: Map
    normals: Map
    visible: NDArray[np.bool_]

    def sample(self, image: Map) -> Map:
        """Return an image of the photograph's size as the texels see it."""
        x, y = np.ascontiguousarray(self.px[..., 0]), np.ascontiguousarray(self.px[..., 1])
        return np.asarray(cv2.remap(image, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE))


@dataclass(frozen=True, eq=False)
class Shot:
    """A photograph and how it sees a head.

    Attributes:
        linear: ``(H, W, 3)`` float32, linear light, at most 200 px between the pupils.
        perspective: Of the head frame, on that size.
        points_px: ``(N, 2)`` the network's points, on that size.
        ipd_px: Between the pupils.
    """

    linear: Map
    perspective: Perspective
    points_px: Points
    ipd_px: float

    def depths(self, meshes: Sequence[Mesh]) -> "Depths":
        """Return how near the nearest of some surfaces is at every place."""
        seen = [self.perspective.project(mesh.vertices) for mesh in meshes]
        firsts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
        faces = np.concatenate(
            [mesh.faces + first for mesh, first in zip(meshes, firsts, strict=True)]
        )
        px = np.concatenate([places for places, _ in seen])
        near = np.concatenate([depth for _, depth in seen])
        origin = px.min(axis=0) - _MARGIN_PX
        side = float((px.max(axis=0) - origin).max()) + 2 * _MARGIN_PX
        scale = min(1.0, _DEPTH_PX / side)
        size = int(np.ceil(side * scale))
        order = np.argsort(near[faces].mean(axis=1))  # of two triangles the later one is drawn
        places = ((px - origin) * scale + 0.5) / size
        drawn, covered = draw_triangles(places, faces[order], near[:, None], size)
        return Depths(np.where(covered, drawn[..., 0], -1e3).astype(np.float32), origin, scale)

    def texels(
        self, mesh: Mesh, size: int, depths: "Depths", raster: Raster | None = None
    ) -> Texels:
        """Return what the texels of a mesh see.

        Args:
            mesh: The mesh.
            size: Rows and columns of its texture.
            depths: Of all that may lie before it.
            raster: Of the mesh's uv at that size, where it is known.
        """
        px, near = self.perspective.project(mesh.vertices)
        normals = mesh.normals()
        facing = (normals * self.perspective.towards(mesh.vertices)).sum(axis=1)
        told = np.concatenate([px, near[:, None], facing[:, None], normals], axis=1)
        drawn, mask = (raster or cover(mesh.uv, mesh.faces, size)).draw(mesh.faces, told)
        single: Map = drawn.astype(np.float32)
        places = np.ascontiguousarray(single[..., :2])
        visible = mask & (single[..., 2] > depths.at(places) - _TOLERANCE_MM)
        return Texels(places, single[..., 3], single[..., 4:], visible)


class Depths(NamedTuple):
    """How near surfaces are, over a square of the photograph.

    Attributes:
        near: ``(S, S)`` float32, mm towards the camera, -1000 where nothing is.
        origin: ``(2,)`` px of the photograph where the square begins.
        scale: Its pixels per px.
    """

    near: Map
    origin: Points
    scale: float

    def at(self, px: Map) -> Map:
        """Return it at places ``(..., 2)`` of the photograph."""
        x, y = np.moveaxis((px - self.origin.astype(np.float32)) * np.float32(self.scale), -1, 0)
        return np.asarray(
            cv2.remap(self.near, np.ascontiguousarray(x), np.ascontiguousarray(y), cv2.INTER_LINEAR)
        )

    def covered(self, shape: tuple[int, int]) -> NDArray[np.bool_]:
        """Return where on the photograph ``(H, W)`` anything is."""
        back = 1 / self.scale
        matrix = np.array([[back, 0.0, self.origin[0]], [0.0, back, self.origin[1]]])
        there = (self.near > -999).astype(np.uint8)
        drawn = cv2.warpAffine(there, matrix, shape[::-1], flags=cv2.INTER_NEAREST)
        return np.asarray(drawn > 0)


def take_shot(srgb: Map, perspective: Perspective, points_px: Points, pupils: Points) -> Shot:
    """Prepare a photograph.

    Args:
        srgb: ``(H, W, 3)`` float32, srgb, [0, 1].
        perspective: Of the head frame, on the photograph.
        points_px: ``(N, 2)`` the network's points on it.
        pupils: ``(2, 3)`` in the head frame, mm.
    """
    places, _ = perspective.project(pupils)
    ipd_px = float(np.linalg.norm(places[1] - places[0]))
    factor = min(1.0, _IPD_PX / ipd_px)
    if factor < 1:
        height, width = (max(1, round(extent * factor)) for extent in srgb.shape[:2])
        factor = width / srgb.shape[1]
        srgb = np.asarray(cv2.resize(srgb, (width, height), interpolation=cv2.INTER_AREA))
    linear = srgb_to_linear(torch.from_numpy(np.ascontiguousarray(srgb))).numpy()
    points = (points_px + 0.5) * factor - 0.5
    return Shot(linear, perspective.scaled(factor), points, ipd_px * factor)
