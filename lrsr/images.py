"""What is an image here? The contract, stated once; each line has a test.

- ``(B, C, H, W)`` float32 torch, RGB; one image is ``(C, H, W)`` only in a dataclass that says so.
- ``linear`` until the sensor, ``srgb`` after it, never unnamed; srgb lies in [0, 1], and what lies
  elsewhere is refused, not rescaled.
- Pixel (0, 0) is the top-left; a point's coordinate is 0 at the centre of pixel (0, 0), so on a
  film s times finer x' = s (x + 0.5) - 0.5.
- Nothing is inferred from the values: range, channel order and colour space are arguments.
- Luminance is BT.601 in studio range, (16 + 65.481 R + 128.553 G + 24.966 B) / 255, as in MATLAB's
  ``rgb2ycbcr`` and in every published SRCNN figure.
- There is one bicubic, :func:`resize_bicubic`: a = -0.5, antialiased when shrinking, as in MATLAB's
  ``imresize``.
"""

from fractions import Fraction
from math import ceil, isfinite

import torch
from torch.nn import functional as F

from lrsr.configuration import as_number
from lrsr.errors import ImageContractError, InputError, NonFiniteError

_RANGE_TOLERANCE = 1e-5
"""How far float32 arithmetic may have carried an srgb value out of [0, 1]."""

_YCBCR = torch.tensor(
    [[65.481, 128.553, 24.966], [-37.797, -74.203, 112.0], [112.0, -93.786, -18.214]],
    dtype=torch.float64,
)
_YCBCR_OFFSET = torch.tensor([16.0, 128.0, 128.0], dtype=torch.float64)


def check_images(images: torch.Tensor, *, channels: int = 3, name: str = "images") -> torch.Tensor:
    """Return ``images`` unchanged if they are ``(B, channels, H, W)`` float32 and finite.

    Raises:
        ImageContractError: No tensor, a sparse one or one without values, wrong number of
            dimensions or channels, an empty side, or another dtype.
        NonFiniteError: A NaN or an infinity; the message says where the first one is.
    """
    if not isinstance(images, torch.Tensor):
        raise ImageContractError(f"{name}: got {type(images).__name__}, wanted a torch.Tensor")
    shape, dtype = tuple(images.shape), images.dtype
    if images.layout != torch.strided or images.is_meta:
        raise ImageContractError(f"{name}: got a tensor without plain values; give .to_dense()")
    if len(shape) != 4 or shape[1] != channels or 0 in shape:
        raise ImageContractError(f"{name}: got shape {shape}, wanted (B, {channels}, H, W)")
    if dtype != torch.float32:
        raise ImageContractError(f"{name}: got {dtype}, wanted torch.float32")
    if not all(map(isfinite, _extremes(images))):
        b, c, y, x = (~torch.isfinite(images)).nonzero()[0].tolist()
        raise NonFiniteError(f"{name}: {images[b, c, y, x]} in image {b}, channel {c}, ({x}, {y})")
    return images


def check_srgb(
    srgb: torch.Tensor, *, name: str = "srgb", may_need_gradient: bool = False
) -> torch.Tensor:
    """Return finished pictures unchanged: :func:`check_images`, in [0, 1], and no gradient.

    Args:
        srgb: ``(B, 3, H, W)``.
        name: For the message.
        may_need_gradient: Whoever asks says in its own words that none is kept.

    Raises:
        ImageContractError: The contract is broken, a value lies more than 1e-5 outside [0, 1], or
            the pictures need a gradient.
        NonFiniteError: A NaN or an infinity.

    Example:
        >>> check_srgb(torch.full((1, 3, 2, 2), 255.0))
        Traceback (most recent call last):
        lrsr.errors.ImageContractError: srgb: got values 255 to 255, wanted [0, 1]; rescale first
    """
    low, high = _extremes(check_images(srgb, name=name))
    if low < -_RANGE_TOLERANCE or high > 1 + _RANGE_TOLERANCE:
        raise ImageContractError(
            f"{name}: got values {low:.6g} to {high:.6g}, wanted [0, 1]; rescale first"
        )
    if srgb.requires_grad and not may_need_gradient:
        raise ImageContractError(
            f"{name}: got a tensor that needs a gradient, wanted plain values in [0, 1];"
            " give its .detach()"
        )
    return srgb


def _extremes(images: torch.Tensor) -> tuple[float, float]:
    """Return least and largest value; a NaN anywhere makes both NaN."""
    low, high = torch.aminmax(images.detach())
    return float(low), float(high)


def linear_to_srgb(linear: torch.Tensor) -> torch.Tensor:
    """Encode linear light with the sRGB curve (IEC 61966-2-1), clipping to [0, 1] first.

    Args:
        linear: Any shape, linear light, 1 = white.

    Example:
        >>> round(float(linear_to_srgb(torch.tensor(0.18))), 4)
        0.4614
    """
    x = linear.clamp(0.0, 1.0)
    return torch.where(
        x <= 0.0031308, 12.92 * x, 1.055 * x.clamp_min(0.0031308) ** (1 / 2.4) - 0.055
    )


