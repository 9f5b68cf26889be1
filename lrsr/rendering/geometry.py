"""How large is a face on the sensor of the reference camera, and where does each point fall?

Pure arithmetic, no renderer. World frame: the head frame of a face that looks straight ahead
(:mod:`lrsr.identities.head`), mm; the camera stands on +z and looks along -z.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lrsr.rendering.pose import FOLLOW, PIVOT_MM, Pose

FRAME_IPDS = 4
"""Side of the square frame in interpupillary distances: the face with some hair and neck."""

_MIN_FILM_PX = 16
"""No film of the first scale is smaller: an SRCNN of 9-1-5 eats 12 pixels."""

_FRAME_DROP_IPDS = 0.2
"""How far the frame's centre lies below the pupils, in IPDs, so that crown and chin both fit."""


@dataclass(frozen=True)
class _ReferenceCamera:
    """The Axis P1435-LE of the paper; any other pinhole by other numbers.

    Attributes:
        width_px: Of the whole sensor.
        height_px: Of the whole sensor.
        focal_mm: Focal length, mm.
        f_number: Focal length over aperture, F/#.
        pitch_um: Pixel pitch, µm (square pixels).
        view_deg: Nominal angles of view of the data sheet (horizontal, vertical).
    """

    width_px: int = 1920
    height_px: int = 1080
    focal_mm: float = 3.0
    f_number: float = 1.4
    pitch_um: float = 2.65
    view_deg: tuple[float, float] = (95.0, 51.0)


AXIS_P1435LE = _ReferenceCamera()
"""The reference camera: 1920 × 1080, 3 mm, F/1.4, 95° × 51°, pixels 2.65 µm high."""


def distance_m(ipd_px: float, ipd_mm: float) -> float:
    """Return how far the reference camera stands for a frontal face: d = f IPD / (px pitch).

    Args:
        ipd_px: Interpupillary distance on the sensor, px, > 0.
        ipd_mm: Interpupillary distance of the person, mm, > 0.

    Returns:
        Camera to pupils, m.

    Raises:
        ValueError: An argument is not positive.

    Example:
        >>> round(distance_m(8, 63.0), 1)
        8.9
    """
    if not (ipd_px > 0 and ipd_mm > 0):
        raise ValueError(f"IPDs must be positive, got {ipd_px} px and {ipd_mm} mm")
    return AXIS_P1435LE.focal_mm * ipd_mm / (ipd_px * AXIS_P1435LE.pitch_um)


def film_size_px(ipd_px: float) -> int:
    """Return the side of the ×1 film: four whole IPDs, at least 16 px, always a multiple of 4.

    Raises:
        ValueError: The IPD is not positive.

    Example:
        >>> film_size_px(8), film_size_px(8.3), film_size_px(1)
        (32, 32, 16)
    """
    if not ipd_px > 0:
        raise ValueError(f"the IPD must be positive, got {ipd_px} px")
    return max(FRAME_IPDS * round(ipd_px), _MIN_FILM_PX)


