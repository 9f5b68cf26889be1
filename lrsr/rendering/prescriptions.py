"""Of which surfaces is a lens made? Published tables, and lenses by a formula."""

import math

from lrsr.errors import InputError
from lrsr.rendering.glass import AIR, refractive_index
from lrsr.rendering.surfaces import Surface

DOUBLE_GAUSS = (
    Surface(58.950, 7.520, "N-BAF10", 25.2),
    Surface(169.660, 0.240, AIR, 25.2),
    Surface(38.550, 8.050, "N-BAF10", 23.0),
    Surface(81.540, 6.550, "N-SF15", 23.0),
    Surface(25.500, 11.410, AIR, 18.0),
    Surface(0.0, 9.000, AIR, 17.1, stop=True),
    Surface(-28.990, 2.360, "F5", 17.0),
    Surface(81.540, 12.130, "K-LaK11", 20.0),
    Surface(-40.770, 0.380, AIR, 20.0),
    Surface(874.130, 6.440, "N-LAF3", 20.0),
    Surface(-79.460, 72.228, AIR, 20.0),
)
"""F/2 double Gauss of 100 mm and ±22°: Tronnier, US patent 2,673,491, as W. J. Smith (Modern Lens
Design, 1992, p. 312) and Kolb, Mitchell and Hanrahan (SIGGRAPH 1995, table 1) print it; PBRT's
``dgauss.50mm`` is half as large. They give n_d to three digits and V_d (1.670/47.1, 1.699/30.1,
1.603/38.0, 1.658/57.3, 1.717/48.0): these are the catalogue's glasses of those numbers."""


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
