"""What does ``lrsr upscale`` do? Any picture, by any upscaler, as a file that says what it said."""

import logging
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from tqdm import tqdm

from lrsr import __version__
from lrsr.configuration import as_word, require, whole_number, words
from lrsr.errors import InputError
from lrsr.experiments.made import RECORD, Made
from lrsr.files import sweep
from lrsr.paths import user_path
from lrsr.pictures.image_files import SUFFIXES, read_file
from lrsr.pictures.stored import (
    FORMATS,
    WITH_OPACITY,
    Header,
    encode,
    read_header,
    read_stored,
)
from lrsr.presets import build
from lrsr.sr.large import enlarge, spread_colours
from lrsr.sr.upscaler import Bicubic, Upscaler

if TYPE_CHECKING:
    from omegaconf import DictConfig

_MOST_PX = 2**30
"""Of a finished picture: OpenCV, and so every command, reads no more."""

_OF_A_RUN = (RECORD, "config.yaml", "versions.json")

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class Upscaling:
    """Which pictures are enlarged, and how.

    Attributes:
        images: Files, and folders of which all pictures are taken, sub-folders too.
        upscaler: Enlarges them.
        format: Suffix of a format, such as "png"; None: as each picture's own.
        quality: Of JPEG and WebP.
        tile_px: Sides of the tiles of large pictures; None: no tiles.
        around_px: What a tile sees around it; None: the upscaler's reach.

    Raises:
        InputError: A value is out of range.
    """

    images: tuple[Path, ...]
    upscaler: Upscaler
    format: str | None = None
    quality: int = 95
    tile_px: int | None = 256
    around_px: int | None = None

    def __post_init__(self) -> None:
        known = f"null or one of {', '.join(FORMATS)}"
        require(self.format in (None, *FORMATS), "format", self.format, known)
        require(1 <= self.quality <= 100, "quality", self.quality, "1 to 100")
        tile, around = self.tile_px, self.around_px
        require(tile is None or tile >= 16, "tile_px", tile, "16 or more, or null")
        require(around is None or around >= 0, "around_px", around, "0 or more, or null")

    @classmethod
    def from_config(cls, config: "DictConfig") -> Self:
        """Read a composed configuration of ``lrsr upscale``.

        Raises:
            InputError: A value is wrong; the message names the setting and the remedy.
        """

        def whole_if_any(key: str) -> int | None:
            return None if config[key] is None else whole_number(config, key)

        return cls(
            images=tuple(user_path(image, "images") for image in words(config, "images")),
            upscaler=build(config.sr, "sr"),
            format=None if config.format is None else as_word(config.format, "format").lower(),
            quality=whole_number(config, "quality"),
            tile_px=whole_if_any("tile_px"),
            around_px=whole_if_any("around_px"),
        )

    def describe(self) -> dict[str, Any]:
        """Return what decides about a finished picture, in plain values."""
        return {
            "sr": self.upscaler.describe(),
            "format": self.format,
            "quality": self.quality,
            "tile_px": self.tile_px,
            "around_px": self.around_px,
            "lrsr": __version__,
        }

    def run(self, folder: Path, *, progress: bool = True) -> Path:
        """Enlarge what is not yet; pictures that cannot be are told at the end.

        Args:
            folder: Where the pictures go; those of sub-folders into sub-folders.
            progress: Show a bar.

        Raises:
            InputError: There are no pictures, or a finished one cannot be written.
            ExceptionGroup: Of InputErrors: some were refused; all others are finished.
        """
        made, made_by = Made(folder), self.describe()
        refused: list[Exception] = []
        jobs = list(self._jobs(folder, made, refused))
        for place in {job.target.parent for job in jobs}:
            sweep(place)
        enlarged = as_before = 0
        with tqdm(
            total=sum(job.pixels for job in jobs), desc="enlarging", unit="px", unit_scale=True,
            disable=not progress,
        ) as bar:  # fmt: skip
            for job in jobs:
                try:
                    content = read_file(job.source)
                    if made.is_done(job.target, content, made_by):
                        bar.total -= job.pixels
                        as_before += 1
                        continue
                    made.check_free(job.target)
                    larger = self._enlarged(job, content, bar.update)
                except InputError as error:
                    refused.append(error)
                    continue
                made.write(job.target, larger, job.source, content, made_by)  # or all stops
                enlarged += 1
        told = "%d pictures enlarged, %d were so before, %d refused"
        logger.info(told, enlarged, as_before, len(refused))
        if refused:
            raise ExceptionGroup("some pictures were refused", refused)
        return folder

    def _jobs(self, folder: Path, made: Made, refused: list[Exception]) -> Iterator["_Job"]:
        """Yield what is to be done; what can be told to be wrong by its first bytes is refused."""
        seen: set[Path] = set()
        taken: set[Path] = set()
        for source, place in _sources(self.images, folder, made):
            if source in seen:
                continue
            seen.add(source)
            try:
                header = read_header(source, source)
                pixels = header.size_px[0] * header.size_px[1]
                kind = FORMATS[self.format] if self.format else header.format
                self._check(source, header, kind, pixels * self.upscaler.scale**2)
            except InputError as error:
                refused.append(error)
                continue
            names = _names(folder / place, kind, self.format)
            target = next(
                name for name in names
                if name not in taken and made.source_of(name) in (None, str(source))
            )  # fmt: skip
            taken.add(target)
            yield _Job(source, target, kind, pixels)

    def _check(self, source: Path, header: Header, kind: str, large_px: int) -> None:
        """Refuse what would be refused after all the work.

        Raises:
            InputError: The finished picture cannot be written as that, or would be too large.
        """
        if header.opacity and kind not in WITH_OPACITY:
            raise InputError(f"{source} has transparent parts, {kind} none: give format=png")
        if large_px > _MOST_PX:
            raise InputError(
                f"{source} would have {large_px / 1e6:,.0f} million pixels, over"
                f" {_MOST_PX / 1e6:,.0f}: give a smaller picture or scale"
            )

    def _enlarged(self, job: "_Job", content: bytes, done: Callable[[int], object]) -> bytes:
        """Return the finished file.

        Raises:
            InputError: The picture is broken, does not fit into memory or the format, or the
                network cannot enlarge it.
        """
        try:
            header, pixels, opacity = read_stored(content, job.source)
            if opacity is not None:
                pixels = spread_colours(pixels, opacity)
            tiles = {"tile_px": self.tile_px, "around_px": self.around_px}
            try:
                pixels = enlarge(self.upscaler, pixels, **tiles, done=done)
            except InputError as error:
                raise InputError(f"{job.source}: {error}") from error
            if opacity is not None:
                opacity = enlarge(Bicubic(self.upscaler.scale), opacity, tile_px=self.tile_px)
            return encode(pixels, opacity, header, format=job.format, quality=self.quality)
        except MemoryError as error:
            raise InputError(f"{job.source} does not fit into memory: make it smaller") from error


