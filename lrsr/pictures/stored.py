"""What does a picture's file hold besides colours, and how is all of it written again?

Opacity, 8 or 16 bits, grey or colours, what the camera said (Exif), the colour profile and the
resolution in print. The colours are read as everywhere (:mod:`lrsr.pictures.image_files`).
"""

import io
import struct
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any
from warnings import catch_warnings

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import ExifTags, Image, ImageOps, TiffImagePlugin, UnidentifiedImageError

from lrsr.errors import InputError
from lrsr.files import check_file
from lrsr.identities.photographs.picture_file import decode
from lrsr.pictures.image_files import check_name

#: Of a picture: ``(H, W, C)``.
Pixels = NDArray[np.uint8 | np.uint16]

FORMATS = {
    "png": "PNG",
    "jpg": "JPEG",
    "jpeg": "JPEG",
    "bmp": "BMP",
    "tif": "TIFF",
    "tiff": "TIFF",
    "webp": "WEBP",
    "ppm": "PPM",
}
"""Pillow's names of the formats, by suffix; a format's first suffix is its usual one."""

WITH_OPACITY = ("PNG", "TIFF", "WEBP")
"""Formats that can be transparent in part."""

_GREY = ("1", "L", "LA", "La", "I", "I;16", "I;16B", "I;16L")
_TAKEN = (*_GREY, "P", "PA", "RGB", "RGBA", "RGBX")

_BROKEN = (
    *(OSError, SyntaxError, ValueError, TypeError, KeyError, IndexError, EOFError),
    *(struct.error, zlib.error),
)
"""What broken bytes make Pillow raise."""

_EXIF, _GPS, _INTEROP = ExifTags.IFD.Exif, ExifTags.IFD.GPSInfo, ExifTags.IFD.Interop
_SIDES = (ExifTags.Base.ExifImageWidth, ExifTags.Base.ExifImageHeight)
_OF_THE_FILE = frozenset(
    [
        *range(254, 267),  # sides, depth, compression, kind of colours
        *(273, 274, 277, 278, 279, 280, 281, 284),  # strips, orientation, channels
        *(292, 293, 297, 301, *range(317, 318), *range(320, 326), 330),  # predictor, palette, tiles
        *(338, 339, 340, 341, 347, *range(512, 522), *range(529, 533)),  # opacity, JPEG in TIFF
        *(700, 33723, 34377, 34675),  # XMP, IPTC, Photoshop's, the profile, which is kept apart
    ]
)
"""Tags that say how a TIFF's pixels lie in it, or what would be wrong of another picture."""


@dataclass(frozen=True)
class Header:
    """What a file says of its picture.

    Attributes:
        format: Pillow's name.
        size_px: (height, width) as it is seen, turned as its Exif says.
        grey: No colours.
        opacity: Parts may be transparent.
        exif: What the camera said, without what is true of the file only.
        profile: ICC, None where there is none.
        dpi: Resolution in print, None where it is not said.
    """

    format: str
    size_px: tuple[int, int]
    grey: bool
    opacity: bool
    exif: dict[int, Any] = field(default_factory=dict)
    profile: bytes | None = None
    dpi: tuple[float, float] | None = None


def read_header(content: bytes | Path, path: Path) -> Header:
    """Read what a file says of its picture, before its pixels.

    Args:
        content: Of the file, or where it is.
        path: For messages.

    Raises:
        InputError: It cannot be read or named, is no picture, several in one file, or is made for
            printing.
    """
    check_name(path)
    with _opened(content, path) as image:
        frames = getattr(image, "n_frames", 1)
        if frames > 1 and image.format != "MPO":  # whose others are previews
            raise InputError(f"{path} holds {frames} pictures: give each as a file of its own")
        if image.format not in (*FORMATS.values(), "MPO"):
            kinds = ", ".join(FORMATS)
            raise InputError(f"{path} is {image.format}: convert it to one of {kinds}")
        if image.mode not in _TAKEN:
            raise InputError(f"{path} is {image.mode}, no grey or RGB picture: convert it to RGB")
        exif = image.getexif()
        tags = _tags_of(exif)
        size = image.size[::-1]
        if exif.get(ExifTags.Base.Orientation, 1) > 4 and image.format != "TIFF":
            size = size[::-1]
        return Header(
            format="JPEG" if image.format == "MPO" else str(image.format),
            size_px=size,
            grey=image.mode in _GREY,
            opacity="A" in image.getbands() or "transparency" in image.info,
            exif={tag: value for tag, value in tags.items() if tag not in _OF_THE_FILE},
            profile=image.info.get("icc_profile"),
            dpi=image.info.get("dpi"),
        )


