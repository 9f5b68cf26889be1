"""Where does a point of a head fall on a photograph? Weak perspective with a nearness.

``p = s (x, y) / (1 - k Z) + t`` with ``(x, y, Z) = R X + o``: Z towards the camera from about the
eyes, k one over the distance of the camera. Unlike a pinhole's focal length and distance, s and k
are nearly independent where faces are small or far.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Perspective:
    """How a photograph sees a head.

    Attributes:
        rotation: ``(3, 3)`` from the axes of the points to the camera's: x right, y up, z to it.
        px_per_mm: Scale at the eyes, s.
        shift_px: ``(2,)`` where the origin falls, x right and **y up**, t.
        nearness: One over the camera's distance, 1/mm, k.
        offset_mm: ``(3,)`` of the origin, in the camera's axes, o.
    """

    rotation: Points
    px_per_mm: float
    shift_px: Points
    nearness: float
    offset_mm: Points

    def turned(self, points_mm: Points) -> Points:
        """Return points ``(..., 3)`` in the camera's axes, mm."""
        return np.asarray(points_mm @ self.rotation.T + self.offset_mm)

    def project(self, points_mm: Points) -> tuple[Points, Points]:
        """Project points.

        Args:
            points_mm: ``(N, 3)``.

        Returns:
            ``(N, 2)`` (x, y), px of the picture, and ``(N,)`` how near each is, mm.
        """
        turned = self.turned(points_mm)
        larger = self.px_per_mm / (1 - self.nearness * turned[:, 2])
        up = turned[:, :2] * larger[:, None] + self.shift_px
        return up * [1, -1], turned[:, 2]

    def towards(self, points_mm: Points) -> Points:
        """Return unit vectors ``(N, 3)`` from points to the camera, in the axes of the points."""
        ray = np.array([0.0, 0.0, 1 / self.nearness]) - self.turned(points_mm)
        return np.asarray(ray / np.linalg.norm(ray, axis=1, keepdims=True) @ self.rotation)

    def ray(self, point_px: Points) -> tuple[Points, Points]:
        """Return where the ray of a pixel ``(2,)`` starts, and its unit direction, away from it."""
        x, y = (point_px * [1, -1] - self.shift_px) / self.px_per_mm
        away = np.array([x, y, -1 / self.nearness])
        start = self.rotation.T @ (np.array([0.0, 0.0, 1 / self.nearness]) - self.offset_mm)
        return start, self.rotation.T @ away / np.linalg.norm(away)

    def moved_axes(self, rotation: Points, origin: Points) -> "Perspective":
        """Return it for points that were moved: ``rotation @ (point - origin)``."""
        return Perspective(
            self.rotation @ rotation.T,
            self.px_per_mm,
            self.shift_px,
            self.nearness,
            self.offset_mm + self.rotation @ origin,
        )

    def scaled(self, factor: float) -> "Perspective":
        """Return it for the picture enlarged by a factor; pixel centres are whole numbers."""
        corner = 0.5 * np.array([1.0, -1.0])
        shift = factor * (self.shift_px + corner) - corner
        return Perspective(
            self.rotation, factor * self.px_per_mm, shift, self.nearness, self.offset_mm
        )

    @property
    def angles_deg(self) -> tuple[float, float, float]:
        """Yaw, pitch and roll as :class:`lrsr.rendering.pose.Pose` has them.

        Example:
            >>> upright = Perspective(np.eye(3), 1.0, np.zeros(2), 1e-3, np.zeros(3))
            >>> upright.angles_deg
            (0.0, 0.0, 0.0)
        """
        turn = self.rotation
        yaw = np.arctan2(turn[0, 2], turn[2, 2])
        pitch = np.arcsin(np.clip(turn[1, 2], -1, 1))
        roll = np.arctan2(-turn[1, 0], turn[1, 1])
        yaw, pitch, roll = (float(np.degrees(angle)) + 0.0 for angle in (yaw, pitch, roll))
        return yaw, pitch, roll
