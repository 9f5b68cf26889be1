"""What does compression leave of a picture? JPEG: the real codec, and one with a gradient.

The real one is OpenCV's (libjpeg-turbo): what a file would hold. The differentiable one is
kornia's (Reich et al. 2024, arXiv:2309.06978): the same tables and the same 4:2:0, with a rounding
that has a slope, for training through it. On smooth random images the two are 38 dB apart at
quality 15, where each is 28 dB from the original, and 43 dB at quality 75
(``tests/camera/test_codec.py``); the soft rounding keeps about 1 dB that the real one loses; its
gradient is, on average, a quarter of the straight-through one.
"""

from dataclasses import dataclass

import cv2
import numpy as np
import torch
from kornia.enhance import jpeg_codec_differentiable

from lrsr.camera.encoding import quantise
from lrsr.errors import InputError
from lrsr.images import check_images


@dataclass(frozen=True)
class Compression:
    """How hard a picture is squeezed.

    Attributes:
        quality: Of the Independent JPEG Group's scale, 1-100; None: not compressed.
        chroma: Sub-sampling of the two colour channels.
    """

    quality: int | None
    chroma: str = "4:2:0"


COMPRESSIONS = {
    "none": Compression(None),
    "small": Compression(75),
    "heavy": Compression(15),
}
"""The three presets. The qualities are **estimated**: 75 is the default of the Independent JPEG
Group and what cameras call little compression; 15 is near the lower end of what surveillance
recorders offer, where the 8 x 8 blocks show."""


def compression(name: str) -> Compression:
    """Return the preset of that name.

    Raises:
        InputError: There is none.

    Example:
        >>> compression("small")
        Compression(quality=75, chroma='4:2:0')
    """
    if name not in COMPRESSIONS:
        raise InputError(f"compression {name!r}: choose one of {', '.join(COMPRESSIONS)}")
    return COMPRESSIONS[name]


def jpeg(srgb: torch.Tensor, quality: int) -> torch.Tensor:
    """Encode each image with OpenCV's JPEG at 4:2:0 and decode it again; there is no gradient.

    Args:
        srgb: ``(B, 3, H, W)`` float32, [0, 1]; rounded to 8 bits first.
        quality: 1-100.

    Returns:
        ``(B, 3, H, W)`` float32, [0, 1], multiples of 1/255, on the device of ``srgb``.

    Raises:
        ImageContractError: The images break the contract.
    """
    check_images(srgb, name="srgb")
    pixels = srgb.detach().clamp(0, 1).mul(255).round().to(torch.uint8)
    rows = pixels.permute(0, 2, 3, 1).cpu().numpy()
    decoded = np.stack([_through_file(image, quality) for image in rows])
    return torch.from_numpy(decoded).permute(0, 3, 1, 2).contiguous().to(srgb) / 255


def _through_file(rgb: np.ndarray, quality: int) -> np.ndarray:
    settings = [
        cv2.IMWRITE_JPEG_QUALITY,
        quality,
        cv2.IMWRITE_JPEG_SAMPLING_FACTOR,
        cv2.IMWRITE_JPEG_SAMPLING_FACTOR_420,
    ]
    _, file = cv2.imencode(".jpg", np.ascontiguousarray(rgb[..., ::-1]), settings)
    return np.ascontiguousarray(cv2.imdecode(file, cv2.IMREAD_COLOR)[..., ::-1])


def jpeg_differentiable(srgb: torch.Tensor, quality: int) -> torch.Tensor:
    """Do what :func:`jpeg` does, closely, with a gradient to the pixels.

    Sizes that are no multiples of 16 are padded on the right and at the bottom by repeating the
    edge, as libjpeg does, and cut back.

    Args:
        srgb: ``(B, 3, H, W)`` float32, [0, 1].
        quality: 1-100.

    Returns:
        ``(B, 3, H, W)`` float32, [0, 1], multiples of 1/255 (with a straight-through gradient).

    Raises:
        ImageContractError: The images break the contract.
    """
    check_images(srgb, name="srgb")
    decoded = jpeg_codec_differentiable(srgb, torch.tensor([float(quality)], device=srgb.device))
    return quantise(decoded.clamp(0, 1), differentiable=True)
