"""How is the head held and lit? Poses and lightings as data, and the arithmetic they need.

All lights are infinitely far away: discs and a uniform fill on one environment map. So a pose can
turn camera and lights around a head at rest, whose acceleration structure then serves every pose.
Angles are in degrees in the frame of the camera: azimuth 0, elevation 0 is where the camera stands.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lrsr.errors import InputError

PIVOT_MM = np.array([0.0, -60.0, -90.0])
"""About which point a head turns: the joint of skull and neck, head frame, mm (estimated)."""

FOLLOW = 0.5
"""What share of the pupils' way in a turn the frame follows, so that crown and chin stay inside."""

MAP_HEIGHT_PX = 64
"""Rows of the environment map, one per 2.9°; twice as many columns."""

GREY = 0.18
"""Reflectance of the meter's sphere."""


def _is_colour(rgb: tuple[float, ...]) -> bool:
    return len(rgb) == 3 and min(rgb) >= 0 and 0 < max(rgb) < math.inf


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
        """Refuse angles that are no numbers.

        Raises:
            InputError: An angle is NaN or infinite.
        """
        angles = (self.yaw_deg, self.pitch_deg, self.roll_deg)
        if not all(math.isfinite(angle) for angle in angles):
            raise InputError(f"pose {self.name!r}: angles {angles}; give finite numbers")

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


@dataclass(frozen=True)
class Light:
    """A far disc of uniform radiance.

    Attributes:
        azimuth_deg: From the camera towards the image's right, about the vertical.
        elevation_deg: Above the camera's level, -90..90.
        diameter_deg: Apparent diameter, > 0: 27° is a 1.2 m softbox at 2.5 m.
        irradiance: On a surface that faces it; 1 lights a white Lambertian to radiance 1/π.
        rgb: Colour; scaled so that its luminance is 1.
    """

    azimuth_deg: float
    elevation_deg: float
    diameter_deg: float = 27.0
    irradiance: float = math.pi
    rgb: tuple[float, float, float] = (1.0, 1.0, 1.0)

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            InputError: A light without power, of no colour, or larger than half the sky.
        """
        object.__setattr__(self, "rgb", tuple(self.rgb))  # Hydra hands over lists
        if not (self.irradiance > 0 and 0 < self.diameter_deg <= 180 and _is_colour(self.rgb)):
            raise InputError(
                f"light: irradiance {self.irradiance}, diameter {self.diameter_deg}°,"
                f" rgb {self.rgb}; give irradiance > 0, a diameter of 0..180 and three numbers >= 0"
            )

    def direction(self) -> NDArray[np.float64]:
        """Return the unit vector ``(3,)`` from the face to the light, world frame."""
        azimuth, elevation = math.radians(self.azimuth_deg), math.radians(self.elevation_deg)
        return np.array(
            [
                math.cos(elevation) * math.sin(azimuth),
                math.sin(elevation),
                math.cos(elevation) * math.cos(azimuth),
            ]
        )


@dataclass(frozen=True)
class Lighting:
    """All light that reaches the face, and with it the grey behind the head.

    Attributes:
        name: For manifests.
        lights: Key lights, or mappings of their fields; may be empty if ``fill_share`` is 1.
        fill_share: Share of the metered light that comes equally from everywhere, 0..1. It is the
            backdrop too, which after exposure therefore always has this luminance.
        fill_rgb: Its colour; scaled so that its luminance is 1.
    """

    name: str
    lights: tuple[Light, ...] = field(default_factory=tuple)
    fill_share: float = 0.25
    fill_rgb: tuple[float, float, float] = (1.0, 1.0, 1.0)

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            InputError: A share outside 0..1, no light at all, or a fill of no colour.
        """
        given: Iterable[Any] = self.lights  # Hydra hands over lists of mappings
        lights = tuple(light if isinstance(light, Light) else Light(**light) for light in given)
        object.__setattr__(self, "lights", lights)
        object.__setattr__(self, "fill_rgb", tuple(self.fill_rgb))
        if not 0 <= self.fill_share <= 1 or (self.fill_share == 1) == bool(self.lights):
            raise InputError(
                f"lighting {self.name!r}: fill_share={self.fill_share} with {len(self.lights)}"
                " lights; give 0 <= fill_share < 1 with lights, or 1 without"
            )
        if not _is_colour(self.fill_rgb):
            raise InputError(
                f"lighting {self.name!r}: fill_rgb={self.fill_rgb}; give three numbers >= 0"
            )


POSES = {
    pose.name: pose
    for pose in (
        Pose("frontal"),
        Pose("up", pitch_deg=20.0),
        Pose("down", pitch_deg=-20.0),
        Pose("left", yaw_deg=30.0),
    )
}
"""The paper's four poses; it prints no angles, so these are estimated from its Fig. 6."""

