"""What does compression leave of a picture? JPEG: the real codec, and one with a gradient.

JPEG cuts a frame into blocks of 8 × 8 from its top left corner; a face within the frame is cut
where the frame's grid falls, which ``origin_px`` says. Motion JPEG is this, frame by frame, with
4:2:2.

The real one is OpenCV's (libjpeg-turbo): what a file would hold. The differentiable one
(:mod:`lrsr.camera.soft_jpeg`) has the same steps and tables with a soft rounding. docs/camera.md
says how far apart the two are: on rendered faces 42-46 dB at qualities of 20 to 95, where the file
is 28-41 dB from its original. Little of that is the softness: libjpeg rounds levels in between, and
the rare coefficient that this tips over to the next step weighs as much.
"""

from collections.abc import Iterable, Sequence

import cv2
import numpy as np
import torch
from torch import nn
from torch.nn import functional as F

from lrsr.camera.checks import check_choice, check_origin, check_setting, check_srgb, whole
from lrsr.camera.encoding import quantise
from lrsr.camera.soft_jpeg import soft_jpeg
from lrsr.images import check_images

COMPRESSIONS: dict[str, int | None] = {"none": None, "small": 75, "heavy": 15}
"""Qualities on the Independent JPEG Group's scale, 1-100; None: not compressed. They are
**estimated**: 75 is that group's default and what cameras call little compression; 15 is near the
lower end of what surveillance recorders offer, where the 8 x 8 blocks show."""

_CHROMAS = {
    "4:4:4": cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444,
    "4:2:2": cv2.IMWRITE_JPEG_SAMPLING_FACTOR_422,
    "4:2:0": cv2.IMWRITE_JPEG_SAMPLING_FACTOR_420,
}
"""Samples of colour: as many as of luminance, half as many in a row, or also half as many rows."""

_MACROBLOCK_PX = 16
"""At 4:2:0 an 8 × 8 block of colour covers 16 × 16 pixels; the grid repeats with that."""


def jpeg(
    srgb: torch.Tensor, quality: int, *, chroma: str = "4:2:0", origin_px: tuple[int, int] = (0, 0)
) -> torch.Tensor:
    """Encode each image with OpenCV's JPEG and decode it again; there is no gradient.

    Args:
        srgb: ``(B, 3, H, W)`` float32, [0, 1]; rounded to 8 bits first.
        quality: 1-100.
        chroma: One of ``_CHROMAS``.
        origin_px: ``(x, y)`` of the first pixel in the frame whose grid of blocks it is cut by;
            of what lies around it the edge is repeated.

    Returns:
        ``(B, 3, H, W)`` float32, [0, 1], multiples of 1/255, on the device of ``srgb``.

    Raises:
        ImageContractError: The images break the contract.
        InputError: Unknown chroma, or a place or a quality out of range.
    """
    check_images(check_srgb(srgb), name="srgb")
    check_choice("chroma", chroma, _CHROMAS)
    framed, left, top = _framed(srgb, quality, origin_px)
    pixels = framed.detach().mul(255).round().to(torch.uint8)
    rows = pixels.permute(0, 2, 3, 1).cpu().numpy()
    decoded = np.stack([_through_file(image, quality, chroma)[top:, left:] for image in rows])
    return torch.from_numpy(decoded).permute(0, 3, 1, 2).contiguous().to(srgb) / 255


def _framed(
    srgb: torch.Tensor, quality: int, origin_px: tuple[int, int]
) -> tuple[torch.Tensor, int, int]:
    """Repeat the edge leftwards and upwards to where the frame's grid has a corner."""
    whole("quality", quality, "1 to 100", low=1, high=100)
    left, top = (place % _MACROBLOCK_PX for place in check_origin(origin_px))
    framed = F.pad(srgb, (left, 0, top, 0), mode="replicate") if left or top else srgb
    return framed, left, top


def _through_file(rgb: np.ndarray, quality: int, chroma: str) -> np.ndarray:
    settings = [
        cv2.IMWRITE_JPEG_QUALITY,
        quality,
        cv2.IMWRITE_JPEG_SAMPLING_FACTOR,
        _CHROMAS[chroma],
    ]
    _, file = cv2.imencode(".jpg", np.ascontiguousarray(rgb[..., ::-1]), settings)
    return np.ascontiguousarray(cv2.imdecode(file, cv2.IMREAD_COLOR)[..., ::-1])


def jpeg_differentiable(
    srgb: torch.Tensor, quality: int, *, chroma: str = "4:2:0", origin_px: tuple[int, int] = (0, 0)
) -> torch.Tensor:
    """Do what :func:`jpeg` does, closely, with a gradient to the pixels.

    Args:
        srgb: ``(B, 3, H, W)`` float32 (or float64, in which gradients are checked), [0, 1].
        quality: 1-100.
        chroma: One of ``_CHROMAS``.
        origin_px: See :func:`jpeg`.

    Returns:
        ``(B, 3, H, W)``, [0, 1], multiples of 1/255 (with a straight-through gradient).

    Raises:
        ImageContractError: The images break the contract.
        InputError: Unknown chroma, or a place or a quality out of range.
    """
    check_srgb(srgb)
    framed, left, top = _framed(srgb, quality, origin_px)
    return quantise(soft_jpeg(framed, quality, chroma)[..., top:, left:], differentiable=True)


class Jpeg(nn.Module):
    """The file that a camera keeps: compressed once, or again by everyone who handed it on.

    Args:
        qualities: 1-100, one for each time it is compressed; a number is once.
        chroma: One of ``_CHROMAS``.

    Raises:
        InputError: Unknown chroma, no quality, or one out of range.
    """

    frames = 1
    """Exposures that one picture takes."""

    def __init__(self, qualities: int | Sequence[int] = 75, chroma: str = "4:2:0") -> None:
        super().__init__()
        several = isinstance(qualities, Iterable) and not isinstance(qualities, str)
        given = [*qualities] if several else [qualities]  # type: ignore[misc]
        check_setting("qualities", given, len(given) > 0, "at least one")
        self.qualities = tuple(
            whole("qualities", one, "1 to 100", low=1, high=100) for one in given
        )
        self.chroma = check_choice("chroma", chroma, _CHROMAS)

    def forward(
        self,
        frames: torch.Tensor,
        *,
        origin_px: tuple[int, int] = (0, 0),
        differentiable: bool = False,
    ) -> torch.Tensor:
        """Compress the last of ``frames`` ``(T, B, 3, H, W)``; the others leave no trace in it.

        Returns:
            ``(B, 3, H, W)``, multiples of 1/255.

        Raises:
            ImageContractError: The images break the contract.
            InputError: The place is no two whole numbers >= 0.
        """
        codec, picture = jpeg_differentiable if differentiable else jpeg, frames[-1]
        for quality in self.qualities:
            picture = codec(picture, quality, chroma=self.chroma, origin_px=origin_px)
        return picture
