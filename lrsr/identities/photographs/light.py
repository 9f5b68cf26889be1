"""How was a face lit? Spherical _harmonics of second order, read from plain skin.

A convex matte surface answers any distant light by its first nine _harmonics (Ramamoorthi and
Hanrahan, "On the relationship between radiance and irradiance", JOSA A 18, 2001). Highlights and
cast shadows are none, so the fit is robust. Lamps of several colours, light from cheek to cheek and
the photograph's tone curve let the hue depend on the same harmonics, and on how bright skin is.
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
_TONES = (-1.2, 0.8)
"""Logarithms of brightness, the core's being 0, between which hue follows it."""
_TONE_RIDGE = 0.01
_USUAL_CAST = 0.12
"""Root mean square of what blushes and usual tone curves come to: 0.06 to 0.11 on 5 photographs of
well balanced light, 0.27 to 0.34 on 4 with patches of colour. Only what exceeds it is cast."""
_CAST_LIMITS = (-0.7, 0.7)
_LEAST_HUE_SPREAD = 0.02


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


def estimate_cast(hue: Map, tone: Map, normals: Map, weight: Map, core: NDArray[np.bool_]) -> Map:
    """Return how much redder and bluer than on the core the light is on each texel; 0 if usual.

    Args:
        hue: ``(S, S, 2)`` logarithms of red and of blue over green, of what is seen.
        tone: ``(S, S)`` logarithm of its brightness, smooth: spots are no light.
        normals: ``(S, S, 3)``.
        weight: ``(S, S)``, 0 where no plain skin is seen.
        core: ``(S, S)`` where the cast is 0 on average.

    Returns:
        ``(S, S, 2)`` float32.
    """
    sure = weight > 0.5
    tone = np.clip(tone - np.median(tone[core & sure]), *_TONES)
    basis = np.concatenate([_harmonics(normals), tone[..., None]], axis=-1)
    seen = np.flatnonzero(sure.ravel())
    seen = seen[:: max(1, len(seen) // _MOST_TEXELS)]
    rows = basis.reshape(-1, basis.shape[-1])[seen].astype(np.float64)
    wanted = hue.reshape(-1, 2)[seen].astype(np.float64)
    wanted -= np.median(hue[core & sure], axis=0)
    first = weight.ravel()[seen].astype(np.float64)
    trust: _Floats = np.ones(len(seen))
    cast: _Floats = np.zeros((rows.shape[1], 2))
    ridge = np.append(_RIDGE, _TONE_RIDGE)
    for _ in range(_ROUNDS):
        each = first * trust
        weighted = rows * each[:, None]
        pull = np.diag(ridge * each.sum())
        cast = np.asarray(np.linalg.solve(weighted.T @ rows + pull, weighted.T @ wanted))
        error = np.linalg.norm(wanted - rows @ cast, axis=1)
        spread = _OUTLIER * (np.median(error) + _LEAST_HUE_SPREAD)
        trust = np.asarray(1 / (1 + (error / spread) ** 2), np.float64)
    found = basis @ cast.astype(np.float32)
    found = np.clip(found - found[core & sure].mean(axis=0), *_CAST_LIMITS)
    share = 1 - _USUAL_CAST**2 / max(float((found[sure] ** 2).mean()), _USUAL_CAST**2)
    return np.asarray(share * found, np.float32)