LIGHTINGS = {
    lighting.name: lighting
    for lighting in (
        Lighting("frontal", (Light(azimuth_deg=0.0, elevation_deg=10.0),)),
        Lighting("above", (Light(azimuth_deg=0.0, elevation_deg=60.0),)),
        Lighting("below", (Light(azimuth_deg=0.0, elevation_deg=-50.0),)),
        Lighting("side", (Light(azimuth_deg=70.0, elevation_deg=10.0),)),
    )
}
"""The paper's four lightings; it prints no positions, so these are estimated from its Fig. 6."""


def find_pose(name: str | Pose, **changes: Any) -> Pose:
    """Return a pose by its name, or the pose itself; ``changes`` replace angles.

    Raises:
        InputError: There is no pose of that name.

    Example:
        >>> find_pose("left").yaw_deg
        30.0
    """
    if isinstance(name, Pose):
        return replace(name, **changes)
    if name not in POSES:
        raise InputError(f"pose {name!r} does not exist; choose one of {', '.join(POSES)}")
    return replace(POSES[name], **changes)


def find_lighting(name: str | Lighting, **changes: Any) -> Lighting:
    """Return a lighting by its name, or the lighting itself; ``changes`` replace fields.

    Raises:
        InputError: There is no lighting of that name.
    """
    if isinstance(name, Lighting):
        return replace(name, **changes)
    if name not in LIGHTINGS:
        known = ", ".join(LIGHTINGS)
        raise InputError(f"lighting {name!r} does not exist; choose one of {known}")
    return replace(LIGHTINGS[name], **changes)


def lambert_phase(angle_rad: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the mean radiance of a white Lambertian sphere's disc, lit from that phase angle.

    In units of E/π, E the irradiance of a facing surface: (2/3)(sin θ + (π − θ) cos θ)/π, Lambert's
    phase law. Full light gives 2/3, and light from everywhere averages to that of a plane.

    Args:
        angle_rad: Between the directions to the light and to the viewer, 0..π, any shape.

    Example:
        >>> lambert_phase(np.array([0.0, np.pi])).round(4).tolist()
        [0.6667, 0.0]
    """
    angle = np.asarray(angle_rad, dtype=np.float64)
    law = np.sin(angle) + (np.pi - angle) * np.cos(angle)
    return np.asarray(2 / 3 * law / np.pi)


@lru_cache(maxsize=64)
def environment(lighting: Lighting) -> tuple[NDArray[np.float32], float]:
    """Paint a lighting as a latitude-longitude map, and meter it.

    Row 0 is the zenith (+y) and the last row the nadir; column x looks at the longitude
    φ = 2π (x + 0.5) / W, with the direction (sin φ sin θ, cos θ, -cos φ sin θ): the camera (+z) is
    in the middle. This is Mitsuba's ``envmap``.

    Returns:
        map: ``(H, 2H, 3)`` float32, radiance, linear sRGB.
        metered: Luminance of an 18 % grey Lambertian sphere's disc as the camera sees it, divided
            by 0.18 (:attr:`Radiance.metered`); summed over the very map, so exact for any light.
    """
    directions, solid_angles = _map_grid()
    radiance = np.zeros((*solid_angles.shape, 3))
    for light in lighting.lights:
        angle = np.arccos(np.clip(directions @ light.direction(), -1, 1))
        edge = math.pi / (MAP_HEIGHT_PX - 1)  # one pixel wide, so that small discs keep their shape
        disc = np.clip((math.radians(light.diameter_deg) / 2 - angle) / edge + 0.5, 0, 1)
        facing = np.clip(directions @ light.direction(), 0, None)
        level = light.irradiance / float((disc * facing * solid_angles).sum())
        radiance += level * disc[..., None] * _unit_luminance(light.rgb)
    phase = lambert_phase(np.arccos(np.clip(directions[..., 2], -1, 1)))
    key = float((radiance @ LUMINANCE * phase * solid_angles).sum()) / math.pi
    metered = 1.0 if not lighting.lights else key / (1 - lighting.fill_share)
    radiance += lighting.fill_share * metered * _unit_luminance(lighting.fill_rgb)
    painted = radiance.astype(np.float32)
    painted.flags.writeable = False
    return painted, metered


LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
"""Of linear sRGB (BT.709)."""


def _unit_luminance(rgb: tuple[float, float, float]) -> NDArray[np.float64]:
    colour = np.asarray(rgb, dtype=np.float64)
    return np.asarray(colour / (colour @ LUMINANCE))


def _map_grid() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return directions ``(H, 2H, 3)`` and solid angles ``(H, 2H)`` that sum to 4π."""
    theta = np.linspace(0, np.pi, MAP_HEIGHT_PX)
    phi = 2 * np.pi * (np.arange(2 * MAP_HEIGHT_PX) + 0.5) / (2 * MAP_HEIGHT_PX)
    theta, phi = np.meshgrid(theta, phi, indexing="ij")
    directions = np.stack(
        [np.sin(phi) * np.sin(theta), np.cos(theta), -np.cos(phi) * np.sin(theta)], axis=-1
    )
    weights = np.sin(theta)
    return directions, np.asarray(4 * np.pi * weights / weights.sum())
