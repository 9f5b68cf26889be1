"""What would JPEG make of a picture if rounding had a slope? The stand-in for training through it.

The same steps and tables as libjpeg's (ITU-T T.81, JFIF 1.02): YCbCr, colours averaged over the
pixels that share a sample, blocks of 8 x 8 transformed by cosines, divided by the table, rounded,
and back, colours between samples interpolated linearly. Only two things differ: coefficients are
rounded softly, x to [x] + (x - [x])³ (R. Shin, D. Song, "JPEG-resistant adversarial images", 2017,
sec. 3; also in C. Reich et al. 2024, arXiv:2309.06978), and levels in between are not rounded.
"""

import math

import numpy as np
import torch
from kornia.color import rgb_to_ycbcr, ycbcr_to_rgb
from torch.nn import functional as F

from lrsr.camera.checks import check_choice, check_light, whole
from lrsr.camera.jpeg_tables import BLOCK_PX, chrominance_table, luminance_table

SHARING = {"4:4:4": (1, 1), "4:2:2": (1, 2), "4:2:0": (2, 2)}
"""(rows, columns) of pixels that share one sample of each colour."""

_MIDDLE, _GREY = 128, 127.5  # what is 0 in a block: of luminance, of colours as kornia counts them


def soft_jpeg(srgb: torch.Tensor, quality: int, chroma: str = "4:2:0") -> torch.Tensor:
    """Compress and decompress, with a gradient to every pixel.

    Args:
        srgb: ``(B, 3, H, W)``, float32 or float64, [0, 1], any H and W; blocks start at the first
            pixel, those on the right and at the bottom repeat the edge.
        quality: 1-100, of the Independent JPEG Group's scale.
        chroma: One of :data:`SHARING`.

    Returns:
        ``(B, 3, H, W)``, [0, 1], not rounded.

    Raises:
        ImageContractError: ``srgb`` is no batch of three colours.
        InputError: Unknown chroma, or the quality is out of range.

    Example:
        >>> soft_jpeg(torch.full((1, 3, 1, 1), 0.5), 50).mul(255).round().flatten().tolist()
        [128.0, 128.0, 128.0]
    """
    check_light(srgb, name="srgb")
    whole("quality", quality, "1 to 100", low=1, high=100)
    check_choice("chroma", chroma, SHARING)
    height, width = srgb.shape[-2:]
    rows, columns = SHARING[chroma]
    ends = (-width % (columns * BLOCK_PX), -height % (rows * BLOCK_PX))
    framed = F.pad(srgb, (0, ends[0], 0, ends[1]), mode="replicate")
    middle = srgb.new_tensor([_MIDDLE, _GREY, _GREY])[:, None, None]
    luma, colours = (rgb_to_ycbcr(framed) * 255 - middle).split((1, 2), 1)
    luma_steps, colour_steps = (
        torch.from_numpy(t(quality)) for t in (luminance_table, chrominance_table)
    )
    luma = _through_blocks(luma, luma_steps)
    colours = _through_blocks(F.avg_pool2d(colours, (rows, columns)), colour_steps)
    colours = colours[..., : math.ceil(height / rows), : math.ceil(width / columns)]
    colours = F.interpolate(colours, scale_factor=(rows, columns), mode="bilinear")
    planes = torch.cat([luma[..., :height, :width], colours[..., :height, :width]], 1)
    decoded: torch.Tensor = ycbcr_to_rgb((planes + middle) / 255)
    return decoded


def _through_blocks(plane: torch.Tensor, table: torch.Tensor) -> torch.Tensor:
    """Round the cosine coefficients of each block to multiples of ``table``, softly.

    Args:
        plane: ``(B, C, H, W)``, levels around 0; H and W multiples of 8.
        table: ``(8, 8)``, rows: vertical frequencies.

    Returns:
        ``(B, C, H, W)``, clipped to [-128, 127].
    """
    cosines, steps = cosine_transform().to(plane), table.to(plane)
    batch, channels, height, width = plane.shape
    down, across = height // BLOCK_PX, width // BLOCK_PX
    blocks = plane.reshape(batch, channels, down, BLOCK_PX, across, BLOCK_PX).transpose(-3, -2)
    kept = _soft_round(cosines @ blocks @ cosines.T / steps) * steps
    decoded = (cosines.T @ kept @ cosines).transpose(-3, -2).reshape(plane.shape)
    return decoded.clamp(-_MIDDLE, _MIDDLE - 1)


def cosine_transform() -> torch.Tensor:
    """Return the orthonormal DCT ``(8, 8)``, a row for each cosine.

    Example:
        >>> d = cosine_transform()
        >>> torch.allclose(d @ d.T, torch.eye(8, dtype=d.dtype))
        True
    """
    k = np.arange(BLOCK_PX)
    waves = np.cos((2 * k + 1)[None] * k[:, None] * np.pi / (2 * BLOCK_PX))
    return torch.from_numpy(waves * np.where(k[:, None] == 0, 0.5**0.5, 1.0) / 2)


def _soft_round(numbers: torch.Tensor) -> torch.Tensor:
    """Round to [x] + (x - [x])³: whole numbers stay, the slope is 0 there and 3/4 halfway.

    Example:
        >>> _soft_round(torch.tensor([2.0, 2.5, -1.2])).mul(1000).round().tolist()
        [2000.0, 2125.0, -1008.0]
    """
    whole = numbers.detach().round()
    return whole + (numbers - whole) ** 3