def srgb_to_linear(srgb: torch.Tensor) -> torch.Tensor:
    """Decode the sRGB curve (IEC 61966-2-1).

    Args:
        srgb: Any shape, [0, 1].

    Example:
        >>> round(float(srgb_to_linear(torch.tensor(0.5))), 4)
        0.214
    """
    return torch.where(
        srgb <= 0.04045, srgb / 12.92, ((srgb.clamp_min(0.04045) + 0.055) / 1.055) ** 2.4
    )


def rgb_to_ycbcr(srgb: torch.Tensor) -> torch.Tensor:
    """Turn srgb ``(B, 3, H, W)`` in [0, 1] into studio-range BT.601 YCbCr, /255, same shape.

    Raises:
        ImageContractError: The images break the contract.

    Example:
        >>> rgb_to_ycbcr(torch.ones(1, 3, 1, 1)).mul(255).round().flatten().tolist()
        [235.0, 128.0, 128.0]
    """
    check_images(srgb)
    matrix = (_YCBCR / 255).to(srgb)
    offset = (_YCBCR_OFFSET / 255).to(srgb)
    return torch.einsum("dc,bchw->bdhw", matrix, srgb) + offset[:, None, None]


def ycbcr_to_rgb(ycbcr: torch.Tensor) -> torch.Tensor:
    """Invert :func:`rgb_to_ycbcr`; the result may leave [0, 1] and is not clipped.

    Raises:
        ImageContractError: The images break the contract.
    """
    check_images(ycbcr, name="ycbcr")
    inverse = torch.linalg.inv(_YCBCR / 255).to(ycbcr)
    offset = (_YCBCR_OFFSET / 255).to(ycbcr)
    return torch.einsum("dc,bchw->bdhw", inverse, ycbcr - offset[:, None, None])


def luminance(srgb: torch.Tensor) -> torch.Tensor:
    """Return the studio-range BT.601 luminance ``(B, 1, H, W)`` of srgb ``(B, 3, H, W)``.

    Raises:
        ImageContractError: The images break the contract.
    """
    return rgb_to_ycbcr(srgb)[:, :1]


def scale_points(points: torch.Tensor, scale: float) -> torch.Tensor:
    """Move points ``(..., 2)`` onto a film ``scale`` times finer: x' = s (x + 0.5) - 0.5.

    Example:
        >>> scale_points(torch.tensor([0.0, 1.0]), 2).tolist()
        [0.5, 2.5]
    """
    return as_number(scale, "scale") * (points + 0.5) - 0.5


def resize_bicubic(images: torch.Tensor, scale: float) -> torch.Tensor:
    """Resize by Keys' cubic convolution, a = -0.5, antialiased when shrinking; edges replicate.

    The kernel of MATLAB's ``imresize`` and of torch's ``interpolate(mode="bicubic",
    antialias=True)``; at the border it sees the edge pixel repeated, where torch alone would cut
    the kernel off. The result may leave the range of the input and is not
    clipped (R. Keys, 1981, doi:10.1109/TASSP.1981.1163711, eq. 15).

    Args:
        images: ``(B, C, H, W)`` float32, any colour space.
        scale: New size over old, > 0; ``scale * H`` and ``scale * W`` must be whole numbers.

    Returns:
        ``(B, C, scale * H, scale * W)`` float32; points move by :func:`scale_points`.

    Raises:
        ImageContractError: The images break the contract, or the new size is not whole.

    Example:
        >>> resize_bicubic(torch.tensor([[[[0.0, 1.0]]]]), 2).mul(1000).round()[0, 0, 0].tolist()
        [-70.0, 203.0, 797.0, 1070.0]
    """
    check_images(images, channels=images.shape[1] if getattr(images, "ndim", 0) == 4 else 3)
    try:
        ratio = Fraction(as_number(scale, "scale")).limit_denominator(1000)
    except InputError as error:
        raise ImageContractError(str(error)) from error
    height, width = (size * ratio for size in images.shape[-2:])
    if ratio <= 0 or height.denominator != 1 or width.denominator != 1:
        raise ImageContractError(
            f"scale {scale} of {images.shape[-2]}x{images.shape[-1]} pixels is not a whole size"
        )
    pad = ceil(2 / min(ratio, Fraction(1)) / ratio.denominator) * ratio.denominator
    edge = int(pad * ratio)
    padded = F.pad(images, (pad, pad, pad, pad), mode="replicate")
    resized = F.interpolate(
        padded,
        size=(int(height) + 2 * edge, int(width) + 2 * edge),
        mode="bicubic",
        antialias=True,
        align_corners=False,
    )
    return resized[..., edge:-edge, edge:-edge].contiguous()
