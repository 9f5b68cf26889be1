"""Which spectrum has light that is known by its colour, where Mitsuba traces wavelengths?

Mitsuba turns the colour of a light into that of D65 behind a filter, the smoothest one that gives
that colour (W. Jakob and J. Hanika 2019, "A low-dimensional function space for efficient spectral
upsampling"). The camera's meter has to know what light that is, so it is computed here again.
"""

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from lrsr.rendering.backend import mi
from lrsr.rendering.environment import (
    environment,
    hides,
    lambert_phase,
    map_grid,
    panel_metered,
)
from lrsr.rendering.lighting import Lighting
from lrsr.spectra import average, daylight, table

_FloatArray = NDArray[np.float64]

_STEP_NM = 1.0


def _filters(rgb: _FloatArray, nm: _FloatArray) -> _FloatArray:
    """Return the smooth spectra that Mitsuba gives to colours of linear sRGB.

    Args:
        rgb: ``(K, 3)``, [0, 1].
        nm: ``(M,)``, wavelengths.

    Returns:
        ``(K, M)``, [0, 1].
    """
    fits = [np.array(mi.srgb_model_fetch(mi.ScalarColor3f(*colour))) for colour in rgb.tolist()]
    coefficients = np.array(fits, dtype=np.float64)
    polynomial = (coefficients[:, :1] * nm + coefficients[:, 1:2]) * nm + coefficients[:, 2:]
    with np.errstate(invalid="ignore"):  # black and white have infinite coefficients
        shape = polynomial / np.sqrt(1 + polynomial**2)
    shape = np.where(np.isinf(polynomial), np.sign(polynomial), shape)
    return np.asarray(0.5 + 0.5 * shape)


def _light_bands(rgb: _FloatArray, edges_nm: tuple[float, ...]) -> _FloatArray:
    """Return the bands of light of those colours, as emitters of a spectral variant send it out.

    Args:
        rgb: ``(..., 3)``, linear sRGB, >= 0.
        edges_nm: N + 1 edges of the bands.

    Returns:
        ``(..., N)``, in units of :func:`lrsr.spectra.daylight`.
    """
    colours, places = np.unique(rgb.reshape(-1, 3), axis=0, return_inverse=True)
    scale = 2 * colours.max(axis=1, keepdims=True)
    nm = np.arange(edges_nm[0], edges_nm[-1] + _STEP_NM / 2, _STEP_NM)
    curves = table("cie_1931")
    white = np.interp(nm, curves[0], curves[4])
    shapes = scale * _filters(colours / np.maximum(scale, 1e-8), nm)
    unit = daylight(edges_nm).sum() / average(nm, white[None], edges_nm).sum()
    bands = unit * average(nm, shapes * white, edges_nm)
    return np.asarray(bands[places.ravel()].reshape(*rgb.shape[:-1], -1))


@lru_cache(maxsize=64)
def meter_bands(lighting: Lighting, edges_nm: tuple[float, ...]) -> tuple[float, ...]:
    """Read the incident-light meter band by band; see :func:`~lrsr.rendering.environment`.

    Returns:
        N bands of what a grey Lambertian sphere at the face sends to the level camera on average,
        divided by its reflectance. Their luminance is the meter's reading, but for what the
        spectra of saturated colours miss of these (below 1 % in the lightings that have names).

    Raises:
        InputError: The lighting's map cannot be used.
    """
    directions, solid_angles = map_grid()
    weight = lambert_phase(np.arccos(np.clip(directions[..., 2], -1, 1))) * solid_angles / math.pi
    if lighting.panels:
        weight *= ~np.any([hides(panel, directions) for panel in lighting.panels], axis=0)
    painted = environment(lighting)[0].astype(np.float64)
    colours, places = np.unique(painted.reshape(-1, 3), axis=0, return_inverse=True)
    amounts = np.bincount(places.ravel(), weight.ravel(), minlength=len(colours))
    bands = amounts @ _light_bands(colours, edges_nm)
    for panel in lighting.panels:
        bands = bands + panel_metered(panel) * _light_bands(panel.colour, edges_nm)
    return tuple(bands.tolist())
