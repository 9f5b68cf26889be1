"""Through which lens does the camera look? Pinhole, ideal thin lens, or a table of surfaces.

A lens keeps its proportions and takes the size that the picture asks for: 3 mm of focal length for
the reference camera. It is focused by moving the film to where paraxial rays meet, and its entrance
pupil stands where the pinhole would, so that all lenses show the same frame.
"""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

from lrsr.configuration import as_parts, settle
from lrsr.errors import InputError
from lrsr.rendering.glass import AIR, refractive_index
from lrsr.rendering.surfaces import Surface, entrance_pupil, focal_length_mm, stop_number

CHANNELS_NM = (611.4, 549.1, 464.2)
"""Dominant wavelengths of the sRGB primaries (white D65): what each channel of an rgb picture is
traced at where a lens is asked to disperse."""


def _widest_f_number(surfaces: Sequence[Surface]) -> float:
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
        settle(self, "lens")
        surfaces = as_parts(Surface, self.surfaces, "lens.surfaces")
        object.__setattr__(self, "surfaces", surfaces)
        for name in ("f_number", "focus_m"):
            value = getattr(self, name)
            if value is not None and value <= 0:
                raise InputError(f"lens.{name}={value:g}: wanted a number > 0")
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
        widest = _widest_f_number(self.surfaces)
        if self.f_number is not None and self.f_number < widest * (1 - 1e-9):
            raise InputError(
                f"lens {self.name!r}: f_number={self.f_number}; it opens to {widest:.4g} at most"
            )

    def record(self) -> dict[str, Any]:
        """Return what makes this lens and no other, in plain values."""
        values = asdict(self)
        del values["name"]
        return values

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


PINHOLE = Lens("pinhole")
"""Everything is sharp."""


def biconvex(
    focal_mm: float, thickness_mm: float, semi_aperture_mm: float, glass: str
) -> tuple[Surface, ...]:
    """Make a lens of two equal faces by the lensmaker's equation, its stop on the first face.

    1/f = (n - 1) (2/R - (n - 1) t / (n R²)), n at the d line, solved for R.

    Args:
        focal_mm: Focal length, mm, > 0.
        thickness_mm: Of the middle, mm.
        semi_aperture_mm: Radius of the open face, mm.
        glass: Name of one that :func:`lrsr.rendering.glass.coefficients` knows.

    Raises:
        InputError: No such lens: it would be too thick, or its faces would meet inside the edge.

    Example:
        >>> front, back = biconvex(3.0, 1.0, 1.1, "N-BK7")[1:]
        >>> front.radius_mm == -back.radius_mm
        True
    """
    n = float(refractive_index(glass))
    square = focal_mm**2 - focal_mm * thickness_mm / n
    radius_mm = (n - 1) * (focal_mm + math.sqrt(max(square, 0.0)))
    if square < 0 or semi_aperture_mm >= radius_mm:
        raise InputError(
            f"biconvex lens of {focal_mm} mm: thickness {thickness_mm} mm and semi-aperture"
            f" {semi_aperture_mm} mm do not fit; give smaller ones"
        )
    sag_mm = radius_mm - math.sqrt(radius_mm**2 - semi_aperture_mm**2)
    if 2 * sag_mm >= thickness_mm:
        raise InputError(
            f"biconvex lens of {focal_mm} mm: faces meet inside the semi-aperture of"
            f" {semi_aperture_mm} mm; give a thickness > {2 * sag_mm:.3g} mm"
        )
    return (
        Surface(0.0, 0.0, AIR, semi_aperture_mm, stop=True),
        Surface(radius_mm, thickness_mm, glass, radius_mm * 0.99),
        Surface(-radius_mm, focal_mm, AIR, radius_mm * 0.99),
    )
