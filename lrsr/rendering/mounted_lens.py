"""How large is a lens and where does its film stand, for a sharp picture of the wanted size?"""

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from lrsr.errors import InputError
from lrsr.rendering.glass import D_LINE_NM
from lrsr.rendering.lens import Lens
from lrsr.rendering.surfaces import (
    WIDE_OPEN_MM,
    Surface,
    entrance_pupil,
    exit_pupil,
    focal_length_mm,
    image_of,
    reversed_surfaces,
    stop_number,
    trace,
)

_Floats = NDArray[np.float64]


@dataclass(frozen=True)
class MountedLens:
    """A lens of its final size before a film. Lengths in mm.

    Attributes:
        surfaces: As light from the scene meets them.
        image_mm: Film behind the last vertex.
        constant_mm: Height on the film per slope at the entrance pupil, near the axis.
        entrance_mm: Entrance pupil before the film.
        pupil_mm: Plane of the exit pupil before the film.
        pupil_shift: From off the axis the pupil seems to move: its middle is the film point times
            c₀ + c₁ r² + c₂ r⁴ (mm⁻², mm⁻⁴), r the point's distance from the axis.
        pupil_radius_mm: Of a disc about that through which all light that passes the lens goes to
            the middle of the film.
        pupil_growth_per_mm: The disc for a point is r² times this larger, mm.
        fall_off: Mean weight of rays aimed at that disc, at evenly spaced distances from the axis
            to ``film_mm``: 1 in the middle.
        film_mm: Farthest point of the film from the axis.
        brightness: π times this is what a film's middle receives of a field of radiance 1.
        falls_off: Do pixels darken off the axis, as cos⁴ and rims make them?
    """

    surfaces: tuple[Surface, ...]
    image_mm: float
    constant_mm: float
    entrance_mm: float
    pupil_mm: float
    pupil_shift: tuple[float, float, float]
    pupil_radius_mm: float
    pupil_growth_per_mm: float
    brightness: float
    falls_off: bool
    fall_off: tuple[float, ...] = (1.0, 1.0)
    film_mm: float = 1.0

    def from_film(self) -> tuple[tuple[Surface, ...], _Floats]:
        """Return the surfaces as light from the film would meet them, and their distance to it."""
        backwards = reversed_surfaces(self.surfaces)
        gaps = [self.image_mm, *(surface.thickness_mm for surface in backwards[:-1])]
        return backwards, np.cumsum(gaps)

    def pupil_middle_mm(self, film_mm: _Floats) -> _Floats:
        """Return where the middle of the exit pupil seems to be from film points ``(N, 2)``, mm."""
        film = np.asarray(film_mm, np.float64)
        square = (film**2).sum(axis=1, keepdims=True)
        return np.asarray(film * np.polynomial.polynomial.polyval(square, self.pupil_shift))

    def pupil_reach_mm(self, film_mm: _Floats) -> _Floats:
        """Return the radius of the disc that holds all light to film points ``(N, 2)``, mm."""
        square = (np.asarray(film_mm, np.float64) ** 2).sum(axis=1)
        return np.asarray(self.pupil_radius_mm + self.pupil_growth_per_mm * square)

    def weight(self, film_mm: _Floats, pupil_mm: _Floats, reach_mm: _Floats) -> _Floats:
        """Return the weights ``(N,)`` of rays that pass, aimed evenly at discs of those radii."""
        square = ((pupil_mm - film_mm) ** 2).sum(axis=1) + self.pupil_mm**2
        return np.asarray((reach_mm * self.pupil_mm / square) ** 2 / self.brightness)

    def rays_from_film(
        self, film_mm: _Floats, pupil_mm: _Floats, wavelength_nm: float = D_LINE_NM
    ) -> tuple[_Floats, _Floats, NDArray[np.bool_]]:
        """Trace rays from points of the film through points of the exit pupil's plane.

        Args:
            film_mm: ``(N, 2)``.
            pupil_mm: ``(N, 2)``.
            wavelength_nm: Of the light.

        Returns:
            points: ``(N, 3)`` on the front surface; z counts from the film towards the scene.
            directions: ``(N, 3)``, unit length.
            through: ``(N,)``, did it pass?
        """
        film, pupil = np.asarray(film_mm, np.float64), np.asarray(pupil_mm, np.float64)
        origins = np.pad(film, ((0, 0), (0, 1)))
        aims = np.pad(pupil, ((0, 0), (0, 1)), constant_values=self.pupil_mm)
        towards = (aims - origins) * np.sign(self.pupil_mm)
        origins[:, 2] -= self.image_mm
        backwards, _ = self.from_film()
        points, directions, through = trace(backwards, origins, towards, wavelength_nm)
        return points + np.array([0.0, 0.0, self.image_mm]), directions, through


