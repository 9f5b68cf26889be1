"""How does a picture become a file, and a file a picture? PNG, nothing lost; any format read."""

from pathlib import Path

import cv2
import numpy as np
import torch

from lrsr.errors import InputError
from lrsr.files import write_bytes

SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".webp", ".ppm")
"""Of files that are taken for pictures, in small letters."""


def write_png(path: Path, image: torch.Tensor, *, bits: int = 8) -> None:
    """Write ``(3, H, W)`` in [0, 1] (clipped to it) as an RGB file of 8 or 16 bits a channel.

    Whether the values are srgb or linear is the caller's business; the file does not say.

    Raises:
        InputError: The folder cannot be written or the disk is full.
        ValueError: ``bits`` is neither 8 nor 16.
    """
    if bits not in (8, 16):
        raise ValueError(f"bits={bits}: wanted 8 or 16")
    levels = 2**bits - 1
    pixels = image.detach().cpu().clamp(0, 1).double().mul(levels).round().numpy()
    bgr = np.ascontiguousarray(pixels.transpose(1, 2, 0)[..., ::-1])
    _, file = cv2.imencode(".png", bgr.astype(np.uint8 if bits == 8 else np.uint16))
    write_bytes(path, file.tobytes(), durable=False)  # quickly made again


def read_image(path: Path) -> torch.Tensor:
    """Read a picture of 8 or 16 bits a channel, turned as its Exif says.

    Returns:
        ``(3, H, W)`` float32, [0, 1], RGB.

    Raises:
        InputError: There is no such file, it cannot be read, or it is no whole picture.
    """
    try:
        content = np.frombuffer(path.read_bytes(), np.uint8)
    except OSError as error:
        raise InputError(
            f"cannot read {path}: {error.strerror or error}; check the path and its rights"
        ) from error
    flags = cv2.IMREAD_COLOR | cv2.IMREAD_ANYDEPTH
    try:
        pixels = cv2.imdecode(content, flags) if len(content) else None
    except cv2.error as error:  # e.g. of more pixels than OpenCV takes
        raise InputError(f"cannot read {path}: {error.err}; make it smaller") from error
    if pixels is None or pixels.dtype not in (np.uint8, np.uint16):
        raise InputError(f"{path} is no picture, or a broken one: make it again")
    levels = float(np.iinfo(pixels.dtype).max)
    rgb = np.ascontiguousarray(pixels[..., ::-1].transpose(2, 0, 1)).astype(np.float32)
    return torch.from_numpy(rgb / levels)
