"""Which pictures lie in a folder? Real ones of one camera, of one size, without references."""

import logging
import math
import statistics
from collections import Counter
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from warnings import catch_warnings

import torch
from PIL import Image, UnidentifiedImageError
from torch.nn import functional as F

from lrsr.calibration.jpeg_files import read_jpeg_settings
from lrsr.camera.jpeg_tables import BLOCK_PX
from lrsr.errors import InputError
from lrsr.pictures.image_files import SUFFIXES, read_file, read_image

_LEAST_PX, _MOST_PX = 2 * BLOCK_PX, 256
"""Of a side: fewer hold no whole block, more are no small faces (200 films of them fill memory)."""

_NEAR_LEVELS = 1.5
"""Root mean square difference, levels in 8 x 8 parts, below which pictures are of one shot."""

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class RealPictures:
    """Pictures of one camera.

    Attributes:
        srgb: ``(n, 3, H, W)``, [0, 1].
        jpeg: Quality and chroma sub-sampling that the files themselves say; None if they are none.
        origin_px: ``(x, y)`` of the first pixel in what the files held.
        copies: Names of the files that were left out, and of those that they equal.
    """

    srgb: torch.Tensor
    jpeg: tuple[int, str] | None = None
    origin_px: tuple[int, int] = (0, 0)
    copies: Mapping[str, str] = field(default_factory=dict)

    @property
    def size_px(self) -> tuple[int, int]:
        """(height, width)."""
        return self.srgb.shape[-2], self.srgb.shape[-1]

    def cropped(self, size_px: tuple[int, int]) -> "RealPictures":
        """Return the middle of that (height, width), or less where there is not as much."""
        tall, wide = (min(a, b) for a, b in zip(self.size_px, size_px, strict=True))
        top, left = (self.size_px[0] - tall) // 2, (self.size_px[1] - wide) // 2
        x, y = self.origin_px
        middle = self.srgb[..., top : top + tall, left : left + wide]
        return replace(self, srgb=middle, origin_px=(x + left, y + top))


def read_real_pictures(folder: Path, least: int) -> RealPictures:
    """Read every picture of a folder (not below it), copies once.

    Passed over are folders, hidden files, files that are not named as pictures, and links that lead
    nowhere. Of pictures that are equal pixel for pixel, whatever their files are, the first by name
    counts; a line tells of the others.

    Args:
        folder: Holds PNG, JPEG, BMP, TIFF, WebP or PPM files.
        least: How many different ones there must be.

    Raises:
        InputError: No such folder, no or too few pictures in it, a broken or unreadable one,
            several sizes, sides of less than 16 or more than 256 px, or pictures without colour.
    """
    files = _files(folder)
    _enough(folder, len(files), least, f"{len(files)} pictures")
    pictures = {file: _read(file) for file in files}
    _check_sizes(pictures)
    if all(bool((picture == picture[:1]).all()) for picture in pictures.values()):
        raise InputError(
            f"images={folder} holds grey pictures only: noise and gains of the colours are part of "
            "what is fitted; give pictures that were taken in colour"
        )
    firsts: dict[bytes, Path] = {}
    copies = {}
    for file, picture in pictures.items():
        first = firsts.setdefault(picture.numpy().tobytes(), file)
        if first != file:
            copies[file.name] = first.name
    told = f"{len(copies)} of {len(files)} pictures are copies ({_shown(copies)})"
    distinct = f"{len(firsts)} different pictures, since {told}"
    _enough(folder, len(firsts), least, distinct)
    if copies:
        logger.warning("images=%s: %s; each is counted once", folder, told)
    kept = list(firsts.values())
    srgb = torch.stack([pictures[file] for file in kept])
    _warn_of_near_copies(folder, srgb)
    return RealPictures(srgb, _jpeg_of(kept), copies=copies)


def _files(folder: Path) -> list[Path]:
    """Return the files of a folder that are named as pictures.

    Raises:
        InputError: It is no folder, cannot be read, or holds none.
    """
    try:
        if not folder.is_dir():
            raise InputError(f"images={folder} is no folder: give one that holds pictures")
        files = sorted(
            file
            for file in folder.iterdir()
            if file.suffix.lower() in SUFFIXES and not file.name.startswith(".") and file.is_file()
        )
    except OSError as error:
        reason = error.strerror or error
        raise InputError(f"cannot read images={folder}: {reason}; check its rights") from error
    files = [file for file in files if not file.stem.endswith("_linear16")]
    if not files:
        kinds = ", ".join(suffix[1:] for suffix in SUFFIXES)
        raise InputError(f"images={folder} holds no pictures: put files in it ({kinds})")
    return files


def _enough(folder: Path, count: int, least: int, holds: str) -> None:
    if count < least:
        raise InputError(
            f"images={folder} holds {holds}: give at least {least}, better 50, of different people"
        )


def _shown(copies: Mapping[str, str], most: int = 3) -> str:
    """Return which is a copy of which, the first few."""
    told = [f"{copy} of {first}" for copy, first in list(copies.items())[:most]]
    return ", ".join(told) + (", ..." if len(copies) > most else "")


def _read(file: Path) -> torch.Tensor:
    """Return a picture ``(3, H, W)``.

    Raises:
        InputError: It cannot be read, is none, or was cut short (OpenCV would fill in grey).
    """
    picture = read_image(file)
    try:
        with catch_warnings(action="ignore"), suppress(UnidentifiedImageError):
            Image.open(file).load()
    except (OSError, SyntaxError) as error:
        raise InputError(f"{file} is a broken picture ({error}): copy it again") from None
    return picture


def _warn_of_near_copies(folder: Path, srgb: torch.Tensor) -> None:
    """Tell of pictures that look like frames of one shot: people differ more than that."""
    coarse = 255 * F.adaptive_avg_pool2d(srgb, 8).flatten(1)
    apart = torch.cdist(coarse, coarse) / coarse.shape[1] ** 0.5
    near = int((apart.fill_diagonal_(math.inf).amin(1) < _NEAR_LEVELS).sum())
    if near:
        told = f"{near} of {len(srgb)} pictures hardly differ from another one"
        why = "frames of one shot are no different people, and errors will seem too small"
        logger.warning("images=%s: %s; %s", folder, told, why)


def _check_sizes(pictures: dict[Path, torch.Tensor]) -> None:
    sizes = Counter(tuple(picture.shape[1:]) for picture in pictures.values())
    if len(sizes) == 1:
        height, width = next(iter(sizes))
        if not _LEAST_PX <= min(height, width) <= max(height, width) <= _MOST_PX:
            raise InputError(
                f"{next(iter(pictures))} has {width} x {height} px: sides of {_LEAST_PX} to "
                f"{_MOST_PX} px are fitted; cut out the faces (do not rescale them)"
            )
        return
    usual = sizes.most_common(1)[0][0]
    odd = next(file for file, picture in pictures.items() if tuple(picture.shape[1:]) != usual)
    height, width = pictures[odd].shape[1:]
    raise InputError(
        f"{odd} has {width} x {height} px, most others {usual[1]} x {usual[0]}: crop all to one "
        "size (do not rescale them), or give each size a folder"
    )


def _jpeg_of(files: list[Path]) -> tuple[int, str] | None:
    """Return what the files say of themselves: the middle quality, the commonest sub-sampling."""
    found = [read_jpeg_settings(read_file(file)) for file in files]
    known = [one for one in found if one is not None]
    if len(known) < len(files):
        return None
    chroma = Counter(one[1] for one in known).most_common(1)[0][0]
    return int(statistics.median_low([one[0] for one in known])), chroma
