"""What of a picture's file is the photograph of somebody? The square around the face."""

import io
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image, ImageOps

from lrsr.errors import InputError

Points = NDArray[np.float64]

_AROUND_IPDS = 4.0
"""Half of the square's side: the head with its hair, and some of what is behind it."""
_IPD_PX = 300.0
"""Larger faces are reduced to this."""
_TIFF = (b"II*\0", b"MM\0*")


class Photograph(NamedTuple):
    """A face on a picture.

    Attributes:
        srgb: ``(H, W, 3)`` float32, srgb, [0, 1].
        five_px: ``(5, 2)`` on it.
        ipd_px: Between the eyes of the five, on the file's picture.
    """

    srgb: NDArray[np.float32]
    five_px: Points
    ipd_px: float


def decode(content: bytes, name: str) -> NDArray[Any]:
    """Return the pixels of a file ``(H, W, 3)``, RGB, turned as its Exif says, without opacity.

    Any colour space; whatever is transparent has the colour that the file gives it.

    Args:
        content: Of the file.
        name: For messages.

    Raises:
        InputError: It is no whole picture of 8 or 16 bits a channel, or of more pixels than OpenCV
            takes.
    """
    try:
        flags = cv2.IMREAD_COLOR | cv2.IMREAD_ANYDEPTH
        pixels = cv2.imdecode(np.frombuffer(content, np.uint8), flags) if content else None
    except cv2.error as error:
        raise InputError(f"cannot read {name}: {error.err}; make it smaller") from error
    if pixels is None or pixels.dtype not in (np.uint8, np.uint16):
        raise InputError(f"{name} is no picture, or a broken one: make it again")
    if content.startswith(_TIFF) and pixels.dtype == np.uint8:
        bands = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_UNCHANGED)
        if bands.ndim > 2 and bands.shape[2] > 3:  # with an opacity
            return _undarkened(content, name)
    return np.ascontiguousarray(pixels[..., ::-1])


def _undarkened(content: bytes, name: str) -> NDArray[Any]:
    """Return the colours of a TIFF file of 8 bits, which OpenCV darkens where it is transparent.

    Raises:
        InputError: Pillow cannot read it.
    """
    try:
        with Image.open(io.BytesIO(content)) as image:
            shown = np.asarray(ImageOps.exif_transpose(image).convert("RGBA"))
            return np.ascontiguousarray(shown[..., :3])
    except (OSError, ValueError, SyntaxError) as error:  # what Pillow raises of broken files
        raise InputError(f"cannot read {name}: {error}; save it as PNG") from error


def frame(pixels: NDArray[Any], five_px: ArrayLike) -> Photograph:
    """Cut the face out of a picture, and reduce it if it is large.

    Args:
        pixels: ``(H, W, 3)`` of 8 or 16 bits.
        five_px: ``(5, 2)`` on it.
    """
    five = np.asarray(five_px, dtype=np.float64)
    ipd = float(np.linalg.norm(five[1] - five[0]))
    middle, reach = five.mean(axis=0), _AROUND_IPDS * max(ipd, 1.0)
    size = np.array(pixels.shape[1::-1])
    low = np.clip(np.floor(middle - reach), 0, size - 1).astype(int)
    high = np.clip(np.ceil(middle + reach), low + 1, size).astype(int)
    part = pixels[low[1] : high[1], low[0] : high[0]]
    srgb = part.astype(np.float32) / np.float32(np.iinfo(pixels.dtype).max)
    five = five - low
    factor = min(1.0, _IPD_PX / max(ipd, 1.0))
    if factor < 1:
        width, height = (max(1, round(extent * factor)) for extent in srgb.shape[1::-1])
        five = (five + 0.5) * [width / srgb.shape[1], height / srgb.shape[0]] - 0.5
        srgb = np.asarray(cv2.resize(srgb, (width, height), interpolation=cv2.INTER_AREA))
    return Photograph(srgb, five, ipd)
