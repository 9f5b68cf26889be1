"""How does a picture become a file, and a file a picture? PNG, nothing lost; any format read."""

from pathlib import Path

import cv2
import numpy as np
import torch
from numpy.typing import NDArray

from lrsr.errors import InputError
from lrsr.files import read_bytes, write_bytes
from lrsr.identities.photographs.picture_file import decode
from lrsr.images import check_images

SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".webp", ".ppm")
"""Of files that are taken for pictures, in small letters."""


def write_png(path: Path, image: torch.Tensor, *, bits: int = 8) -> None:
    """Write ``(3, H, W)`` in [0, 1] (clipped to it) as an RGB file of 8 or 16 bits a channel.

    Whether the values are srgb or linear is the caller's business; the file does not say.

    Raises:
        InputError: The folder cannot be written or the disk is full.
        ImageContractError: It is no picture, or one of whole numbers.
        NonFiniteError: It holds a NaN or an infinity.
        ValueError: ``bits`` is neither 8 nor 16.
    """
    if bits not in (8, 16):
        raise ValueError(f"bits={bits}: wanted 8 or 16")
    check_images(image[None] if isinstance(image, torch.Tensor) else image, name="image")
    pixels = _to_pixels(image, np.uint8 if bits == 8 else np.uint16)
    _, file = cv2.imencode(".png", np.ascontiguousarray(pixels[..., ::-1]))
    write_bytes(path, file.tobytes(), durable=False)  # quickly made again


def read_image(path: Path) -> torch.Tensor:
    """Read a picture of 8 or 16 bits a channel, turned as its Exif says.

    Returns:
        ``(3, H, W)`` float32, [0, 1], RGB.

    Raises:
        InputError: There is no such file, it cannot be read, or it is no whole picture.
    """
    return _to_srgb(decode(read_file(path), str(path)))


def read_file(path: Path) -> bytes:
    """Read the bytes of a picture's file.

    Raises:
        InputError: There is no such file, or it cannot be read or named.
    """
    check_name(path)
    try:
        return read_bytes(path)
    except OSError as error:
        raise InputError(
            f"cannot read {path}: {error.strerror or error}; check the path and its rights"
        ) from error


def check_name(path: Path) -> None:
    """Refuse a name that no table, record or page could say.

    Raises:
        InputError: It holds bytes that are no UTF-8.
    """
    try:
        str(path).encode()
    except UnicodeEncodeError as error:
        raise InputError(f"{str(path)!r}: a name of other bytes than UTF-8; rename it") from error


def _to_srgb(pixels: NDArray[np.uint8 | np.uint16]) -> torch.Tensor:
    """Return pixels ``(H, W, C)`` as ``(C, H, W)`` float32, [0, 1].

    Example:
        >>> _to_srgb(np.full((1, 1, 1), 65535, np.uint16)).item()
        1.0
    """
    values = np.ascontiguousarray(pixels.transpose(2, 0, 1)).astype(np.float32)
    return torch.from_numpy(values / float(np.iinfo(pixels.dtype).max))


def _to_pixels(
    srgb: torch.Tensor, depth: type[np.uint8 | np.uint16]
) -> NDArray[np.uint8 | np.uint16]:
    """Return ``(C, H, W)`` in [0, 1] (clipped to it) as whole numbers ``(H, W, C)``."""
    levels = srgb.detach().cpu().clamp(0, 1).double().mul(np.iinfo(depth).max).round()
    return np.ascontiguousarray(levels.numpy().transpose(1, 2, 0).astype(depth))