@lru_cache(maxsize=64)
def mount(lens: Lens, constant_mm: float, focus_mm: float, film_mm: float) -> MountedLens:
    """Give a lens the size and the film distance that a picture needs.

    Args:
        lens: No pinhole.
        constant_mm: Height on the film per slope in the scene, mm, > 0: what the distance from
            pinhole to film is to a pinhole. The focal length is a little shorter.
        focus_mm: Distance from the entrance pupil to what is to be sharp, mm, > 0; used unless the
            lens has one of its own.
        film_mm: From the middle to the farthest corner of the film, mm.

    Raises:
        InputError: The lens is a pinhole, or cannot be focused so near.
    """
    surfaces = lens.unit()
    focus_mm = focus_mm if lens.focus_m is None else 1000 * lens.focus_m
    factor = constant_mm / focal_length_mm(surfaces)
    for _ in range(50):
        scaled = tuple(surface.scaled(factor) for surface in surfaces)
        before, _ = entrance_pupil(scaled)
        image_mm, magnification = image_of(scaled, focus_mm - before)
        reached = -magnification * focus_mm
        if not (reached > 0 and image_mm > 0 and math.isfinite(image_mm)):
            raise InputError(
                f"lens {lens.name!r} cannot be focused at {focus_mm / 1000:.3g} m;"
                " give a larger focus_m"
            )
        if abs(reached / constant_mm - 1) < 1e-13:
            break
        factor *= constant_mm / reached
    behind, shrunk = exit_pupil(scaled)
    stop_mm = scaled[stop_number(scaled)].semi_aperture_mm
    length_mm = sum(surface.thickness_mm for surface in scaled[:-1])
    mounted = MountedLens(
        surfaces=scaled,
        image_mm=image_mm,
        constant_mm=reached,
        entrance_mm=image_mm + length_mm - before,
        pupil_mm=image_mm - behind,
        pupil_shift=(0.0, 0.0, 0.0),
        pupil_radius_mm=stop_mm * abs(shrunk),
        pupil_growth_per_mm=0.0,
        brightness=0.0,
        falls_off=not lens.is_ideal,
    )
    return _with_pupil(mounted, film_mm)


def _with_pupil(mounted: MountedLens, film_mm: float) -> MountedLens:
    """Find out by rays how wide the exit pupil is, from the film's middle to its edge."""
    paraxial_mm = mounted.pupil_radius_mm
    edge, step = 0.0, 1.5 * paraxial_mm
    for _ in range(4):  # each pass is a hundred times finer
        radii = np.linspace(edge, edge + step, 101)
        aims = np.stack([radii, 0 * radii], axis=1)
        _, _, through = mounted.rays_from_film(np.zeros((101, 2)), aims)
        edge = float(radii[100 if through.all() else max(int(np.argmin(through)) - 1, 0)])
        step /= 100
    mounted = replace(mounted, brightness=edge**2 / (edge**2 + mounted.pupil_mm**2))
    if not mounted.falls_off:
        return mounted
    film = np.stack([film_mm * np.linspace(0, 1, 17), np.zeros(17)], axis=1)
    middle, seen = _aim_at_stop(mounted, film, np.zeros_like(film))
    powers = film[:, :1] ** np.array([1, 3, 5])
    shift, *_ = np.linalg.lstsq(powers[seen], middle[seen, 0], rcond=None)
    mounted = replace(mounted, pupil_shift=tuple(shift.tolist()))
    angles = np.linspace(0, np.pi, 17)
    rim = np.tile(np.stack([np.cos(angles), np.sin(angles)], axis=1), (17, 1))
    heights, film = film[:, 0], film.repeat(17, axis=0)
    aims, seen = _aim_at_stop(mounted, film, rim)
    reach = np.where(seen, np.hypot(*(aims - mounted.pupil_middle_mm(film)).T), 0.0)
    widest = 1.002 * reach.reshape(17, 17).max(axis=1)
    growth = max((widest[-1] - widest[0]) / heights[-1] ** 2, 0.0)
    radius = max(1.003 * edge, float((widest - growth * heights**2).max()))
    mounted = replace(mounted, pupil_radius_mm=radius, pupil_growth_per_mm=float(growth))
    return replace(mounted, fall_off=_fall_off(mounted, film_mm), film_mm=film_mm)


def _fall_off(mounted: MountedLens, film_mm: float) -> tuple[float, ...]:
    """Return the mean weight of rays at 33 distances from the axis, by points of a sunflower."""
    number = np.arange(4000)
    radius, angle = np.sqrt((number + 0.5) / 4000), np.pi * (3 - math.sqrt(5)) * number
    disc = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    means = []
    for height in np.linspace(0, film_mm, 33):
        film = np.tile([height, 0.0], (4000, 1))
        reach = mounted.pupil_reach_mm(film)[:, None]
        aims = disc * reach + mounted.pupil_middle_mm(film)
        _, _, through = mounted.rays_from_film(film, aims)
        means.append(float((through * mounted.weight(film, aims, reach[:, 0])).mean()))
    return tuple(means)


def _aim_at_stop(
    mounted: MountedLens, film_mm: _Floats, stop: _Floats
) -> tuple[_Floats, NDArray[np.bool_]]:
    """Find where rays that meet the stop at a point cross the exit pupil's plane.

    Args:
        mounted: The lens.
        film_mm: ``(N, 2)``, where the rays begin.
        stop: ``(N, 2)``, where they are to meet the stop, in units of its radius.

    Returns:
        aims: ``(N, 2)``, mm.
        seen: ``(N,)``, did a ray reach the stop at all? Rims do not count.
    """
    backwards, _ = mounted.from_film()
    number = stop_number(backwards)
    rim_mm = backwards[number].semi_aperture_mm
    towards_stop = tuple(replace(s, semi_aperture_mm=WIDE_OPEN_MM) for s in backwards[: number + 1])
    short = replace(mounted, surfaces=reversed_surfaces(towards_stop))
    aims = mounted.pupil_radius_mm * stop
    for _ in range(20):
        met, _, seen = short.rays_from_film(film_mm, aims)
        aims = aims + (stop - met[:, :2] / rim_mm) * mounted.pupil_radius_mm
    return aims, seen