@dataclass(frozen=True)
class _Job:
    source: Path
    target: Path
    format: str
    pixels: int


def _sources(images: Sequence[Path], folder: Path, made: Made) -> Iterator[tuple[Path, Path]]:
    """Yield the pictures, and where each goes, below the folder of the finished ones.

    What was asked for by name is taken; of folders, what is named as a picture, is not hidden, and
    was not made by us in an earlier run.

    Raises:
        InputError: A folder holds no pictures.
    """
    folders = sum(path.is_dir() for path in images)
    passed_over: list[str] = []
    for given in images:
        if not given.is_dir():
            yield given, Path(given.name)
            continue
        found = 0
        for file in sorted(given.rglob("*")):
            inner = file.relative_to(given)
            hidden = any(part.startswith(".") for part in inner.parts)
            ours = file.is_relative_to(folder) and made.source_of(file) is not None
            if hidden or ours or not file.is_file():
                continue
            if file.suffix.lower() in SUFFIXES:
                found += 1
                yield file, Path(given.name, inner) if folders > 1 else inner
            elif file.name not in _OF_A_RUN:
                passed_over.append(file.name)
        if not found:
            kinds = ", ".join(suffix[1:] for suffix in SUFFIXES)
            raise InputError(f"images={given} holds no pictures: put files in it ({kinds})")
    if passed_over:
        told = ", ".join(passed_over[:3]) + (", ..." if passed_over[3:] else "")
        logger.info("%d files are not named as pictures: %s", len(passed_over), told)


def _names(wanted: Path, format: str, suffix: str | None) -> Iterator[Path]:
    """Yield names for a file of that format: as it is called, then with -2, -3 ..."""
    known = FORMATS.get(wanted.suffix[1:].lower())
    usual = suffix or next(name for name, kind in FORMATS.items() if kind == format)
    name = wanted if known == format else wanted.with_suffix(f".{usual}")
    yield name
    yield from (name.with_stem(f"{name.stem}-{k}") for k in count(2))
