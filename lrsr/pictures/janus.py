"""Which faces do the lists of an IARPA Janus Benchmark name, and which are one template?

IJB-A (Klare and others, CVPR 2015), IJB-B (Whitelam and others, CVPR Workshops 2017), IJB-C (Maze
and others, ICB 2018) and IJB-S (Kalka and others, BTAS 2018) come with CSV files that have a row
for each face: the template and the subject that it belongs to, a picture and a box in it. Columns
are found by their names, whatever their order and case and whatever others there are.
"""

import csv
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath

import numpy as np

from lrsr.errors import InputError
from lrsr.evaluation.arranged import Templates
from lrsr.pictures.folder import Entry, read_picture
from lrsr.pictures.picture import Picture
from lrsr.pictures.source import Photographs
from lrsr.tables import open_table

_SYNONYMS = {"file": "filename", "frame_num": "frame", "video_filename": "video"}
"""What one of the sets calls a column of another."""
_BOX = ("face_x", "face_y", "face_width", "face_height")
_MEDIA = ("media_id", "sighting_id")
"""What tells which rows of a template are of one medium; the first that is there."""

_REMEDY = "give a CSV file of the set"

_Box = tuple[float, float, float, float]
_Face = tuple[Entry, _Box | None]


@dataclass(frozen=True)
class Cuttings(Photographs):
    """Faces cut out of pictures.

    Attributes:
        boxes_px: Left, top, width and height of each; None: the whole picture.
        margin: How much is left around a box on every side, times its longer side.
    """

    boxes_px: Sequence[_Box | None] = ()
    margin: float = 0.0

    def load(self, start: int, stop: int) -> list[Picture]:
        """Read and cut the faces ``start`` to ``stop - 1``.

        Raises:
            InputError: A picture cannot be read, or a box lies outside it.
        """
        places = zip(self.entries[start:stop], self.boxes_px[start:stop], strict=True)
        return [self._cut(read_picture(self.root, entry), box) for entry, box in places]

    def _cut(self, picture: Picture, box: _Box | None) -> Picture:
        if box is None:
            return picture
        left, top, width, height = box
        around = self.margin * max(width, height)
        high, wide = picture.image.shape[1:]
        columns = _within(left - around, left + width + around, wide)
        rows = _within(top - around, top + height + around, high)
        if not (range(wide)[columns] and range(high)[rows]):
            raise InputError(f"{picture.source} has {wide} x {high} px: the box {box} is not in it")
        return replace(picture, image=picture.image[:, rows, columns].clone())


@dataclass(frozen=True)
class JanusSet:
    """A copy of a set.

    Attributes:
        root: The folder that paths in the lists start from.
        path: Where the picture of a row is, its columns in braces by their small names, such as
            ``{filename}`` or ``frames/{video}_{frame}.jpg``.
        margin: Of the cuttings.
        frames: At most so many rows of one medium of a template, evenly spread; None: all.
    """

    root: Path
    path: str
    margin: float
    frames: int | None = None

    def read(self, file: Path, kind: str) -> tuple[Cuttings, Templates]:
        """Return the faces that a list names, and their templates.

        Args:
            file: The list; seen from ``root`` if it is not absolute.
            kind: "probe" or "gallery".

        Raises:
            InputError: The list cannot be read, lacks a column or a value, a template shows two
                people, or a picture is not there.
        """
        path = self.root / file
        templates: dict[str, str] = {}
        media: dict[tuple[str, str], list[_Face]] = {}
        for line, row in _rows(path):
            where = f"{path}, line {line}"
            template, who = (_needed(row, name, where) for name in ("template_id", "subject_id"))
            if templates.setdefault(template, who) != who:
                raise InputError(
                    f"{where}: template {template} shows {who}, and before {templates[template]}"
                )
            medium = next((row[name] for name in _MEDIA if row.get(name)), f"line {line}")
            entry = Entry(self._file(row, where), who, kind)
            media.setdefault((template, medium), []).append((entry, _box(row, where)))
        kept = {names: _spread(rows, self.frames) for names, rows in media.items()}
        faces = [(*names, *face) for names, rows in kept.items() for face in rows]
        if not faces:
            raise InputError(f"{path} lists nobody: give another file")
        of, medium_of, entries, boxes = (list(column) for column in zip(*faces, strict=True))
        self._check_there(path, entries)
        cuttings = Cuttings(self.root, entries, boxes_px=boxes, margin=self.margin)
        return cuttings, Templates(of, medium_of)

    def _file(self, row: Mapping[str, str], where: str) -> str:
        try:
            file = self.path.format_map(row)
        except (LookupError, ValueError, AttributeError) as error:
            raise InputError(
                f"{where}: ijb.path={self.path}: {error}; wanted columns in braces, of "
                f"{', '.join(row)}"
            ) from error
        place = PurePosixPath(file.replace("\\", "/"))
        if place.is_absolute() or ".." in place.parts:
            raise InputError(f"{where}: {file} leads out of {self.root}; give another file")
        return str(place)

    def _check_there(self, path: Path, entries: Sequence[Entry]) -> None:
        files = dict.fromkeys(entry.file for entry in entries)
        if missing := [file for file in files if not (self.root / file).is_file()]:
            raise InputError(
                f"{path}: {len(missing)} of {len(files)} pictures are not in {self.root}, such as"
                f" {missing[0]}; see ijb.path"
            )


def _rows(path: Path) -> Iterator[tuple[int, dict[str, str]]]:
    """Yield the lines of a list, with their numbers, by small names of columns.

    Raises:
        InputError: It cannot be read, or two of its columns have one name.
    """
    reader = open_table(path, _REMEDY)
    try:
        names = [name.strip().lower() for name in next(reader, [])]
        names = [_SYNONYMS.get(name, name) for name in names]
        for name in filter(None, names):
            if names.count(name) > 1:
                raise InputError(f"{path}, line 1: {names.count(name)} columns {name}; rename one")
        for cells in reader:
            if any(cells):
                values = (cell.strip() for cell in cells)
                yield reader.line_num, dict(zip(names, values, strict=False))
    except csv.Error as error:
        raise InputError(f"cannot read {path}: {error}; {_REMEDY}") from error


def _needed(row: Mapping[str, str], name: str, where: str) -> str:
    if not row.get(name):
        raise InputError(f"{where}: no {name} among {', '.join(row)[:200]}; give another file")
    return row[name]


def _box(row: Mapping[str, str], where: str) -> _Box | None:
    """Return the box of a row; None where it has none at all.

    Raises:
        InputError: It is partly there, no number, or empty.
    """
    texts = [row.get(name, "") for name in _BOX]
    if not any(texts):
        return None
    try:
        left, top, width, height = map(float, texts)
    except ValueError as error:
        raise InputError(f"{where}: {error} in {', '.join(_BOX)}; mend or delete it") from error
    if not (np.isfinite([left, top, width, height]).all() and min(width, height) > 0):
        raise InputError(f"{where}: the box {', '.join(texts)} holds no face; mend or delete it")
    return left, top, width, height


def _spread(rows: Sequence[_Face], most: int | None) -> Sequence[_Face]:
    """Return at most so many faces, evenly spread."""
    if most is None or len(rows) <= most:
        return rows
    return [rows[k * len(rows) // most] for k in range(most)]


def _within(start: float, stop: float, size: int) -> slice:
    """Return the pixels that an interval touches."""
    return slice(max(0, int(np.floor(start))), max(0, min(size, int(np.ceil(stop)))))
