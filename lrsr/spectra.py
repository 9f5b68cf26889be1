"""Which bands of wavelengths does a spectral film hold, and what does the eye see of them?

A band's value is the mean spectral radiance between two wavelengths, per nanometre and per energy,
in units of daylight: D65 of luminance 1 has the values of :func:`daylight`. Bands are narrow and
their edges meet, so that whatever weighs light by a curve is a sum over bands.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from lrsr.errors import InputError
from lrsr.paths import asset

_FIRST_NM, _LAST_NM = 380.0, 730.0
"""Beyond lies at most 0.02 % of D65's X, Y and Z, and nothing that a camera's filters pass."""

BANDS = 35
"""Usual number: 10 nm each."""

_FloatArray = NDArray[np.float64]

_FINE = 20
"""Points at which a curve is looked at within a band."""

XYZ_TO_RGB = np.array(
    [
        [3.2404542, -1.5371385, -0.4985314],
        [-0.9692660, 1.8760108, 0.0415560],
        [0.0556434, -0.2040259, 1.0572252],
    ]
)  # IEC 61966-2-1

_BRADFORD = np.array(
    [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]]
)  # K. M. Lam 1985; in ICC.1:2022, annex E


@dataclass(frozen=True)
class Spectrum:
    """What the channels of a batch of films are, where they are bands.

    Attributes:
        edges_nm: N + 1 edges of the bands, nm.
        whites: For each of the films N bands of the light that falls on the face, as a white
            Lambertian sphere there sends it back on average, over the meter's reading: its
            luminance is 1.
    """

    edges_nm: tuple[float, ...]
    whites: tuple[tuple[float, ...], ...]


def band_edges(count: int) -> tuple[float, ...]:
    """Return where ``count`` equal bands begin and end, ``count + 1`` wavelengths in nm.

    Raises:
        InputError: Too few to tell colours apart, or more than a nanometre each can be wide.

    Example:
        >>> band_edges(35)[:3]
        (380.0, 390.0, 400.0)
    """
    if not 7 <= count <= 350:
        raise InputError(f"bands={count}: give 0 for three colours, or 7 to 350 spectral bands")
    return tuple(np.linspace(_FIRST_NM, _LAST_NM, count + 1).round(6).tolist())


def average(curve_nm: _FloatArray, curves: _FloatArray, edges_nm: Sequence[float]) -> _FloatArray:
    """Average tabulated curves over bands; straight between their points, 0 beyond them.

    Args:
        curve_nm: ``(M,)``, rising.
        curves: ``(C, M)``.
        edges_nm: N + 1 edges of the bands.

    Returns:
        ``(C, N)``.

    Example:
        >>> average(np.array([400.0, 500.0]), np.array([[0.0, 1.0]]), (400.0, 420.0)).tolist()
        [[0.1]]
    """
    edges = np.asarray(edges_nm)
    steps = (np.arange(_FINE) + 0.5) / _FINE
    points = edges[:-1, None] + steps * np.diff(edges)[:, None]
    return np.stack(
        [np.interp(points, curve_nm, curve, left=0.0, right=0.0).mean(axis=1) for curve in curves]
    )


@lru_cache(maxsize=8)
def _observer(edges_nm: tuple[float, ...]) -> _FloatArray:
    """Return what each band adds to X, Y and Z of the CIE 1931 observer, ``(3, N)``.

    Y of :func:`daylight` is 1.
    """
    values = table("cie_1931")
    return average(values[0], values[1:4], edges_nm) * np.diff(edges_nm) / photometric_unit()


@lru_cache(maxsize=1)
def srgb_curves() -> _FloatArray:
    """Return the linear sRGB of a reflectance under D65, wavelength by wavelength, ``(3, M)``.

    At the wavelengths of :func:`table` "cie_1931", every 5 nm; rows sum to 1.
    """
    _, *observers, light = table("cie_1931")
    curves = XYZ_TO_RGB @ (np.array(observers) * light)
    return np.asarray(curves / curves.sum(axis=1, keepdims=True))


@lru_cache(maxsize=8)
def daylight(edges_nm: tuple[float, ...]) -> _FloatArray:
    """Return the bands ``(N,)`` of standard daylight D65 of luminance 1, the white of sRGB."""
    values = table("cie_1931")
    bands = average(values[0], values[4:5], edges_nm)[0]
    return np.asarray(bands / (_observer(edges_nm)[1] @ bands))


def srgb_weights(
    edges_nm: tuple[float, ...], white: tuple[float, ...] | None = None
) -> _FloatArray:
    """Return what each band adds to linear sRGB, ``(3, N)``; daylight is white exactly.

    Args:
        edges_nm: Of the bands.
        white: Bands of the light that the observer is adapted to, which becomes equal amounts of
            red, green and blue of its own luminance, by von Kries's law in the cone space named
            Bradford; None: daylight, as sRGB has it.

    Example:
        >>> edges = band_edges(35)
        >>> (srgb_weights(edges) @ daylight(edges)).round(6).tolist()
        [1.0, 1.0, 1.0]
    """
    xyz = _observer(edges_nm)
    standard = xyz @ daylight(edges_nm)
    if white is not None:
        seen = xyz @ np.asarray(white)
        gains = (_BRADFORD @ standard) / (_BRADFORD @ (seen / seen[1]))
        xyz = np.linalg.inv(_BRADFORD) @ (gains[:, None] * (_BRADFORD @ xyz))
    rows = XYZ_TO_RGB @ xyz
    # The printed matrix misses white by up to 2e-4.
    return np.asarray(rows / (XYZ_TO_RGB @ standard)[:, None])


def photometric_unit() -> float:
    """Return ∫ ȳ dλ, nm: equal-energy light of luminance 1 has 1 in every band."""
    nm, _, y, *_ = table("cie_1931")
    return float((y[1:] + y[:-1]) @ np.diff(nm) / 2)


@lru_cache(maxsize=8)
def table(name: str) -> _FloatArray:
    """Return a table of curves: wavelengths (nm), then one row for each."""
    values = np.loadtxt(asset(f"spectra/{name}.csv"), delimiter=",", ndmin=2).T.copy()
    values.flags.writeable = False
    return values
