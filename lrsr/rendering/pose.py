"""How is the head held? Angles by name or number, and where they take the points of a head."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lrsr.configuration import require, settle

PIVOT_MM = np.array([0.0, -60.0, -90.0])
"""About which point a head turns: the joint of skull and neck, head frame, mm (estimated)."""

_ANGLE = "-180 to 180 degrees"

FOLLOW = 0.5
"""What share of the pupils' way in a turn the frame follows, so that crown and chin stay inside."""


@dataclass(frozen=True)
class Pose:
    """How the head is turned, as an aircraft: first roll, then pitch, then yaw.

    Attributes:
        name: For manifests.
        yaw_deg: > 0 turns the face to the subject's left, the image's right.
        pitch_deg: > 0 lifts the chin.
        roll_deg: > 0 tips the crown to the subject's left, the image's right.
    """

    name: str
    yaw_deg: float = 0.0
    pitch_deg: float = 0.0
    roll_deg: float = 0.0

    def __post_init__(self) -> None:
        """Refuse what is no angle.

        Raises:
            InputError: An angle is no number from -180 to 180.
        """
        settle(self, "pose")
        for name in ("yaw_deg", "pitch_deg", "roll_deg"):
            require(abs(getattr(self, name)) <= 180, f"pose.{name}", getattr(self, name), _ANGLE)

    def rotation(self) -> NDArray[np.float64]:
        """Return the ``(3, 3)`` matrix that turns head-frame directions into the world frame.

        Example:
            >>> Pose("left", yaw_deg=90).rotation().round() @ [0, 0, 1]  # the nose goes to +x
            array([1., 0., 0.])
        """
        yaw, pitch, roll = np.radians([self.yaw_deg, self.pitch_deg, self.roll_deg])
        about_y = [[np.cos(yaw), 0, np.sin(yaw)], [0, 1, 0], [-np.sin(yaw), 0, np.cos(yaw)]]
        about_x = [[1, 0, 0], [0, np.cos(pitch), np.sin(pitch)], [0, -np.sin(pitch), np.cos(pitch)]]
        about_z = [[np.cos(roll), np.sin(roll), 0], [-np.sin(roll), np.cos(roll), 0], [0, 0, 1]]
        return np.asarray(np.array(about_y) @ np.array(about_x) @ np.array(about_z))

    def turn(self, points_mm: NDArray[np.float64]) -> NDArray[np.float64]:
        """Move head-frame points ``(N, 3)`` to where this pose puts them in the world, mm."""
        points = np.asarray(points_mm, dtype=np.float64)
        return np.asarray((points - PIVOT_MM) @ self.rotation().T + PIVOT_MM)

    def frame_offset_mm(self) -> tuple[float, float]:
        """Return how far the frame moves (right, up) after the turned face, mm."""
        x, y, _ = FOLLOW * self.turn(np.zeros((1, 3)))[0]
        return float(x), float(y)


FRONTAL = Pose("frontal")
"""Eyes on the camera."""
