"""Which lamps light a face? Far discs and near panels, their places, sizes and colours.

Angles are in degrees in the frame of the camera: azimuth 0, elevation 0 is where the level camera
stands.
"""

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lrsr.configuration import settle
from lrsr.errors import InputError
from lrsr.rendering.colour import chromaticity, rgb_of_kelvin, unit_luminance

NEW: Mapping[str, bool] = {"left_out": True}
"""Of a field that came later: while it has its default, records and cache keys do not name it."""


def _is_colour(rgb: tuple[float, ...]) -> bool:
    return min(rgb) >= 0 and max(rgb) > 0


def colour_of(rgb: tuple[float, float, float], kelvin: float | None) -> NDArray[np.float64]:
    """Return linear sRGB ``(3,)`` of luminance 1, of either of the two."""
    return unit_luminance(rgb if kelvin is None else rgb_of_kelvin(kelvin))


def check_colour(what: str, rgb: tuple[float, ...], kelvin: float | None) -> None:
    """Refuse a colour that is none, or two of them.

    Raises:
        InputError: It is one of those.
    """
    if not _is_colour(rgb):
        raise InputError(f"{what}={rgb}; give three numbers >= 0")
    if kelvin is not None:
        chromaticity(kelvin)
        if rgb != (1.0, 1.0, 1.0):
            raise InputError(f"{what}={rgb} and kelvin={kelvin}: give one of the two")


@dataclass(frozen=True)
class Light:
    """A far disc of uniform radiance.

    Attributes:
        azimuth_deg: From the camera towards the image's right, about the vertical.
        elevation_deg: Above the camera's level, -90..90.
        diameter_deg: Apparent diameter, > 0: 27° is a 1.2 m softbox at 2.5 m.
        irradiance: On a surface that faces it; 1 lights a white Lambertian to radiance 1/π.
        rgb: Colour; scaled so that its luminance is 1.
        kelvin: Colour temperature instead, 2000..25000 K.
    """

    azimuth_deg: float
    elevation_deg: float
    diameter_deg: float = 27.0
    irradiance: float = math.pi
    rgb: tuple[float, float, float] = (1.0, 1.0, 1.0)
    kelvin: float | None = field(default=None, metadata=NEW)

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            InputError: A light without power, of no colour or two, or larger than half the sky.
        """
        settle(self, "light")
        if not (self.irradiance > 0 and 0 < self.diameter_deg <= 180 and _is_colour(self.rgb)):
            raise InputError(
                f"light: irradiance {self.irradiance}, diameter {self.diameter_deg}°,"
                f" rgb {self.rgb}; give irradiance > 0, a diameter of 0..180 and three numbers >= 0"
            )
        check_colour("light: rgb", self.rgb, self.kelvin)

    @property
    def colour(self) -> NDArray[np.float64]:
        """Linear sRGB ``(3,)`` of luminance 1."""
        return colour_of(self.rgb, self.kelvin)

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
class Panel:
    """A near rectangle of uniform radiance that faces the eyes: a window, a lamp, a screen.

    Attributes:
        position_mm: Of its middle: to the image's right, up and towards the level camera from the
            point midway between the pupils of a frontal face, mm.
        width_mm: Level side, mm, > 0.
        height_mm: Other side, mm, > 0.
        irradiance: Between the eyes, on a surface that faces it.
        rgb: Colour; scaled so that its luminance is 1.
        kelvin: Colour temperature instead, 2000..25000 K.
    """

    position_mm: tuple[float, float, float]
    width_mm: float
    height_mm: float
    irradiance: float = math.pi
    rgb: tuple[float, float, float] = (1.0, 1.0, 1.0)
    kelvin: float | None = None

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            InputError: A panel without size or power, inside the head, or of no colour or two.
        """
        settle(self, "panel")
        sound = min(self.width_mm, self.height_mm, self.irradiance) > 0
        if not sound or self.distance_mm < _NEAREST_MM:
            raise InputError(
                f"panel at {self.position_mm} mm, {self.width_mm} x {self.height_mm} mm, irradiance"
                f" {self.irradiance}: give finite numbers, sizes and irradiance > 0, and a position"
                f" at least {_NEAREST_MM:g} mm away"
            )
        check_colour("panel: rgb", self.rgb, self.kelvin)

    @property
    def distance_mm(self) -> float:
        """From the point between the eyes to its middle."""
        return math.hypot(*self.position_mm)

    @property
    def colour(self) -> NDArray[np.float64]:
        """Linear sRGB ``(3,)`` of luminance 1."""
        return colour_of(self.rgb, self.kelvin)

    def to_world(self) -> NDArray[np.float64]:
        """Return the ``(4, 4)`` matrix of the square -1..1 in x and y that shines along +z."""
        middle = np.array(self.position_mm, dtype=np.float64)
        facing = -middle / self.distance_mm
        level = np.cross([0.0, 1.0, 0.0], facing)
        length = np.linalg.norm(level)
        level = level / length if length > 1e-9 else np.array([1.0, 0.0, 0.0])
        matrix = np.eye(4)
        matrix[:3, 0] = level * self.width_mm / 2
        matrix[:3, 1] = np.cross(facing, level) * self.height_mm / 2
        matrix[:3, 2] = facing
        matrix[:3, 3] = middle
        return matrix


_NEAREST_MM = 200.0
"""A panel that is nearer would stand in the head."""


def spare(instance: Any) -> dict[str, Any]:
    """Return the fields of a dataclass without those that came later and have their defaults."""
    given = asdict(instance)
    for each in fields(instance):
        if each.metadata.get("left_out") and getattr(instance, each.name) == each.default:
            del given[each.name]
    return given
