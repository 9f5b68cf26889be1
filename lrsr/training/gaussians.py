"""How is each picture of a batch blurred by a Gaussian of its own, round or drawn out?"""

import math

import numpy as np
import torch
from numpy.typing import NDArray
from torch.nn import functional as F


def gaussian_kernels(
    across_px: NDArray[np.float64], along_px: NDArray[np.float64], angle: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return point spread functions ``(B, k, k)``, each of the sum 1, cut off at 3 σ.

    Args:
        across_px: ``(B,)``, standard deviation across the direction, > 0.
        along_px: ``(B,)``, along it, > 0.
        angle: ``(B,)``, the direction from x to y, radians.

    Example:
        >>> one = np.ones(1)
        >>> gaussian_kernels(one, one, 0 * one).shape
        (1, 7, 7)
    """
    across, along = across_px[:, None, None], along_px[:, None, None]
    radius = math.ceil(3 * max(across.max(), along.max()))
    y, x = np.mgrid[-radius : radius + 1, -radius : radius + 1]
    cosine, sine = np.cos(angle)[:, None, None], np.sin(angle)[:, None, None]
    squared = ((cosine * x + sine * y) / along) ** 2 + ((cosine * y - sine * x) / across) ** 2
    kernels: NDArray[np.float64] = np.exp(-0.5 * squared)
    kernels /= kernels.sum(axis=(1, 2), keepdims=True)
    return kernels


def filter_each(images: torch.Tensor, kernels: NDArray[np.float64]) -> torch.Tensor:
    """Filter each of ``(B, C, H, W)`` with its kernel ``(B, k, k)``; the edge is repeated."""
    count, channels = images.shape[:2]
    radius = kernels.shape[-1] // 2
    padded = F.pad(images, (radius, radius, radius, radius), mode="replicate")
    weights = torch.from_numpy(kernels).to(images).repeat_interleave(channels, dim=0)[:, None]
    flat = padded.reshape(1, count * channels, *padded.shape[-2:])
    return F.conv2d(flat, weights, groups=count * channels).reshape(images.shape)
