"""What does ``lrsr reconstruct`` do? Photographs become people, or are refused in one line each."""

import logging
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Self

import cv2
import numpy as np

from lrsr.configuration import require
from lrsr.experiments.intake import Intake, Told, counted, write_people
from lrsr.experiments.report.reconstructed import draw_reconstruction
from lrsr.files import write_bytes
from lrsr.identities.photographs.person import Photographed, photographed_from
from lrsr.identities.photographs.picture_file import decode, frame
from lrsr.paths import path_if_any, user_path
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.folder import MANIFEST, read_manifest
from lrsr.pictures.image_files import SUFFIXES, read_file
from lrsr.pictures.maker import Maker
from lrsr.pictures.recipe import digest
from lrsr.rendering.scene import Quality as Rendering
from lrsr.tables import read_rows

if TYPE_CHECKING:
    from omegaconf import DictConfig

_SHEET = "sheet.png"
_ROWS = "rows"
_ADULT_YEARS = 18.0

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class Reconstructing:
    """Which photographs are reconstructed, and how.

    Attributes:
        images: A folder with all below it, or one picture. Who is on each is what its
            ``manifest.csv`` says, else the name of the folder that holds it, else of the file.
        intake: How they become people, and which are taken.
        ages: CSV with the columns ``file`` and ``age_years``; who is under 18, or missing there, is
            refused. None: you say that everybody is an adult.
    """

    images: Path
    intake: Intake
    ages: Path | None = None

    @classmethod
    def from_config(cls, config: "DictConfig") -> Self:
        """Read a composed configuration of ``lrsr reconstruct``.

        Raises:
            InputError: A value is wrong; the message names the setting and the remedy.
        """
        images = user_path(config.images, "images")
        wish = "another folder than that of the photographs"
        require(path_if_any(config.out, "out") != images, "out", config.out, wish)
        return cls(
            images=images,
            intake=Intake.from_config(config),
            ages=path_if_any(config.ages, "ages"),
        )

    def run(
        self, folder: Path, cache: RenderCache, *, maker: Maker | None = None, progress: bool = True
    ) -> Path:
        """Reconstruct what is not yet; write ``people.json``, the sheet and the table.

        Stopped at any moment, the same call goes on.

        Args:
            folder: Where they go.
            cache: Where renderings are kept, and what was found on photographs.
            maker: Renders; Mitsuba when None.
            progress: Show a bar.

        Raises:
            InputError: There are no pictures.
        """
        sources = self._sources(folder)
        young = self._too_young(sources)
        looked: list[Told] = []
        rows: list[Path] = []
        for told in self.intake.look(sources, cache, refused=young, progress=progress):
            looked.append(told)
            if not told["why"]:
                rows.append(_drawn(photographed_from(told), folder / _ROWS, cache, maker))
        write_people(folder, looked)
        if rows:
            drawn = np.concatenate([cv2.imread(str(row)) for row in rows], axis=0)
            _, sheet = cv2.imencode(".png", drawn)
            write_bytes(folder / _SHEET, sheet.tobytes(), durable=False)
        logger.info("%s", counted(looked))
        return folder

    def _sources(self, out: Path) -> dict[Path, str]:
        """Return the pictures, and who is on each: as any folder of photographs says it.

        What lies in ``out`` was made of them.

        Raises:
            InputError: There are none, or the manifest cannot be used.
        """
        root = self.images
        if root.is_file():
            return {root: root.stem}
        if (root / MANIFEST).exists():
            return {root / one.file: one.identity_id for one in read_manifest(root)}
        found = [
            file
            for file in sorted(root.rglob("*"))
            if file.is_file()
            and file.suffix.lower() in SUFFIXES
            and not any(part.startswith(".") for part in file.relative_to(root).parts)
            and not file.is_relative_to(out)
        ]
        kinds = ", ".join(suffix[1:] for suffix in SUFFIXES)
        wish = f"a folder with pictures in it ({kinds})"
        require(bool(found), "images", root, wish)
        return {file: file.stem if file.parent == root else file.parent.name for file in found}

    def _too_young(self, sources: Iterable[Path]) -> dict[Path, str]:
        """Return whose age refuses them, and why.

        Raises:
            InputError: The file of ages cannot be read, or lacks a column.
        """
        if self.ages is None:
            logger.warning("ages=null: everybody is an adult on your word")
            return {}
        rows = read_rows(self.ages, ("file", "age_years"), "ages=CSV says how old everybody is")
        ages = {row["file"].strip(): row["age_years"].strip() for _, row in rows}
        root = self.images if self.images.is_dir() else self.images.parent
        found = {one: _why_not(ages.get(one.relative_to(root).as_posix())) for one in sources}
        return {source: why for source, why in found.items() if why}


def _drawn(person: Photographed, folder: Path, cache: RenderCache, maker: Maker | None) -> Path:
    """Return a person's row of the contact sheet; drawn, if it is not there."""
    path = folder / f"{person.sha256[:12]}_{digest(person.record())[:8]}.png"
    if not path.is_file():
        pixels = decode(read_file(Path(person.file)), person.file)
        srgb = frame(pixels, np.array(person.five_px)).srgb
        made = person.reconstruction(Rendering().texture_size)
        row = draw_reconstruction(person, srgb, made, cache, maker=maker)
        write_bytes(path, row, durable=False)
    return path


def _why_not(age_years: str | None) -> str:
    """Return why somebody of an age is refused; empty: they are not.

    Example:
        >>> _why_not("17")
        '17 years old: only adults are taken'
    """
    if age_years is None:
        return "no age known: add a row to ages"
    try:
        years = float(age_years)
    except ValueError:
        return f"age_years={age_years!r} is no number"
    return "" if years >= _ADULT_YEARS else f"{years:g} years old: only adults are taken"
