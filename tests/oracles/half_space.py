"""Light in a half-space, photon by photon: isotropic scattering behind a smooth boundary."""

import numpy as np
from numpy.typing import NDArray

from lrsr.rendering.diffusion import scattering_albedo

INDEX = 1.4


def fresnel(cosine: NDArray, ratio: float) -> NDArray:
    """Reflectance of unpolarised light that meets a medium of ``ratio`` times its index."""
    squared_sine = (1 - cosine**2) / ratio**2
    inside = np.sqrt(np.clip(1 - squared_sine, 0, 1))
    senkrecht = (cosine - ratio * inside) / (cosine + ratio * inside)
    parallel = (ratio * cosine - inside) / (ratio * cosine + inside)
    return np.where(squared_sine >= 1, 1.0, (senkrecht**2 + parallel**2) / 2)


def pencil_beam(
    albedo: float, photons: int, seed: int, *, diffuse: bool = False
) -> tuple[NDArray, NDArray]:
    """Send a narrow beam into the half-space, perpendicular or of diffuse light.

    Returns:
        Distances at which light leaves, mean free paths, and what share of the entered light leaves
        there; the shares sum to the diffuse albedo.
    """
    rng = np.random.default_rng(seed)
    weight, cosine = np.ones(photons), np.ones(photons)
    if diffuse:
        outside = np.sqrt(rng.random(photons))
        weight = 1 - fresnel(outside, INDEX)
        cosine = np.sqrt(1 - (1 - outside**2) / INDEX**2)
    weight /= weight.sum()
    smallest = 0.05 / photons
    turn = 2 * np.pi * rng.random(photons)
    sine = np.sqrt(1 - cosine**2)
    direction = np.stack([sine * np.cos(turn), sine * np.sin(turn), cosine])
    place = np.zeros((3, photons))
    distances, shares = [], []
    while weight.size:
        step = rng.exponential(size=weight.size)
        leaves = place[2] + step * direction[2] < 0
        step[leaves] = -place[2, leaves] / direction[2, leaves]
        place += step * direction
        stays = np.where(leaves, fresnel(np.abs(direction[2]), 1 / INDEX), 1.0)
        distances.append(np.hypot(*place[:2, leaves]))
        shares.append((weight * (1 - stays))[leaves])
        weight = weight * np.where(leaves, stays, albedo)
        place[2, leaves] = 0
        direction[2, leaves] *= -1
        z, turn = rng.uniform(-1, 1, weight.size), 2 * np.pi * rng.random(weight.size)
        sine = np.sqrt(1 - z**2)
        anew = np.stack([sine * np.cos(turn), sine * np.sin(turn), z])
        direction = np.where(leaves, direction, anew)
        dim = weight < smallest
        survives = ~dim | (rng.random(weight.size) < 0.2)
        weight = np.where(dim, weight / 0.2, weight)[survives]
        place, direction = place[:, survives], direction[:, survives]
    return np.concatenate(distances), np.concatenate(shares)


def diffuse_albedo(scattering: float) -> float:
    """Return the diffuse albedo of a medium: the inverse of ``scattering_albedo``, by halving."""
    low, high = 0.0, 1.0
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if scattering_albedo(middle) < scattering else (low, middle)
    return low
