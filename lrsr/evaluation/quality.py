"""How close is an upscaled image to the true one? Luminance PSNR and SSIM by the field's protocol.

Luminance is BT.601 in studio range (16 to 235 of 255), as in MATLAB's ``rgb2ycbcr``; ``shave``
pixels, usually the scale, are cut from each side; the peak is 1. Full range reads 1.3 dB lower, RGB
1.8 dB lower: the protocol moves the figure more than the method does. Values stay floating point:
the 8-bit quantisation is the camera's affair and has happened, or not, before.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import gaussian_filter

from lrsr.errors import ImageContractError
from lrsr.evaluation.arrays import plain_array, plain_number

_Floats = NDArray[np.float64]

_STUDIO = np.array([65.481, 128.553, 24.966]) / 255
_WANTED = "floating point srgb in [0, 1]: divide 8-bit values by 255, map -1..1 by (x + 1) / 2"
_ROUNDING = 1e-6
"""What a conversion in float32 may leave beyond 0 and 1."""
_REACH = 5
"""Of a window of SSIM, px to each side of its middle."""
_SSIM = (0.01**2, 0.03**2)
"""C1 and C2 of SSIM, of a peak of 1."""


def _luminance(srgb: ArrayLike) -> _Floats:
    """Return the studio-range BT.601 luminance of srgb images.

    Args:
        srgb: ``(3, H, W)`` or ``(B, 3, H, W)`` srgb, floating point, [0, 1]; an array, a tensor or
            a list. The range is never guessed: integers and values outside are refused.

    Returns:
        ``(H, W)`` or ``(B, H, W)`` float64, 16/255 for black to 235/255 for white.

    Raises:
        ImageContractError: Not three channels, an empty side, another dtype than floating point,
            a masked value, a NaN, or a value outside [0, 1].

    Example:
        >>> (_luminance(np.ones((3, 1, 1))) * 255).round(6).tolist()
        [[235.0]]
    """
    images = plain_array(srgb, "images", kinds="f", wanted=_WANTED, error=ImageContractError)
    if images.ndim not in (3, 4) or images.shape[-3] != 3 or images.size == 0:
        raise ImageContractError(f"got shape {images.shape}, wanted (3, H, W) or (B, 3, H, W)")
    if not np.isfinite(images).all():
        raise ImageContractError("the image holds a NaN or an infinity; wanted srgb in [0, 1]")
    least, most = float(images.min()), float(images.max())
    if least < -_ROUNDING or most > 1 + _ROUNDING:
        raise ImageContractError(f"got values from {least:.6g} to {most:.6g}, wanted {_WANTED}")
    return np.tensordot(images.astype(np.float64), _STUDIO, axes=([-3], [0])) + 16 / 255


def psnr_y(srgb_a: ArrayLike, srgb_b: ArrayLike, shave: int) -> _Floats:
    """Measure the peak signal-to-noise ratio of luminance.

    Args:
        srgb_a: ``(3, H, W)`` or ``(B, 3, H, W)`` srgb; see ``_luminance``.
        srgb_b: The same shape.
        shave: Pixels cut from each side, usually the scale, >= 0.

    Returns:
        Decibels, shape ``()`` or ``(B,)``: a value per image (average these, not the errors);
        infinite where the images are equal.

    Raises:
        ImageContractError: The shapes differ or are no srgb images in [0, 1], or nothing is left to
            compare.

    Example:
        >>> black, grey = np.zeros((3, 4, 4)), np.full((3, 4, 4), 0.1)
        >>> round(float(psnr_y(black, grey, shave=1)), 3)     # 20 log10(255 / 21.9)
        21.322
    """
    a, b = _shaved(srgb_a, srgb_b, shave)
    with np.errstate(divide="ignore"):
        return np.asarray(-10 * np.log10(((a - b) ** 2).mean(axis=(-2, -1))))


def ssim_y(srgb_a: ArrayLike, srgb_b: ArrayLike, shave: int) -> _Floats:
    """Measure the structural similarity of luminance.

    Wang, Bovik, Sheikh and Simoncelli, *Image quality assessment: from error visibility to
    structural similarity* (2004), equation 13 with its constants: Gaussian windows of 11×11, σ 1.5,
    K = 0.01 and 0.03 of the peak; windows that lie inside the shaved image alone are averaged.

    Args:
        srgb_a: ``(3, H, W)`` or ``(B, 3, H, W)`` srgb; see ``_luminance``.
        srgb_b: The same shape.
        shave: Pixels cut from each side, usually the scale, >= 0.

    Returns:
        -1 to 1, shape ``()`` or ``(B,)``; 1 where the images are equal; NaN where fewer than 11
        pixels are left to a side, which hold no window.

    Raises:
        ImageContractError: See :func:`psnr_y`.

    Example:
        >>> black, white = np.zeros((3, 16, 16)), np.ones((3, 16, 16))
        >>> round(float(ssim_y(black, white, shave=2)), 4)   # (2·16·235 + 2.55²) / (16² + 235² + …)
        0.1356
    """
    a, b = _shaved(srgb_a, srgb_b, shave)
    if min(a.shape[-2:]) < 2 * _REACH + 1:
        return np.full(a.shape[:-2], np.nan)
    mean_a, mean_b = _windowed(a), _windowed(b)
    variances = _windowed(a**2 + b**2) - mean_a**2 - mean_b**2
    covariance = _windowed(a * b) - mean_a * mean_b
    light = (2 * mean_a * mean_b + _SSIM[0]) / (mean_a**2 + mean_b**2 + _SSIM[0])
    structure = (2 * covariance + _SSIM[1]) / (variances + _SSIM[1])
    return np.asarray((light * structure).mean(axis=(-2, -1)))


def _windowed(images: _Floats) -> _Floats:
    """Return the Gaussian mean of each window that lies inside, ``(..., H - 10, W - 10)``."""
    blurred = gaussian_filter(images, 1.5, radius=_REACH, axes=(-2, -1))
    inside: _Floats = blurred[..., _REACH:-_REACH, _REACH:-_REACH]
    return inside


def _shaved(srgb_a: ArrayLike, srgb_b: ArrayLike, shave: int) -> tuple[_Floats, _Floats]:
    """Return the luminance of both without their edges.

    Raises:
        ImageContractError: See :func:`psnr_y`.
    """
    a, b = _luminance(srgb_a), _luminance(srgb_b)
    if a.shape != b.shape:
        raise ImageContractError(f"got images of {a.shape} and {b.shape}, wanted one shape")
    height, width = a.shape[-2:]
    edge = plain_number(shave, "shave", error=ImageContractError)
    if edge < 0 or 2 * edge >= min(height, width) or edge % 1:
        raise ImageContractError(f"shave {shave} leaves nothing of {a.shape[-2:]} pixels")
    rows, columns = (slice(int(edge), size - int(edge)) for size in (height, width))
    return a[..., rows, columns], b[..., rows, columns]