def read_stored(content: bytes, path: Path) -> tuple[Header, Pixels, Pixels | None]:
    """Read a picture and what its file says of it.

    Args:
        content: Of the file.
        path: For messages.

    Returns:
        The header; the pixels, ``(H, W, 1)`` where they are grey, else ``(H, W, 3)``, RGB; the
        opacity, ``(H, W, 1)``, None where the file has none.

    Raises:
        InputError: See :func:`read_header`; or it was cut short.
    """
    header = read_header(content, path)
    pixels = decode(content, str(path))
    with _opened(content, path) as image:
        lies = str(getattr(image, "tile", ""))
        image.load()  # OpenCV fills in grey where a file was cut short
        opacity = None
        if header.opacity and pixels.dtype == np.uint8:
            opacity = np.asarray(ImageOps.exif_transpose(image).convert("RGBA"))[..., 3:]
        elif header.opacity:
            opacity = _deep_opacity(content, path, image, darkened="RGBa" in lies)
    return header, pixels[..., :1] if header.grey else pixels, opacity


def _deep_opacity(content: bytes, path: Path, image: Image.Image, *, darkened: bool) -> Pixels:
    """Return the opacity of a picture of 16 bits, which Pillow cannot.

    Raises:
        InputError: The colours are darkened by it, or one colour stands for transparent.
    """
    values = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_UNCHANGED)
    if values.ndim < 3 or values.shape[2] != 4 or darkened:
        raise InputError(f"{path} has 16 bits and an opacity that lrsr cannot read: save it as PNG")
    opacity = Image.fromarray(np.ascontiguousarray(values[..., 3]))
    if image.format != "TIFF":  # which OpenCV turns in any case
        turn = image.getexif().get(ExifTags.Base.Orientation, 1)
        opacity.getexif()[ExifTags.Base.Orientation] = turn
        opacity = ImageOps.exif_transpose(opacity)
    return np.asarray(opacity)[..., None]


@contextmanager
def _opened(content: bytes | Path, path: Path) -> Iterator[Image.Image]:
    try:
        with (
            catch_warnings(action="ignore"),  # of many pixels, and of what is odd in Exif
            Image.open(
                io.BytesIO(content) if isinstance(content, bytes) else check_file(content)
            ) as image,
        ):
            yield image
    except Image.DecompressionBombError as error:
        raise InputError(f"{path} has more pixels than can be read: make it smaller") from error
    except FileNotFoundError as error:
        raise InputError(f"{path} does not exist: check the path") from error
    except UnidentifiedImageError as error:
        raise InputError(f"{path} is no picture, or a broken one: make it again") from error
    except _BROKEN as error:
        if isinstance(error, InputError):
            raise
        if isinstance(error, OSError) and error.filename is not None:
            why = error.strerror
            raise InputError(f"cannot read {path}: {why}; check the path and its rights") from error
        raise InputError(f"{path} is a broken picture ({error}): copy it again") from error


def encode(
    pixels: Pixels, opacity: Pixels | None, header: Header, *, format: str, quality: int
) -> bytes:
    """Return a picture as a file, with all that its header says and that is true of the new size.

    Args:
        pixels: ``(H, W, 1)`` or ``(H, W, 3)``, RGB, upright.
        opacity: ``(H, W, 1)``, None: none.
        header: Of the file that it was made from.
        format: Pillow's name. PNG, TIFF and PPM keep 16 bits, others have 8.
        quality: Of JPEG and WebP, 1 to 100; WebP of 100 loses nothing.

    Raises:
        InputError: The format cannot hold it, such as so many pixels, or opacity.
    """
    bands = pixels if opacity is None else np.concatenate([pixels, opacity], axis=2)
    exif = _exif_of(header, pixels.shape[:2])
    deep = bands.dtype == np.uint16
    if bands.shape[2] == 2 and deep:  # few programs read grey with opacity of 16 bits
        bands = bands[..., [0, 0, 0, 1]]
    if header.grey and (bands.shape[2] > 2 or format == "WEBP"):  # which has colours only
        header = replace(header, profile=None)
    if format == "TIFF" or (deep and format in _DEEP):
        return _DEEP[format](bands, header, exif)
    if deep:
        bands = np.round(bands / 257).astype(np.uint8)
    image = Image.fromarray(bands[..., 0] if bands.shape[2] == 1 else bands)
    told: dict[str, Any] = {
        "exif": exif if len(exif) else None,
        "icc_profile": header.profile,
        "dpi": header.dpi,
    }
    settings: dict[str, dict[str, Any]] = {
        "JPEG": {"quality": quality, "subsampling": "4:4:4"},
        "WEBP": {"quality": quality, "lossless": quality == 100, "exact": True},
    }
    told |= settings.get(format, {})
    file = io.BytesIO()
    try:
        image.save(file, format, **{name: v for name, v in told.items() if v is not None})
    except (OSError, ValueError) as error:  # of too many pixels
        width, height = image.size
        raise InputError(
            f"{width}x{height} px of {image.mode} are no {format} ({error}): give format=png"
        ) from error
    return file.getvalue()


