"""How near is a restored luminance to the true one, by the protocol of published SRCNN figures?

Studio-range BT.601 luminance, peak 255, a border of ``scale`` pixels left out, one figure an image.
"""

import torch

from lrsr.errors import ImageContractError


def psnr_y_db(restored: torch.Tensor, target: torch.Tensor, *, shave_px: int) -> torch.Tensor:
    """Measure the peak signal-to-noise ratio of each luminance image.

    Args:
        restored: (B, 1, H, W), studio luminance / 255; clipped to [0, 1] here, as 8 bits would.
        target: (B, 1, H, W), the true luminance.
        shave_px: Pixels left out on each side; the field leaves out the scale.

    Returns:
        (B,) in dB; infinite where the images are equal.

    Raises:
        ImageContractError: The shapes differ, or nothing is left inside the border.

    Example:
        >>> flat = torch.full((1, 1, 8, 8), 0.5)
        >>> psnr_y_db(flat + 0.1, flat, shave_px=2).round().tolist()
        [20.0]
    """
    if restored.shape != target.shape:
        raise ImageContractError(
            f"restored is {tuple(restored.shape)}, wanted the target's {tuple(target.shape)}"
        )
    height, width = target.shape[-2:]
    if min(height, width) <= 2 * shave_px:
        raise ImageContractError(
            f"{height}x{width} pixels leave nothing inside a border of {shave_px}"
        )
    inside = (..., slice(shave_px, height - shave_px), slice(shave_px, width - shave_px))
    error = (restored.clamp(0.0, 1.0) - target)[inside].double()
    return -10.0 * error.square().mean(dim=(1, 2, 3)).log10()
