"""How does light become 8-bit numbers? The sRGB curve, then rounding to 255 steps."""

import torch

from lrsr.images import linear_to_srgb


def quantise(srgb: torch.Tensor, *, differentiable: bool = False) -> torch.Tensor:
    """Round srgb to the nearest of 256 levels.

    Args:
        srgb: Any shape, [0, 1].
        differentiable: Let the gradient through as if nothing had been rounded (straight-through
            estimator, Bengio et al. 2013, arXiv:1308.3432); the values are the same.

    Example:
        >>> (quantise(torch.tensor([0.0, 0.5, 1.0])) * 255).tolist()
        [0.0, 128.0, 255.0]
    """
    levels = (srgb * 255).round() / 255
    return levels.detach() + (srgb - srgb.detach()) if differentiable else levels


def encode(linear: torch.Tensor, *, differentiable: bool = False) -> torch.Tensor:
    """Clip linear light to [0, 1], apply the sRGB curve, quantise to 8 bits.

    Args:
        linear: Any shape, linear light, 1 = the sensor's white.
        differentiable: See :func:`quantise`; clipped pixels have no gradient in either case.
    """
    return quantise(linear_to_srgb(linear), differentiable=differentiable)