def _exif_of(header: Header, size_px: tuple[int, ...]) -> Image.Exif:
    """Return what the camera said, with the new size: the picture is upright now."""
    exif = Image.Exif()
    for tag, value in header.exif.items():
        exif[tag] = value
    inner = {t: value for t, value in header.exif.get(_EXIF, {}).items() if t != _INTEROP}
    inner |= {tag: size for tag, size in zip(_SIDES, size_px[::-1], strict=True) if tag in inner}
    if inner:
        exif[_EXIF] = inner
    whole = Image.Exif()
    if len(exif):
        whole.load(exif.tobytes())  # as from a file: Pillow's TIFF takes no other
    return whole


def _tags_of(exif: Image.Exif) -> dict[int, Any]:
    return {tag: exif.get_ifd(tag) if tag in (_EXIF, _GPS) else exif[tag] for tag in exif}


def _deep_png(bands: Pixels, header: Header, exif: Image.Exif) -> bytes:
    """Let OpenCV write the pixels, and put chunks after their header."""
    _, file = cv2.imencode(".png", _as_bgr(bands))
    content: bytes = file.tobytes()
    chunks = b""
    if header.profile:
        chunks += _chunk(b"iCCP", b"ICC\0\0" + zlib.compress(header.profile))
    if len(exif):
        chunks += _chunk(b"eXIf", exif.tobytes().removeprefix(b"Exif\0\0"))
    if header.dpi:
        per_metre = [round(dpi / 0.0254) for dpi in header.dpi]
        chunks += _chunk(b"pHYs", struct.pack(">2IB", *per_metre, 1))
    end_of_header = 8 + 25
    return content[:end_of_header] + chunks + content[end_of_header:]


def _chunk(kind: bytes, content: bytes) -> bytes:
    check = zlib.crc32(kind + content)
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", check)


def _tiff(bands: Pixels, header: Header, exif: Image.Exif) -> bytes:
    """Let Pillow write the tags, and put the pixels after them as one strip."""
    height, width, count = bands.shape
    strip = zlib.compress(bands.astype(bands.dtype.newbyteorder("<")).tobytes())
    tags: dict[int, Any] = {
        256: width,
        257: height,
        258: (8 * bands.itemsize,) * count,
        259: 8,  # Deflate
        262: 1 if count < 3 else 2,  # grey, RGB
        273: 0,  # where the strip begins: after the tags
        277: count,
        278: height,
        279: len(strip),
    }
    tags |= {338: 2} if count in (2, 4) else {}  # the last is opacity, which darkens nothing
    tags |= {34675: header.profile} if header.profile else {}
    tags |= {282: header.dpi[0], 283: header.dpi[1], 296: 2} if header.dpi else {}  # per inch
    folder = TiffImagePlugin.ImageFileDirectory_v2()
    for tag, value in {**_tags_of(exif), **tags}.items():
        folder[tag] = value
    file = io.BytesIO()
    folder.save(file)
    return file.getvalue() + strip


def _deep_ppm(bands: Pixels, header: Header, exif: Image.Exif) -> bytes:
    """Let OpenCV write it; the format holds nothing else."""
    _, file = cv2.imencode(".ppm", _as_bgr(bands if bands.shape[2] == 3 else bands[..., [0] * 3]))
    content: bytes = file.tobytes()
    return content


def _as_bgr(bands: Pixels) -> Pixels:
    order = {1: [0], 3: [2, 1, 0], 4: [2, 1, 0, 3]}[bands.shape[2]]
    return np.ascontiguousarray(bands[..., order])


_DEEP = {"PNG": _deep_png, "TIFF": _tiff, "PPM": _deep_ppm}
"""Who writes 16 bits a channel, and in TIFF what the camera said, which Pillow cannot."""
