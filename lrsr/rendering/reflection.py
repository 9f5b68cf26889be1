"""How much light does the rough surface of skin throw back before it enters?

The lobe of Mitsuba's ``principled``: microfacets of Trowbridge and Reitz (GGX) with the slope α,
separable Smith shadowing (Walter et al. 2007, "Microfacet models for refraction through rough
surfaces") and the exact Fresnel term. What it does not reflect, 1 - E(cos θ), enters.

A smooth Fresnel term would let 43 % of the light at cos θ = 0.1 in where a lobe of α = 0.35 lets
90 % in, and draw dark lines along every contour.
"""

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lrsr.rendering.backend import dr, mi

_TABLE_SIZE = 32
"""Nodes of the table along each axis."""

_MIDPOINTS = 64
_MIN_SLOPE = 1e-3
"""Smallest α, as in ``principled``."""


def _fresnel(cosine: ArrayLike, refractive_index: float) -> NDArray[np.float64]:
    """Reflectance of a smooth dielectric for unpolarised light.

    Args:
        cosine: Of the angle of incidence, any shape, [0, 1].
        refractive_index: Of the far side relative to the near one, > 0.

    Example:
        >>> round(float(_fresnel(1.0, 1.4)), 4)
        0.0278
    """
    near = np.asarray(cosine, dtype=np.float64)
    squared_sine = (1 - near**2) / refractive_index**2
    far = np.sqrt(np.clip(1 - squared_sine, 0, 1))
    perpendicular = (near - refractive_index * far) / (near + refractive_index * far)
    parallel = (refractive_index * near - far) / (refractive_index * near + far)
    return np.asarray(np.where(squared_sine >= 1, 1.0, (perpendicular**2 + parallel**2) / 2))


def _directional_albedo(cosine: ArrayLike, slope: float, refractive_index: float) -> Any:
    """Integrate the lobe over all directions of reflection: E(cos θ).

    The normals that are visible from the direction are laid out on a unit disc (Heitz 2018,
    "Sampling the GGX distribution of visible normals"), so that E is the mean of F G1 over it.

    Args:
        cosine: ``(N,)`` cosines of the angle to the normal, (0, 1].
        slope: α of the microfacets, > 0.
        refractive_index: Of the medium.

    Returns:
        ``(N,)`` float64, [0, 1].
    """
    cosine = np.asarray(cosine, dtype=np.float64)[:, None, None]
    sine = np.sqrt(1 - cosine**2)
    uniform = (np.arange(_MIDPOINTS) + 0.5) / _MIDPOINTS
    radius, angle = np.sqrt(uniform)[:, None], 2 * np.pi * uniform[None, :]
    stretched = np.sqrt((slope * sine) ** 2 + cosine**2)
    across, up = slope * sine / stretched, cosine / stretched
    first = radius * np.cos(angle)
    share = (1 + up) / 2
    second = (1 - share) * np.sqrt(1 - first**2) + share * radius * np.sin(angle)
    third = np.sqrt(np.clip(1 - first**2 - second**2, 0, 1))
    x, y, z = slope * (across * third - up * second), slope * first, across * second + up * third
    length = np.sqrt(x**2 + y**2 + z**2)
    facing = (sine * x + cosine * z) / length
    out = 2 * facing * z / length - cosine
    tangent = np.sqrt(np.clip(1 - out**2, 0, 1)) / np.where(out > 0, out, 1)
    shadowing = 2 / (1 + np.sqrt(1 + (slope * tangent) ** 2))
    lobe = np.where(out > 0, _fresnel(np.clip(facing, 0, 1), refractive_index) * shadowing, 0)
    return lobe.mean(axis=(1, 2))


@cache
def _albedo_table(refractive_index: float) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Tabulate what the lobe reflects.

    Returns:
        directional: ``(32, 32)`` float32, E; rows over roughness √α, columns over √cos θ, 0..1.
        mean: ``(32,)`` float32, 2 ∫ E(µ) µ dµ of each row.
    """
    nodes = np.linspace(0, 1, _TABLE_SIZE)
    cosines = np.clip(nodes, 0.02, 1) ** 2
    slopes = np.maximum(nodes**2, _MIN_SLOPE)
    directional = np.stack([_directional_albedo(cosines, s, refractive_index) for s in slopes])
    # Per row the integral of what the kernel interpolates: 2 ∫ E µ dµ = 4 ∫ E(t) t³ dt.
    fine = (np.arange(4096) + 0.5) / 4096
    rows = np.stack([np.interp(fine, nodes, row) for row in directional])
    mean = 4 * (rows * fine**3).mean(axis=1)
    return directional.astype(np.float32), mean.astype(np.float32)


class RoughReflection:
    """The lobe within a kernel.

    Args:
        refractive_index: Of the medium, > 1.
    """

    def __init__(self, refractive_index: float) -> None:
        self._index = dr.opaque(mi.Float, refractive_index)
        directional, mean = _albedo_table(refractive_index)
        self._directional = mi.Texture2f(mi.TensorXf(directional[..., None]))
        self._mean = mi.Texture1f(mi.TensorXf(mean[..., None]))

    def directional(self, cosine: Any, roughness: Any) -> Any:
        """Return E, what is reflected of the light along a direction."""
        column = dr.sqrt(dr.clip(cosine, 0, 1))
        return self._directional.eval(mi.Point2f(_texel(column), _texel(roughness)))[0]

    def mean(self, roughness: Any) -> Any:
        """Return what is reflected of uniform light, 2 ∫ E(µ) µ dµ."""
        return self._mean.eval(mi.Array1f(_texel(roughness)))[0]

    def eval_pdf(self, wi: Any, wo: Any, roughness: Any) -> tuple[Any, Any]:
        """Return the lobe times cos θ, and the density with which :meth:`sample` finds ``wo``.

        Args:
            wi: Local direction to the viewer.
            wo: Local direction to the light.
            roughness: √α.
        """
        half = dr.normalize(wi + wo)
        above = (wi.z > 0) & (wo.z > 0) & (half.z > 0)
        facets = _facets(roughness)
        density = facets.eval(half)
        reflected, _, _, _ = mi.fresnel(dr.dot(wi, half), self._index)
        shadowing = facets.smith_g1(wi, half)
        visible = density * shadowing / (4 * wi.z)
        value = reflected * visible * facets.smith_g1(wo, half)
        return dr.select(above, value, 0), dr.select(above, visible, 0)

    def sample(self, wi: Any, roughness: Any, uniform: Any) -> tuple[Any, Any, Any]:
        """Draw a direction.

        Args:
            wi: Local direction to the viewer.
            roughness: √α.
            uniform: Two numbers in [0, 1).

        Returns:
            The local direction, its density, and value over density (0 below the surface).
        """
        facets = _facets(roughness)
        half, _ = facets.sample(wi, uniform)
        wo = mi.reflect(wi, half)
        value, density = self.eval_pdf(wi, wo, roughness)
        return wo, density, dr.select(density > 0, value / density, 0)


def _facets(roughness: Any) -> Any:
    slope = dr.maximum(dr.square(roughness), _MIN_SLOPE)
    return mi.MicrofacetDistribution(mi.MicrofacetType.GGX, slope, sample_visible=True)


def _texel(position: Any) -> Any:
    """Place 0..1 from the centre of the first texel to that of the last."""
    return (position * (_TABLE_SIZE - 1) + 0.5) / _TABLE_SIZE
