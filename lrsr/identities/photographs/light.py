"""How was a face lit? Spherical _harmonics of second order, read from plain skin.

A convex matte surface answers any distant light by its first nine _harmonics (Ramamoorthi and
Hanrahan, "On the relationship between radiance and irradiance", JOSA A 18, 2001). Highlights and
cast shadows are none, so the fit is robust.
"""

import numpy as np
from numpy.typing import NDArray

Map = NDArray[np.float32]
_Floats = NDArray[np.float64]

_ROUNDS = 12
_OUTLIER = 2.0
"""Robust standard deviations at which a texel counts half."""
_RIDGE = np.array([0.0, 0.02, 0.02, 0.02, *[0.04] * 5])
"""Share of the weight that pulls each harmonic to none."""
_LIMITS = (0.3, 2.5)
"""Darkest and brightest light that is divided out, the core's being 1."""
_MOST_TEXELS = 20_000


def _harmonics(normals: NDArray[np.floating]) -> NDArray[np.floating]:
    """Return the nine _harmonics ``(..., 9)`` of unit vectors ``(..., 3)``, not normalised."""
    x, y, z = np.moveaxis(normals, -1, 0)
    one = np.ones_like(x)
    second = (x * y, x * z, y * z, x * x - y * y, 3 * z * z - 1)
    return np.stack([one, x, y, z, *second], axis=-1)


def estimate_shading(
    luminance: Map, normals: Map, weight: Map, core: NDArray[np.bool_]
) -> tuple[Map, float]:
    """Return how much light each texel has, and how uneven the face is without it.

    Args:
        luminance: ``(S, S)`` linear, of what is seen.
        normals: ``(S, S, 3)``.
        weight: ``(S, S)``, 0 where no plain skin is seen.
        core: ``(S, S)`` where the light is 1 on average.

    Returns:
        ``(S, S)`` float32, and the standard deviation of log luminance over light on plain skin.
    """
    seen = np.flatnonzero(weight.ravel() > 0.5)
    seen = seen[:: max(1, len(seen) // _MOST_TEXELS)]
    level = float(np.median(luminance[core & (weight > 0.5)]))
    basis = _harmonics(normals.reshape(-1, 3)[seen]).astype(np.float64)
    wanted = luminance.ravel()[seen] / level
    first = weight.ravel()[seen].astype(np.float64)
    trust = np.ones(len(seen))
    for _ in range(_ROUNDS):
        each = first * trust
        ridge = np.diag(_RIDGE * each.sum())
        light = np.linalg.solve(
            (basis * each[:, None]).T @ basis + ridge, basis.T @ (each * wanted)
        )
        error = wanted - basis @ light
        spread = 1.4826 * np.median(np.abs(error)) + 1e-3
        trust = 1 / (1 + (error / (_OUTLIER * spread)) ** 2)
    shading = np.clip(_harmonics(normals) @ light.astype(np.float32), 0.25, 4.0)
    shading = np.clip(shading / shading[core].mean(), *_LIMITS).astype(np.float32)
    rest = np.log(np.maximum(wanted, 1e-4) / shading.ravel()[seen])
    return shading, float(1.4826 * np.median(np.abs(rest - np.median(rest))))
