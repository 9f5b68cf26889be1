"""What does a camera do to a picture to make it please? Denoise, sharpen, contrast, saturation.

All of it works on the sRGB curve, on luminance (BT.601, Y = 0.299 R + 0.587 G + 0.114 B) and on
the colour differences R - Y, G - Y, B - Y, as video chips do (J. Nakamura, Image Sensors and Signal
Processing for Digital Still Cameras, CRC 2006).
"""

import torch
from torch import nn

from lrsr.camera.checks import check_light, number
from lrsr.camera.smoothing import bilateral_blur, gaussian_blur
from lrsr.images import linear_to_srgb

_LUMA = (0.299, 0.587, 0.114)


class Processing(nn.Module):
    """From linear colours to the sRGB picture, before it is rounded. Every default does nothing.

    Args:
        denoise_luma_px: Width of the bilateral filter on luminance, px, 0..20.
        denoise_luma_level: Differences of level that it takes for noise, srgb, > 0.
        denoise_chroma_px: Width of the Gaussian on the colour differences, px, 0..20; more than a
            pixel bleeds colours into each other.
        sharpen_px: Width of the unsharp mask's Gaussian, px, 0..20: of the halo.
        sharpen_amount: How much of luminance minus its blur is added, 0..10.
        contrast: Slope of the tone curve at ``pivot``, 0..10: s-shaped above 1, below 1 straight,
            so that neither black nor white is reached.
        pivot: Level that contrast leaves as it is, srgb, 0..1.
        brightness: Added to every level, srgb, -1..1.
        saturation: Factor of the colour differences, 0..10.

    Raises:
        InputError: A value is out of its range.

    Example:
        >>> Processing(contrast=0.5)(torch.tensor([0.0, 1.0])[None, None, None].expand(1, 3, 1, 2))[
        ...     0, 0, 0
        ... ].tolist()
        [0.25, 0.75]
    """

    def __init__(
        self,
        *,
        denoise_luma_px: float = 0.0,
        denoise_luma_level: float = 0.05,
        denoise_chroma_px: float = 0.0,
        sharpen_px: float = 1.0,
        sharpen_amount: float = 0.0,
        contrast: float = 1.0,
        pivot: float = 0.5,
        brightness: float = 0.0,
        saturation: float = 1.0,
    ) -> None:
        super().__init__()
        self.denoise_luma_px = number("denoise_luma_px", denoise_luma_px, "0..20", low=0, high=20)
        level = number("denoise_luma_level", denoise_luma_level, "1e-06..1", low=1e-6, high=1)
        self.denoise_luma_level = level
        chroma_px = number("denoise_chroma_px", denoise_chroma_px, "0..20", low=0, high=20)
        self.denoise_chroma_px = chroma_px
        self.sharpen_px = number("sharpen_px", sharpen_px, "0..20", low=0, high=20)
        self.sharpen_amount = number("sharpen_amount", sharpen_amount, "0..10", low=0, high=10)
        self.contrast = number("contrast", contrast, "0..10", low=0, high=10)
        self.pivot = number("pivot", pivot, "0..1", low=0, high=1)
        self.brightness = number("brightness", brightness, "-1..1", low=-1, high=1)
        self.saturation = number("saturation", saturation, "0..10", low=0, high=10)

    def forward(self, linear: torch.Tensor) -> torch.Tensor:
        """Develop.

        Args:
            linear: ``(B, 3, H, W)``, linear, 1 = white; clipped to [0, 1].

        Returns:
            srgb ``(B, 3, H, W)``, [0, 1], not rounded.

        Raises:
            ImageContractError: ``linear`` is no batch of three colours.
        """
        check_light(linear)
        # The last bit of torch's float power depends on a value's place in the batch.
        srgb = linear_to_srgb(linear.double()).to(linear)
        luma = luminance(srgb)
        chroma = gaussian_blur(srgb - luma, self.denoise_chroma_px)
        luma = bilateral_blur(luma, self.denoise_luma_px, self.denoise_luma_level)
        luma = _sharpen(luma, self.sharpen_px, self.sharpen_amount)
        luma = _tone(luma, self.contrast, self.pivot) + self.brightness
        return (luma + self.saturation * chroma).clamp(0, 1)


def luminance(srgb: torch.Tensor) -> torch.Tensor:
    """Return full-range BT.601 luminance ``(B, 1, H, W)`` of srgb ``(B, 3, H, W)``.

    JPEG's and video's, before they are stored; what SRCNN works on is that of
    :func:`lrsr.images.luminance`, in studio range.

    Raises:
        ImageContractError: ``srgb`` is no batch of three colours.

    Example:
        >>> round(luminance(torch.tensor([0.0, 1.0, 0.0])[None, :, None, None]).item(), 3)
        0.587
    """
    check_light(srgb, name="srgb")
    red, green, blue = srgb.unbind(1)
    return (_LUMA[0] * red + _LUMA[1] * green + _LUMA[2] * blue)[:, None]


def _sharpen(images: torch.Tensor, sigma_px: float, amount: float) -> torch.Tensor:
    """Add ``amount`` times what a Gaussian blur takes away: an unsharp mask, with its halo.

    Args:
        images: ``(B, C, H, W)``.
        sigma_px: Width of the blur, px.
        amount: 0 changes nothing.

    Returns:
        ``(B, C, H, W)``, not clipped: beside an edge it overshoots on both sides.

    Raises:
        ImageContractError: ``images`` is no batch of images.
        InputError: ``sigma_px`` is out of range.
    """
    if amount == 0:
        return images
    return images + amount * (images - gaussian_blur(images, sigma_px))


def _tone(levels: torch.Tensor, contrast: float, pivot: float = 0.5) -> torch.Tensor:
    """Bend levels about ``pivot``: straight up to a contrast of 1, an s beyond it.

    The s has the slope ``contrast`` at the pivot and 1 / contrast near black and white, which stay
    where they are: x ↦ p + (1 - p) · t c / (1 + (c - 1) t) with t = (x - p) / (1 - p) above the
    pivot, mirrored below. Levels beyond black and white, as of halos, are clipped first.

    Example:
        >>> _tone(torch.tensor([0.0, 0.25, 0.5, 0.75, 1.0]), 2.0).mul(6).round().tolist()
        [0.0, 1.0, 3.0, 5.0, 6.0]
    """
    if contrast <= 1 or pivot in {0.0, 1.0}:
        return pivot + contrast * (levels - pivot)
    offset = levels.clamp(0, 1) - pivot
    t = torch.where(offset > 0, offset / (1 - pivot), -offset / pivot)
    return pivot + offset * contrast / (1 + (contrast - 1) * t)
