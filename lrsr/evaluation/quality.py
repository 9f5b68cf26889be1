"""How close is an upscaled image to the true one? Luminance PSNR and SSIM by the field's protocol.

Luminance is BT.601 in studio range (16 to 235 of 255), as in MATLAB's ``rgb2ycbcr``; ``shave``
pixels, usually the scale, are cut from each side; the peak is 1. Full range reads 1.3 dB lower, RGB
1.8 dB lower: the protocol moves the figure more than the method does. Values stay floating point:
the 8-bit quantisation is the camera's affair and has happened, or not, before.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import correlate1d

from lrsr.errors import ImageContractError

Floats = NDArray[np.float64]

_STUDIO = np.array([65.481, 128.553, 24.966]) / 255
_SSIM_SIGMA, _SSIM_RADIUS = 1.5, 5


def luminance(srgb: ArrayLike) -> Floats:
    """Return the studio-range BT.601 luminance of srgb images.

    Args:
        srgb: ``(..., 3, H, W)`` srgb, [0, 1].

    Returns:
        ``(..., H, W)`` float64, 16/255 for black to 235/255 for white.

    Raises:
        ImageContractError: Not three channels, an empty side, or a NaN or an infinity.

    Example:
        >>> (luminance(np.ones((3, 1, 1))) * 255).round(6).tolist()
        [[235.0]]
    """
    images = np.asarray(srgb, dtype=np.float64)
    if images.ndim not in (3, 4) or images.shape[-3] != 3 or images.size == 0:
        raise ImageContractError(f"got shape {images.shape}, wanted (3, H, W) or (B, 3, H, W)")
    if not np.isfinite(images).all():
        raise ImageContractError("the image holds a NaN or an infinity; wanted srgb in [0, 1]")
    return np.tensordot(images, _STUDIO, axes=([-3], [0])) + 16 / 255


def psnr_y(srgb_a: ArrayLike, srgb_b: ArrayLike, shave: int) -> Floats:
    """Measure the peak signal-to-noise ratio of luminance.

    Args:
        srgb_a: ``(3, H, W)`` or ``(B, 3, H, W)`` srgb, [0, 1].
        srgb_b: The same shape.
        shave: Pixels cut from each side, usually the scale, >= 0.

    Returns:
        Decibels, shape ``()`` or ``(B,)``: a value per image (average these, not the errors);
        infinite where the images are equal.

    Raises:
        ImageContractError: The shapes differ or are no srgb images, or nothing is left to compare.

    Example:
        >>> black, grey = np.zeros((3, 4, 4)), np.full((3, 4, 4), 0.1)
        >>> round(float(psnr_y(black, grey, shave=1)), 3)     # 20 log10(255 / 21.9)
        21.322
    """
    a, b = _shaved(srgb_a, srgb_b, shave)
    with np.errstate(divide="ignore"):
        return np.asarray(-10 * np.log10(((a - b) ** 2).mean(axis=(-2, -1))))


def ssim_y(srgb_a: ArrayLike, srgb_b: ArrayLike, shave: int) -> Floats:
    """Measure the structural similarity of luminance (Wang et al., IEEE TIP 13, 2004).

    The authors' settings: Gaussian window of sigma 1.5 cut at 11 × 11, K1 = 0.01, K2 = 0.03,
    population moments, averaged over the pixels whose window lies inside the shaved image.

    Args:
        srgb_a: ``(3, H, W)`` or ``(B, 3, H, W)`` srgb, [0, 1].
        srgb_b: The same shape.
        shave: Pixels cut from each side, usually the scale, >= 0.

    Returns:
        Shape ``()`` or ``(B,)``, at most 1.

    Raises:
        ImageContractError: As :func:`psnr_y`, or less than 11 × 11 pixels left.
    """
    a, b = _shaved(srgb_a, srgb_b, shave)
    if min(a.shape[-2:]) < 2 * _SSIM_RADIUS + 1:
        raise ImageContractError(f"{a.shape[-2:]} pixels left after shaving: SSIM wants 11 × 11")
    mean_a, mean_b = _smooth(a), _smooth(b)
    var_a, var_b = _smooth(a * a) - mean_a**2, _smooth(b * b) - mean_b**2
    covariance = _smooth(a * b) - mean_a * mean_b
    c1, c2 = 0.01**2, 0.03**2
    similarity = (2 * mean_a * mean_b + c1) * (2 * covariance + c2)
    similarity /= (mean_a**2 + mean_b**2 + c1) * (var_a + var_b + c2)
    inside = slice(_SSIM_RADIUS, -_SSIM_RADIUS)
    return np.asarray(similarity[..., inside, inside].mean(axis=(-2, -1)))


def _shaved(srgb_a: ArrayLike, srgb_b: ArrayLike, shave: int) -> tuple[Floats, Floats]:
    a, b = luminance(srgb_a), luminance(srgb_b)
    if a.shape != b.shape:
        raise ImageContractError(f"got images of {a.shape} and {b.shape}, wanted one shape")
    if shave < 0 or 2 * shave >= min(a.shape[-2:]):
        raise ImageContractError(f"shave {shave} leaves nothing of {a.shape[-2:]} pixels")
    height, width = a.shape[-2:]
    inside = (..., slice(shave, height - shave), slice(shave, width - shave))
    return a[inside], b[inside]


def _smooth(images: Floats) -> Floats:
    offsets = np.arange(-_SSIM_RADIUS, _SSIM_RADIUS + 1)
    window = np.exp(-0.5 * (offsets / _SSIM_SIGMA) ** 2)
    window /= window.sum()
    rows: Floats = correlate1d(images, window, axis=-2)
    smooth: Floats = correlate1d(rows, window, axis=-1)
    return smooth
