"""What does a row of surfaces do to a ray? Exactly, and in the limit of rays near the axis.

Light goes along +z; a surface's radius is positive where its centre lies behind it. Lengths in mm,
double precision: this is what the sensor in Dr.Jit (:mod:`lrsr.rendering.lens_sensor`) is held to.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from lrsr.configuration import require, settle
from lrsr.errors import InputError
from lrsr.rendering.glass import AIR, D_LINE_NM, refractive_index

WIDE_OPEN_MM = 1e6
"""Semi-aperture of a surface whose rim is in nobody's way."""


@dataclass(frozen=True)
class Surface:
    """One row of a lens table.

    Attributes:
        radius_mm: Of the sphere, > 0 if the centre lies behind; 0 is a plane.
        thickness_mm: To the next surface along the axis; of the last one, to the image of what is
            infinitely far away (not used: the film goes where it is sharp).
        glass: Behind the surface.
        semi_aperture_mm: Radius that lets light through, > 0.
        stop: Is this the aperture stop? One surface is.
        power_per_mm: Of an ideal thin lens in this plane; 0 for glass.
    """

    radius_mm: float
    thickness_mm: float
    glass: str = AIR
    semi_aperture_mm: float = WIDE_OPEN_MM
    stop: bool = False
    power_per_mm: float = 0.0

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            InputError: A length that cannot be, or an unknown glass.
        """
        settle(self, "surface")
        name, aperture = "surface.semi_aperture_mm", self.semi_aperture_mm
        require(aperture > 0, name, f"{aperture:g}", "a number of millimetres > 0")
        refractive_index(self.glass)  # refuses an unknown one

    @property
    def curvature_per_mm(self) -> float:
        """1 / radius; 0 for a plane."""
        return 1 / self.radius_mm if self.radius_mm else 0.0

    def scaled(self, factor: float) -> "Surface":
        """Return the surface of a lens that is ``factor`` times as large."""
        return replace(
            self,
            radius_mm=factor * self.radius_mm,
            thickness_mm=factor * self.thickness_mm,
            semi_aperture_mm=factor * self.semi_aperture_mm,
            power_per_mm=self.power_per_mm / factor,
        )


def _indices(surfaces: Sequence[Surface], wavelength_nm: float = D_LINE_NM) -> NDArray[np.float64]:
    """Return the index before the first surface and behind each, ``(N + 1,)``."""
    behind = [float(refractive_index(surface.glass, wavelength_nm)) for surface in surfaces]
    return np.array([1.0, *behind])


def _paraxial(surfaces: Sequence[Surface], wavelength_nm: float = D_LINE_NM) -> NDArray[np.float64]:
    """Return the ray matrix from the first vertex to the last, for (height, n · slope).

    A surface is [[1, 0], [-φ, 1]] with φ = (n' - n) c, a gap [[1, t / n], [0, 1]] (Gauss 1841).

    Example:
        >>> thin = Surface(0, 0, power_per_mm=0.1)
        >>> _paraxial([thin]).tolist()
        [[1.0, 0.0], [-0.1, 1.0]]
    """
    matrix = np.eye(2)
    n = _indices(surfaces, wavelength_nm)
    for number, surface in enumerate(surfaces):
        if number:
            gap = surfaces[number - 1].thickness_mm / n[number]
            matrix = np.array([[1.0, gap], [0.0, 1.0]]) @ matrix
        power = (n[number + 1] - n[number]) * surface.curvature_per_mm + surface.power_per_mm
        matrix = np.array([[1.0, 0.0], [-power, 1.0]]) @ matrix
    return matrix


def focal_length_mm(surfaces: Sequence[Surface], wavelength_nm: float = D_LINE_NM) -> float:
    """Return the effective focal length, mm.

    Raises:
        InputError: The surfaces do not gather light.

    Example:
        >>> focal_length_mm([Surface(0, 0, power_per_mm=0.25)])
        4.0
    """
    power = -float(_paraxial(surfaces, wavelength_nm)[1, 0])
    if not power > 0:
        raise InputError(f"the lens has the power {power:.3g} per mm: give one that gathers light")
    return 1 / power


def image_of(
    surfaces: Sequence[Surface], object_mm: float, wavelength_nm: float = D_LINE_NM
) -> tuple[float, float]:
    """Return where a plane in front is sharp, near the axis, and how large.

    Args:
        surfaces: In air, at least one.
        object_mm: Distance of the plane before the first vertex, mm; ``math.inf`` is allowed.
        wavelength_nm: Of the light.

    Returns:
        image_mm: Distance behind the last vertex, mm; < 0 or infinite if no film can stand there.
        magnification: Height of the image over that of the plane; < 0 if upside down.

    Example:
        >>> image_of([Surface(0, 0, power_per_mm=0.25)], 8.0)
        (8.0, -1.0)
    """
    (a, b), (c, d) = _paraxial(surfaces, wavelength_nm)
    if math.isinf(object_mm):
        return float(-a / c), 0.0
    steepness = c * object_mm + d
    image_mm = -(a * object_mm + b) / steepness if steepness else math.inf
    return float(image_mm), float(a + image_mm * c)


def stop_number(surfaces: Sequence[Surface]) -> int:
    """Return which surface is the stop.

    Raises:
        InputError: None or several are.
    """
    stops = [number for number, surface in enumerate(surfaces) if surface.stop]
    if len(stops) != 1:
        raise InputError(f"a lens of {len(stops)} stops: mark exactly one surface as stop")
    return stops[0]


def entrance_pupil(surfaces: Sequence[Surface]) -> tuple[float, float]:
    """Return where the stop appears to stand, seen from the front, and how large.

    Returns:
        position_mm: Behind the first vertex, mm.
        magnification: Radius of the pupil over that of the stop.
    """
    stop = stop_number(surfaces)
    if stop == 0:
        return 0.0, 1.0
    # From (height, slope) in front to the stop's plane: a ray through its middle has height 0.
    n, gap = _indices(surfaces), surfaces[stop - 1].thickness_mm
    (a, b), _ = np.array([[1.0, gap / n[stop]], [0.0, 1.0]]) @ _paraxial(surfaces[:stop])
    return float(b / a), float(1 / a)


def exit_pupil(surfaces: Sequence[Surface]) -> tuple[float, float]:
    """Return where the stop appears to stand, seen from the film, and how large.

    Returns:
        position_mm: Behind the last vertex (mostly < 0: inside the lens), mm.
        magnification: Radius of the pupil over that of the stop.
    """
    position_mm, magnification = entrance_pupil(reversed_surfaces(tuple(surfaces)))
    return -position_mm, magnification


@lru_cache(maxsize=64)
def reversed_surfaces(surfaces: tuple[Surface, ...]) -> tuple[Surface, ...]:
    """Return the lens turned round: what light from the film meets."""
    glasses = [AIR, *(surface.glass for surface in surfaces)][-2::-1]
    gaps = [surface.thickness_mm for surface in surfaces[-2::-1]]
    return tuple(
        replace(surface, radius_mm=-surface.radius_mm + 0.0, thickness_mm=gap, glass=glass)
        for surface, gap, glass in zip(reversed(surfaces), [*gaps, 0.0], glasses, strict=True)
    )


def trace(
    surfaces: Sequence[Surface],
    origins: NDArray[np.float64],
    directions: NDArray[np.float64],
    wavelength_nm: float = D_LINE_NM,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
    """Refract rays at every surface by Snell's law (Welford 1986, sections 4.2 and 4.3).

    Args:
        surfaces: The first vertex is the origin.
        origins: ``(N, 3)``, mm.
        directions: ``(N, 3)``, any length, with z > 0.
        wavelength_nm: Of the light.

    Returns:
        points: ``(N, 3)`` on the last surface, mm.
        directions: ``(N, 3)``, unit length.
        through: ``(N,)``; False: missed a surface, hit a rim or was totally reflected.
    """
    n = _indices(surfaces, wavelength_nm)
    vertices = np.cumsum([0.0, *(surface.thickness_mm for surface in surfaces[:-1])])
    # Rows of x, y and z: NumPy is slow at sums of three columns.
    point = np.ascontiguousarray(np.asarray(origins, dtype=np.float64).T)
    ray = np.ascontiguousarray(np.asarray(directions, dtype=np.float64).T)
    ray = ray / np.linalg.norm(ray, axis=0)
    through = np.ones(point.shape[1], dtype=bool)
    along = np.array([[0.0], [0.0], [1.0]])
    for surface, vertex, (before, behind) in zip(surfaces, vertices, pairwise(n), strict=True):
        c = surface.curvature_per_mm
        point = point + ((vertex - point[2]) / ray[2]) * ray
        f = c * (point[:2] ** 2).sum(axis=0)
        g = ray[2] - c * (point[:2] * ray[:2]).sum(axis=0)
        square = g**2 - c * f
        cosine = np.sqrt(np.clip(square, 0, None))
        step = np.divide(f, g + cosine, out=np.zeros_like(f), where=square > 0)
        point = point + step * ray
        inside = (point[:2] ** 2).sum(axis=0) <= surface.semi_aperture_mm**2
        ratio = before / behind
        bent = (1 - ratio) * (1 + ratio) + (ratio * cosine) ** 2  # cos² of refraction
        through &= (square > 0) & inside & (bent > 0)
        turn = np.sqrt(np.clip(bent, 0, None)) - ratio * cosine
        ray = ratio * ray + turn * (along - c * (point - vertex * along))
        if surface.power_per_mm:
            ray[:2] -= surface.power_per_mm * ray[2] * point[:2]
            ray = ray / np.linalg.norm(ray, axis=0)
        # What is lost goes along the axis from here on, so that all numbers stay finite.
        point = np.where(through, point, vertex * along)
        ray = np.where(through, ray, along)
    return point.T, ray.T, through
