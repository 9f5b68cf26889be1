"""Through which lens does the camera look? Pinhole, ideal thin lens, or a table of surfaces.

A lens keeps its proportions and takes the size that the picture asks for: 3 mm of focal length for
the reference camera. It is focused by moving the film to where paraxial rays meet, and its entrance
pupil stands where the pinhole would, so that all lenses show the same frame.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lrsr.errors import InputError
from lrsr.rendering.glass import AIR, D_LINE_NM
from lrsr.rendering.prescriptions import DOUBLE_GAUSS, biconvex
from lrsr.rendering.surfaces import (
    Surface,
    entrance_pupil,
    exit_pupil,
    focal_length_mm,
    image_of,
    reversed_surfaces,
    stop_number,
    trace,
)

CHANNELS_NM = (611.4, 549.1, 464.2)
"""Dominant wavelengths of the sRGB primaries (white D65): what each channel of an rgb picture is
traced at where a lens is asked to disperse."""


def widest_f_number(surfaces: Sequence[Surface]) -> float:
    """Return the f-number of the stop as it is drawn."""
    radius = surfaces[stop_number(surfaces)].semi_aperture_mm * abs(entrance_pupil(surfaces)[1])
    return focal_length_mm(surfaces) / (2 * radius)


@dataclass(frozen=True)
class Lens:
    """What stands before the film. Without surfaces and f-number: a pinhole.

    Attributes:
        name: For people; two lenses of the same numbers make the same picture.
        surfaces: From the front to the film, of any scale, or mappings of their fields; with an
            f-number and no surfaces the lens is ideal and thin.
        f_number: Focal length over diameter of the entrance pupil; None: the stop as it is drawn.
        focus_m: Distance from the entrance pupil that is sharp, m; None: the subject's eyes.
        dispersion: Does glass spread colours in rgb variants, too? Each ray then is of one channel,
            traced at :data:`CHANNELS_NM`: 3 times the variance. Spectral variants always disperse.
    """

    name: str
    surfaces: tuple[Surface, ...] = ()
    f_number: float | None = None
    focus_m: float | None = None
    dispersion: bool = False

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            InputError: An f-number or distance that cannot be, a lens without stop, one that does
                not gather light or ends in glass, or one that does not open so far.
        """
        given: Iterable[Any] = self.surfaces  # Hydra hands over lists of mappings
        surfaces = tuple(row if isinstance(row, Surface) else Surface(**row) for row in given)
        object.__setattr__(self, "surfaces", surfaces)
        for name in ("f_number", "focus_m"):
            value = getattr(self, name)
            if value is not None and not 0 < value < math.inf:
                raise InputError(f"lens {self.name!r}: {name}={value}; give a number > 0")
        if surfaces:
            self._check_surfaces()

    def _check_surfaces(self) -> None:
        try:
            stop_number(self.surfaces)
            focal_length_mm(self.surfaces)
        except InputError as error:
            raise InputError(f"lens {self.name!r}: {error}") from error
        if self.surfaces[-1].glass != AIR:
            raise InputError(f"lens {self.name!r} ends in glass: give its last surface air behind")
        widest = widest_f_number(self.surfaces)
        if self.f_number is not None and self.f_number < widest * (1 - 1e-9):
            raise InputError(
                f"lens {self.name!r}: f_number={self.f_number}; it opens to {widest:.4g} at most"
            )

    @property
    def is_pinhole(self) -> bool:
        """Has it neither surfaces nor an aperture?"""
        return not self.surfaces and self.f_number is None

    @property
    def is_ideal(self) -> bool:
        """Is it a thin lens without aberrations or fall-off?"""
        return not self.surfaces and self.f_number is not None

    def unit(self) -> tuple[Surface, ...]:
        """Return the surfaces with the stop of the f-number, of the scale they are given in.

        Raises:
            InputError: A pinhole has none.
        """
        if self.is_pinhole:
            raise InputError(f"lens {self.name!r} is a pinhole: it has no surfaces")
        if self.f_number is None:
            return self.surfaces
        surfaces = self.surfaces or (Surface(0.0, 1.0, AIR, 1.0, stop=True, power_per_mm=1.0),)
        _, enlarged = entrance_pupil(surfaces)
        radius_mm = focal_length_mm(surfaces) / (2 * self.f_number * abs(enlarged))
        stop = stop_number(surfaces)
        stopped = replace(surfaces[stop], semi_aperture_mm=radius_mm)
        return (*surfaces[:stop], stopped, *surfaces[stop + 1 :])


LENSES = {
    lens.name: lens
    for lens in (
        Lens("pinhole"),
        Lens("thin", f_number=1.4),
        Lens("single", biconvex(3.0, 1.0, 1.05, "N-BK7"), f_number=4.0),
        Lens("double_gauss", DOUBLE_GAUSS),
    )
}
"""Lenses by name: thin has the reference camera's aperture; single is a biconvex lens of N-BK7 that
glows by spherical aberration (the paper's Fig. 10); double_gauss is F/2, eleven surfaces."""


def find_lens(name: str | Lens, **changes: Any) -> Lens:
    """Return a lens by its name, or the lens itself; ``changes`` replace fields.

    Raises:
        InputError: There is no lens of that name.

    Example:
        >>> find_lens("single", f_number=2.8).f_number
        2.8
    """
    if isinstance(name, Lens):
        return replace(name, **changes)
    if name not in LENSES:
        raise InputError(f"lens {name!r} does not exist; choose one of {', '.join(LENSES)}")
    return replace(LENSES[name], **changes)


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
        pupil_radius_mm: Of a disc about that through which all light that passes the lens goes.
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
    brightness: float
    falls_off: bool

    def from_film(self) -> tuple[tuple[Surface, ...], NDArray[np.float64]]:
        """Return the surfaces as light from the film would meet them, and their distance to it."""
        backwards = reversed_surfaces(self.surfaces)
        gaps = [self.image_mm, *(surface.thickness_mm for surface in backwards[:-1])]
        return backwards, np.cumsum(gaps)

    def pupil_middle_mm(self, film_mm: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return where the middle of the exit pupil seems to be from film points ``(N, 2)``, mm."""
        film = np.asarray(film_mm, np.float64)
        square = (film**2).sum(axis=1, keepdims=True)
        return np.asarray(film * np.polynomial.polynomial.polyval(square, self.pupil_shift))

    def rays_from_film(
        self,
        film_mm: NDArray[np.float64],
        pupil_mm: NDArray[np.float64],
        wavelength_nm: float = D_LINE_NM,
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
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
    film = film.repeat(17, axis=0)
    aims, seen = _aim_at_stop(mounted, film, rim)
    widest = np.hypot(*(aims - mounted.pupil_middle_mm(film))[seen].T).max(initial=edge)
    return replace(mounted, pupil_radius_mm=1.02 * float(widest))


def _aim_at_stop(
    mounted: MountedLens, film_mm: NDArray[np.float64], stop: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
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
    towards_stop = tuple(replace(s, semi_aperture_mm=math.inf) for s in backwards[: number + 1])
    short = replace(mounted, surfaces=reversed_surfaces(towards_stop))
    aims = mounted.pupil_radius_mm * stop
    for _ in range(20):
        met, _, seen = short.rays_from_film(film_mm, aims)
        aims = aims + (stop - met[:, :2] / rim_mm) * mounted.pupil_radius_mm
    return aims, seen
