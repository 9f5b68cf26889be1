"""How does the light of single wavelengths become the bands of a film?"""

from collections.abc import Iterator
from typing import Any

from lrsr.rendering.backend import dr, mi
from lrsr.spectra import photometric_unit


def draw_wavelengths(uniform: Any, span_nm: tuple[float, float]) -> tuple[Any, Any]:
    """Draw the wavelengths of a ray, all equally likely and evenly spaced, and their 1 / density.

    Args:
        uniform: ``mi.Float``, [0, 1).
        span_nm: Shortest and longest.

    Returns:
        ``mi.Spectrum`` each; nm.
    """
    shortest, longest = span_nm
    wavelengths = shortest + (longest - shortest) * mi.sample_shifted(uniform)
    return mi.Spectrum(wavelengths), mi.Spectrum(longest - shortest)


def split(light: Any, wavelengths: Any, edges_nm: tuple[float, ...]) -> Iterator[Any]:
    """Yield what each ray says of the mean radiance in one band after the other.

    Args:
        light: ``mi.Spectrum``, of each of a ray's wavelengths, over its density.
        wavelengths: ``mi.Spectrum``, nm.
        edges_nm: Of equal bands; light of other wavelengths is counted in none.

    Yields:
        ``mi.Float`` in units of :func:`lrsr.spectra.daylight`.
    """
    width = edges_nm[1] - edges_nm[0]
    # Luminance is 1 of the same light here and there.
    unit = mi.MI_CIE_Y_NORMALIZATION * photometric_unit() / (width * len(wavelengths))
    places = [dr.floor((own - edges_nm[0]) / width) for own in wavelengths]
    for number in range(len(edges_nm) - 1):
        band = dr.opaque(mi.Float, number)  # no literal, so that one kernel serves all
        here = [
            dr.select(place == band, own, 0.0) for place, own in zip(places, light, strict=True)
        ]
        yield unit * sum(here[1:], here[0])