@dataclass(frozen=True)
class Viewpoint:
    """A pinhole camera with a square film that looks along -z, or from above down on the face.

    Attributes:
        centre_mm: ``(3,)`` the pinhole, world frame, mm.
        film_px: Side of the ×1 film, px.
        pixels_per_slope: Focal length in ×1 pixels: px per unit of x/z.
        elevation_deg: How far the optical axis points below the horizon, -90..90.
        shift_px: (right, down) that all of the picture lies off, ×1 px: the film is elsewhere.
    """

    centre_mm: NDArray[np.float64]
    film_px: int
    pixels_per_slope: float
    elevation_deg: float = 0.0
    shift_px: tuple[float, float] = (0.0, 0.0)

    @property
    def view_deg(self) -> float:
        """Full angle of view across the film, degrees."""
        return 2 * math.degrees(math.atan(self.film_px / 2 / self.pixels_per_slope))

    def axes(self) -> NDArray[np.float64]:
        """Return ``(3, 3)``: the picture's right, its up, and away from the scene, world frame.

        Example:
            >>> Viewpoint(np.zeros(3), 32, 1000.0).axes().tolist()
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
        """
        tilt = math.radians(self.elevation_deg)
        sine, cosine = math.sin(tilt), math.cos(tilt)
        return np.array([[1.0, 0.0, 0.0], [0.0, cosine, -sine], [0.0, sine, cosine]]) + 0.0

    def to_world(self) -> NDArray[np.float64]:
        """Return the ``(4, 4)`` matrix from the camera's frame (the axes, at the pinhole)."""
        matrix = np.eye(4)
        matrix[:3, :3] = self.axes().T
        matrix[:3, 3] = self.centre_mm
        return matrix

    def depth_mm(self, points_mm: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return how far world points ``(N, 3)`` lie before the camera along its axis, mm."""
        return np.asarray(-(np.asarray(points_mm, np.float64) - self.centre_mm) @ self.axes()[2])

    def project(self, points_mm: NDArray[np.float64], scale: int = 1) -> NDArray[np.float64]:
        """Project world points in exact perspective.

        Args:
            points_mm: ``(N, 3)``, world frame, mm, in front of the camera.
            scale: The film has ``scale`` times the pixels of the ×1 film.

        Returns:
            ``(N, 2)`` (x, y), px; 0 is the centre of the top-left pixel.
        """
        offset = (np.asarray(points_mm, dtype=np.float64) - self.centre_mm) @ self.axes().T
        slope = offset[:, :2] / -offset[:, 2:]
        film = self.film_px / 2 + self.pixels_per_slope * slope * (1, -1) + self.shift_px
        return np.asarray(scale * film - 0.5)


def place_camera(
    pupils_mm: NDArray[np.float64],
    ipd_px: float,
    *,
    offset_mm: tuple[float, float] = (0.0, 0.0),
    camera_m: float | None = None,
    above_m: float = 0.0,
    nearer: float = 0.0,
    shift_px: tuple[float, float] = (0.0, 0.0),
) -> Viewpoint:
    """Place the camera so that the frontal pupils are exactly ``ipd_px`` apart on the ×1 film.

    The optical axis passes ``_FRAME_DROP_IPDS`` below the point midway between the pupils. The
    distance follows from the reference camera; or it is given, and the focal length follows.

    Args:
        pupils_mm: ``(2, 3)``, head frame, mm.
        ipd_px: Wanted distance of the pupils on the film, px.
        offset_mm: Shift of camera and frame (to the picture's right, up), mm: to follow a turned
            head.
        camera_m: Distance of the camera from the pupils, m; None: the reference camera's.
        above_m: How much higher than the pupils it stands, m; < 0 is lower. It looks at the face.
        nearer: Share of the way to the camera that the face has come since it was that large, < 1.
        shift_px: See :class:`Viewpoint`.

    Raises:
        ValueError: The IPD or the distance is not positive, or less than the height.
    """
    ipd_mm = float(np.linalg.norm(pupils_mm[1] - pupils_mm[0]))
    film_px = film_size_px(ipd_px)
    if camera_m is not None and not camera_m > 0:
        raise ValueError(f"the distance must be positive, got {camera_m} m")
    away_mm = 1000 * (distance_m(ipd_px, ipd_mm) if camera_m is None else camera_m)
    if not abs(1000 * above_m) < away_mm:
        raise ValueError(
            f"a camera {above_m} m above the eyes cannot be {away_mm / 1000:.3g} m from them"
        )
    focal_px = 1000 * AXIS_P1435LE.focal_mm / AXIS_P1435LE.pitch_um
    height_mm = -_FRAME_DROP_IPDS * ipd_mm
    # Pupils off the plane z = 0, or not level, make the first guess miss by parts in a thousand.
    for _ in range(8):
        lift_mm = _lift_mm(math.asin(1000 * above_m / away_mm))
        frontal = _viewpoint((0.0, height_mm + lift_mm), away_mm, above_m, film_px, focal_px)
        left, right = frontal.project(pupils_mm)
        excess = float(np.hypot(*(right - left))) / ipd_px
        if camera_m is None:
            away_mm *= excess
        else:
            focal_px /= excess
    shift = (offset_mm[0], height_mm + lift_mm + offset_mm[1])
    left = 1 - nearer
    there = _viewpoint(shift, left * away_mm, left * above_m, film_px, focal_px)
    return replace(there, shift_px=shift_px)


def _lift_mm(elevation: float) -> float:
    """Return how far a frame from above moves up, as it does for a head that bows as much."""
    _, up, ahead = -PIVOT_MM
    sinks = up * (math.cos(elevation) - 1) - ahead * math.sin(elevation)
    return float(-(1 - FOLLOW) * sinks) + 0.0


def _viewpoint(
    shift_mm: tuple[float, float], away_mm: float, above_m: float, film_px: int, focal_px: float
) -> Viewpoint:
    """Look at the origin from that far and high, then move within the picture's plane."""
    elevation_deg = math.degrees(math.asin(1000 * above_m / away_mm))
    level = Viewpoint(np.zeros(3), film_px, focal_px, elevation_deg)
    centre = np.array([*shift_mm, away_mm]) @ level.axes()
    return Viewpoint(centre, film_px, focal_px, elevation_deg)


def world_to_head(pose: Pose) -> NDArray[np.float64]:
    """Return the ``(4, 4)`` matrix that takes the posed world back into the frame of the head."""
    rotation = pose.rotation().T
    matrix = np.eye(4)
    matrix[:3, :3] = rotation
    matrix[:3, 3] = PIVOT_MM - rotation @ PIVOT_MM
    return matrix
