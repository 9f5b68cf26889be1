"""Which pictures lie in a folder? Real ones of one camera, of one size, without references."""

import statistics
from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path

import torch

from lrsr.camera.jpeg_tables import BLOCK_PX, read_jpeg_settings
from lrsr.errors import InputError
from lrsr.pictures.image_files import SUFFIXES, read_image

LEAST_PX, MOST_PX = 2 * BLOCK_PX, 256
"""Of a side: fewer hold no whole block, more are no small faces (200 films of them fill memory)."""


@dataclass(frozen=True)
class RealPictures:
    """Pictures of one camera.

    Attributes:
        srgb: ``(n, 3, H, W)``, [0, 1].
        jpeg: Quality and chroma sub-sampling that the files themselves say; None if they are none.
        origin_px: ``(x, y)`` of the first pixel in what the files held.
    """

    srgb: torch.Tensor
    jpeg: tuple[int, str] | None = None
    origin_px: tuple[int, int] = (0, 0)

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
    """Read every picture of a folder (not below it); other files are passed over.

    Args:
        folder: Holds PNG, JPEG, BMP, TIFF, WebP or PPM files.
        least: How many there must be.

    Raises:
        InputError: No such folder, no or too few pictures in it, a broken one, several sizes, sides
            of less than 16 or more than 256 px, or pictures without colour.
    """
    if not folder.is_dir():
        raise InputError(f"images={folder} is no folder: give one that holds pictures")
    files = sorted(file for file in folder.iterdir() if file.suffix.lower() in SUFFIXES)
    files = [file for file in files if file.is_file() and not file.stem.endswith("_linear16")]
    if not files:
        kinds = ", ".join(suffix[1:] for suffix in SUFFIXES)
        raise InputError(f"images={folder} holds no pictures: put files in it ({kinds})")
    if len(files) < least:
        raise InputError(
            f"images={folder} holds {len(files)} pictures: give at least {least}, better 50, of "
            "different people"
        )
    pictures = {file: read_image(file) for file in files}
    _check_sizes(pictures)
    if all(bool((picture == picture[:1]).all()) for picture in pictures.values()):
        raise InputError(
            f"images={folder} holds grey pictures only: noise and gains of the colours are part of "
            "what is fitted; give pictures that were taken in colour"
        )
    return RealPictures(torch.stack(list(pictures.values())), _jpeg_of(files))


def _check_sizes(pictures: dict[Path, torch.Tensor]) -> None:
    sizes = Counter(tuple(picture.shape[1:]) for picture in pictures.values())
    if len(sizes) == 1:
        height, width = next(iter(sizes))
        if not LEAST_PX <= min(height, width) <= max(height, width) <= MOST_PX:
            raise InputError(
                f"{next(iter(pictures))} has {width} x {height} px: sides of {LEAST_PX} to "
                f"{MOST_PX} px are fitted; cut out the faces (do not rescale them)"
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
    found = [read_jpeg_settings(file.read_bytes()) for file in files]
    known = [one for one in found if one is not None]
    if len(known) < len(files):
        return None
    chroma = Counter(one[1] for one in known).most_common(1)[0][0]
    return int(statistics.median_low([one[0] for one in known])), chroma
