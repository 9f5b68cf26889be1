"""How are neighbouring pixels averaged? By a Gaussian, or by one that spares edges.

The sums are written out: a convolution's algorithm, and with it the last bits of a picture, would
change with the size of the batch.
"""

import math

import torch
from torch.nn import functional as F

from lrsr.camera.checks import check_light, number

_WIDTHS = "0..20 pixels"


def gaussian_blur(images: torch.Tensor, sigma_px: float) -> torch.Tensor:
    """Average with a Gaussian cut off at 3 σ; the edge is repeated outwards.

    Args:
        images: ``(B, C, H, W)``, any number of channels.
        sigma_px: Standard deviation, px, 0..20; 0 changes nothing.

    Returns:
        ``(B, C, H, W)``; the mean of an image is kept but for what lies at its border.

    Raises:
        ImageContractError: ``images`` is no batch of images.
        InputError: ``sigma_px`` is out of range.

    Example:
        >>> spot = torch.tensor([[[[0.0, 0, 0, 1, 0, 0, 0]]]])
        >>> [round(value, 2) for value in gaussian_blur(spot, 0.5)[0, 0, 0].tolist()]
        [0.0, 0.0, 0.11, 0.79, 0.11, 0.0, 0.0]
    """
    check_light(images, channels=range(1, images.shape[1] + 1 if images.ndim > 1 else 1))
    number("sigma_px", sigma_px, _WIDTHS, low=0, high=20)
    if sigma_px == 0:
        return images
    radius = math.ceil(3 * sigma_px)
    weights = [math.exp(-0.5 * (i / sigma_px) ** 2) for i in range(-radius, radius + 1)]
    blurred = images
    for axis in (-1, -2):
        padding = (radius, radius, 0, 0) if axis == -1 else (0, 0, radius, radius)
        padded, size = F.pad(blurred, padding, mode="replicate"), blurred.shape[axis]
        total = torch.zeros_like(blurred)
        for i, weight in enumerate(weights):
            total = total + weight / sum(weights) * padded.narrow(axis, i, size)
        blurred = total
    return blurred


def bilateral_blur(images: torch.Tensor, sigma_px: float, sigma_level: float) -> torch.Tensor:
    """Average with those neighbours that are alike (C. Tomasi, R. Manduchi, ICCV 1998, eq. 5).

    Args:
        images: ``(B, 1, H, W)``.
        sigma_px: Of the Gaussian over distance, px, 0..20, cut off at 2 σ; 0 changes nothing.
        sigma_level: Of the Gaussian over differences of level, > 0, in the unit of ``images``.

    Returns:
        ``(B, 1, H, W)``.

    Raises:
        ImageContractError: ``images`` is no batch of one channel.
        InputError: A width is out of range.
    """
    check_light(images, channels=(1,), name="images")
    number("sigma_px", sigma_px, _WIDTHS, low=0, high=20)
    number("sigma_level", sigma_level, "a level > 0", above=0)
    if sigma_px == 0:
        return images
    radius = math.ceil(2 * sigma_px)
    padded = F.pad(images, (radius, radius, radius, radius), mode="replicate")
    height, width = images.shape[-2:]
    total, weights = torch.zeros_like(images), torch.zeros_like(images)
    for dy in range(2 * radius + 1):
        for dx in range(2 * radius + 1):
            near = ((dx - radius) ** 2 + (dy - radius) ** 2) / sigma_px**2
            neighbour = padded[..., dy : dy + height, dx : dx + width]
            unlike = ((neighbour - images) / sigma_level).square()
            weight = torch.exp(-0.5 * (near + unlike))
            total, weights = total + weight * neighbour, weights + weight
    return total / weights
