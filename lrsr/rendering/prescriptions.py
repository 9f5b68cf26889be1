"""Of which surfaces is a lens made? Published tables, and lenses by a formula."""

import math

from lrsr.errors import InputError
from lrsr.rendering.glass import AIR, refractive_index
from lrsr.rendering.surfaces import Surface


def biconvex(
    focal_mm: float, thickness_mm: float, semi_aperture_mm: float, glass: str
) -> tuple[Surface, ...]:
    """Make a lens of two equal faces by the lensmaker's equation, its stop on the first face.

    1/f = (n - 1) (2/R - (n - 1) t / (n R²)), n at the d line, solved for R.

    Args:
        focal_mm: Focal length, mm, > 0.
        thickness_mm: Of the middle, mm.
        semi_aperture_mm: Radius of the open face, mm.
        glass: Name in :data:`lrsr.rendering.glass.SELLMEIER`.

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
