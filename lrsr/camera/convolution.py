"""How does each colour of a picture spread? Convolution with one kernel per colour, by FFT."""

import torch
from scipy.fft import next_fast_len
from torch.nn import functional as F

from lrsr.errors import ImageContractError

_CHUNK = 8
"""Images convolved at a time: their spectra stay in the caches."""


def convolve(images: torch.Tensor, kernels: torch.Tensor) -> torch.Tensor:
    """Let every point of light become a kernel; beyond the border the edge pixel repeats.

    A flat picture stays flat up to the border, since nothing dark comes in from outside.

    Args:
        images: ``(B, C, H, W)``, linear light, float32 or float64, any H and W >= 1.
        kernels: ``(N, C, K, K)``, sum 1, K odd; N is 1 (the same for all images) or B.

    Returns:
        ``(B, C, H, W)``.

    Raises:
        ImageContractError: The kernels do not fit the images.

    Example:
        >>> point = torch.zeros(1, 1, 3, 3)
        >>> point[..., 1, 1] = 1.0
        >>> shift_right = torch.tensor([[[[0.0, 0, 0], [0, 0, 1], [0, 0, 0]]]])
        >>> convolve(point, shift_right)[0, 0, 1].argmax().item()
        2
    """
    count, channels, height, width = kernels.shape
    if count not in (1, len(images)) or channels != images.shape[1]:
        raise ImageContractError(
            f"kernels: got {tuple(kernels.shape)} for images {tuple(images.shape)}, wanted one or "
            "one for each image, of as many channels"
        )
    if height != width or height % 2 == 0:
        raise ImageContractError(f"kernels: got {height}x{width}, wanted a square of odd side")
    height, width = images.shape[-2:]
    reach = kernels.shape[-1] // 2
    # What wraps round falls into the first 2 * reach rows and columns, which are cut off.
    size = [next_fast_len(length + 2 * reach, real=True) for length in (height, width)]
    alike = torch.fft.rfft2(kernels, s=size) if count == 1 else None
    parts = []
    for start in range(0, len(images), _CHUNK):
        few = slice(start, start + _CHUNK)
        padded = F.pad(images[few], (reach, reach, reach, reach), mode="replicate")
        transfer = torch.fft.rfft2(kernels[few], s=size) if alike is None else alike
        spread = torch.fft.irfft2(torch.fft.rfft2(padded, s=size) * transfer, s=size)
        parts.append(spread[..., 2 * reach : 2 * reach + height, 2 * reach : 2 * reach + width])
    return torch.cat(parts)
