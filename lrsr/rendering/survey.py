"""What lies behind each pixel? How far away it is, how it is turned, and which part of the head.

One ray through the centre of each pixel, of the same film, camera and pose as the picture.
Mitsuba's ``aov`` integrator would average over a pixel: half of a face and half of nothing is no
distance.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lrsr.rendering.backend import dr, mi
from lrsr.rendering.geometry import Viewpoint, world_to_head
from lrsr.rendering.pose import Pose


@dataclass(frozen=True)
class Survey:
    """What a pinhole sees. Camera frame: x to the picture's right, y up, z towards the camera.

    Attributes:
        depth_m: ``(H, W)`` float32, along the optical axis from the pinhole, m; 0 where there is
            nothing.
        normals: ``(H, W, 3)`` float32, unit vectors, camera frame, smooth over each mesh, on its
            side that is seen; 0 where there is nothing. Relief finer than the mesh is not in them.
        parts: ``(H, W)`` uint8: 0 where there is nothing, else 1 + the place in ``names``.
        names: Of the parts, in the order of the head.
        to_camera: ``(4, 4)``: from the head frame, mm, to the camera frame, mm.
        focal_px: Focal length in pixels of this film.
        axis_px: Where the optical axis meets the film, (x, y), px.
    """

    depth_m: NDArray[np.float32]
    normals: NDArray[np.float32]
    parts: NDArray[np.uint8]
    names: tuple[str, ...]
    to_camera: NDArray[np.float64]
    focal_px: float
    axis_px: tuple[float, float]

    def mask(self, name: str) -> NDArray[np.bool_]:
        """Return where a part is seen, ``(H, W)``.

        Raises:
            ValueError: There is no such part.
        """
        if name not in self.names:
            raise ValueError(f"no part {name!r}: there are {', '.join(self.names)}")
        return np.asarray(self.parts == 1 + self.names.index(name))

    def flow(self, later: "Survey") -> NDArray[np.float64]:
        """Say where another picture of the same head shows what lies behind each pixel here.

        Exact for turns, shifts and steps of the head. What a face does besides is not in it, and
        neither is whether something stands before that point there.

        Args:
            later: Of the other picture.

        Returns:
            ``(H, W, 2)``: (right, down) from here to there, px; NaN where there is nothing.
        """
        here = np.stack(np.meshgrid(*(np.arange(side) for side in self.parts.shape[::-1])), -1)
        slopes = (here - self.axis_px) / self.focal_px * (1, -1)
        depth = np.where(self.parts > 0, 1000 * self.depth_m.astype(np.float64), np.nan)[..., None]
        points = depth * np.concatenate([slopes, np.full_like(slopes[..., :1], -1.0)], axis=-1)
        move = later.to_camera @ np.linalg.inv(self.to_camera)
        moved = points @ move[:3, :3].T + move[:3, 3]
        there = later.focal_px * moved[..., :2] / -moved[..., 2:] * (1, -1) + later.axis_px
        return np.asarray(there - here)


def survey(
    scene: Any, names: Sequence[str], viewpoint: Viewpoint, pose: Pose, scale: int
) -> Survey:
    """Look through the centre of each pixel.

    Args:
        scene: ``mi.Scene`` of a head in its own frame.
        names: Of its parts.
        viewpoint: Where the pinhole is, and how large the ×1 film.
        pose: How the head is turned.
        scale: How many times finer than the ×1 film.
    """
    side, focal = scale * viewpoint.film_px, scale * viewpoint.pixels_per_slope
    to_head = world_to_head(pose) @ viewpoint.to_world()
    right, down = ((side - 1) / 2 + scale * shift for shift in viewpoint.shift_px)
    x, y = np.meshgrid((np.arange(side) - right) / focal, (down - np.arange(side)) / focal)
    rays = np.stack([x, y, np.full_like(x, -1.0)], axis=-1).reshape(-1, 3)
    lengths = np.linalg.norm(rays, axis=1)
    directions = rays / lengths[:, None] @ to_head[:3, :3].T
    distance, normals, parts = _intersect(scene, names, to_head[:3, 3], directions)
    seen = parts > 0
    normals = normals @ to_head[:3, :3] * seen[:, None]  # its transpose turns back
    depth_m = np.where(seen, distance / lengths, 0.0) / 1000
    return Survey(
        depth_m.reshape(side, side).astype(np.float32),
        normals.reshape(side, side, 3).astype(np.float32),
        parts.reshape(side, side),
        tuple(names),
        np.asarray(np.linalg.inv(to_head), dtype=np.float64),
        float(focal),
        (right, down),
    )


_Hits = tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.uint8]]


def _intersect(
    scene: Any, names: Sequence[str], origin: NDArray[np.float64], directions: NDArray[np.float64]
) -> _Hits:
    """Return how far each ray gets, mm, the normals met, head frame, and 1 + the part's place.

    Where it meets nothing, or a lamp, that is 0.
    """
    if "scalar" in mi.variant():
        return _one_by_one(scene, names, origin, directions)
    shapes = {shape.id(): shape for shape in scene.shapes()}
    ray = mi.Ray3f(mi.Point3f(*origin.tolist()), mi.Vector3f(*(mi.Float(d) for d in directions.T)))
    si = scene.ray_intersect(ray)
    parts = np.zeros(len(directions), np.uint8)
    for place, name in enumerate(names):
        parts[np.array(si.shape == mi.ShapePtr(shapes[name]))] = 1 + place
    distance = np.array(dr.select(si.is_valid(), si.t, 0.0)).astype(np.float64)
    smooth = si.sh_frame.n * dr.select(dr.dot(si.n, ray.d) > 0, -1.0, 1.0)
    return distance, np.array(dr.select(si.is_valid(), smooth, 0.0)).T, parts


def _one_by_one(
    scene: Any, names: Sequence[str], origin: NDArray[np.float64], directions: NDArray[np.float64]
) -> _Hits:
    distance, normals = np.zeros(len(directions)), np.zeros((len(directions), 3))
    parts = np.zeros(len(directions), np.uint8)
    for row, direction in enumerate(directions):
        si = scene.ray_intersect(mi.Ray3f(origin.tolist(), direction.tolist()))
        if si.is_valid() and si.shape.id() in names:
            parts[row] = 1 + names.index(si.shape.id())
            turned = -1.0 if np.dot(si.n, direction) > 0 else 1.0
            distance[row], normals[row] = si.t, turned * np.array(si.sh_frame.n)
    return distance, normals, parts
