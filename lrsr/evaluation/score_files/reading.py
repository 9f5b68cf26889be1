"""Which scores does a file hold? Seven formats, declared, or known by their first line alone.

A file may be gzipped (its name ends in .gz), in UTF-8 or behind a mark in UTF-16. A score is higher
the more alike two pictures are; ``distance=true`` turns the sign. What is empty, ``nan`` or ``NaN``
is a failure to acquire. Nothing is guessed from the scores.
"""

import csv
import gzip
import io
import math
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from lrsr.errors import InputError
from lrsr.evaluation.pairs import PairScores
from lrsr.evaluation.score_files.system import Listing, Name, Pictures, System
from lrsr.files import read_bytes

NATIVE = ("probe", "gallery", "mated", "method", "landmarks", "recogniser", "score")
"""Columns of our own files; the last is needed, and ``mated`` or whom both pictures show."""

FURTHER = ("option", "ipd_px", "probe_subject", "gallery_subject")
_SUBJECTS = FURTHER[2:]
_BOB = ("bio_ref_subject_id", "probe_subject_id", "score")
_INSIGHTFACE = ("image1_path", "image2_path", "label", "score")
FORMATS = ("native", "matrix", "bob", "bob_columns", "insightface", "lfw", "genuine_impostor")
_MATED = {"1": 1, "0": 0, "true": 1, "false": 0}
_HINT = f"say which of {', '.join(FORMATS)} it is by format=..."


@dataclass
class _Reader:
    """Reads files of one run.

    Attributes:
        pictures: Names met so far.
        listings: Pairs of each system so far.
        anonymous: Systems of files that name no pictures.
        qualities: Columns that hold a measure of the probe.
        sign: -1 where scores are distances.
    """

    qualities: Sequence[str] = ()
    sign: float = 1.0
    pictures: Pictures = field(default_factory=Pictures)
    listings: dict[Name, Listing] = field(default_factory=dict)
    anonymous: dict[Name, System] = field(default_factory=dict)

    def listing(self, name: Name, path: Path) -> Listing:
        if name not in self.listings:
            self.listings[name] = Listing(path, self.pictures, self.qualities)
        return self.listings[name]

    def score(self, text: str) -> float:
        """Return a score.

        Raises:
            ValueError: The text is none.
        """
        score = _number(text, "score") if text.strip() else math.nan
        if math.isinf(score):
            raise ValueError(f"score {text[:40]} is infinite: give nan for a failure to acquire")
        return self.sign * score


def read_scores(
    files: Sequence[Path],
    format: str | None = None,  # what the setting is called
    *,
    qualities: Sequence[str] = (),
    distance: bool = False,
) -> dict[Name, System]:
    """Read the scores of one system or several.

    Args:
        files: At least one. Of ``genuine_impostor``: genuine and impostor scores by turns.
        format: One of :data:`FORMATS`; None: told by the first line of each file.
        qualities: Columns of native files that hold a measure of the probe, higher = better.
        distance: The numbers are distances: their sign is turned.

    Raises:
        InputError: A file cannot be read or is no such file; the message names file, line, value
            and remedy.
    """
    if not files:
        raise InputError("no file of scores: give at least one")
    if format is not None and format not in FORMATS:
        raise InputError(f"format={format}: wanted one of {', '.join(FORMATS)}")
    reader = _Reader(qualities, -1.0 if distance else 1.0)
    if format == "genuine_impostor":
        _read_genuine_impostor(reader, [*map(Path, files)])
        return reader.anonymous
    for path in map(Path, files):  # a notebook may give words
        lines = _lines_of(path)
        kind = format or _format_of(path, lines[0])
        if qualities and kind != "native":
            raise InputError(
                f"{path}: quality={','.join(qualities)} needs a native file, not {kind}"
            )
        _READERS[kind](reader, path, lines)
    mated = [listing.mated() for listing in reader.listings.values()]
    pairs = tuple(np.concatenate(side) for side in zip(*mated, strict=True))
    people = reader.pictures.people((pairs[0], pairs[1]))
    return {name: listing.system(people) for name, listing in reader.listings.items()}


def _lines_of(path: Path) -> list[str]:
    """Return the lines of a file.

    Raises:
        InputError: It cannot be read, is no text, or is empty.
    """
    try:
        content = read_bytes(path)
        content = gzip.decompress(content) if path.suffix == ".gz" else content
        marked = content.startswith((b"\xff\xfe", b"\xfe\xff"))
        lines = content.decode("utf-16" if marked else "utf-8-sig").splitlines()
    except (EOFError, zlib.error) as error:
        raise InputError(f"cannot read {path}: {error}; copy it again") from error
    except OSError as error:
        raise InputError(
            f"cannot read {path}: {error.strerror or error}; choose another"
        ) from error
    except UnicodeDecodeError as error:
        raise InputError(f"cannot read {path}: {error}; save it as UTF-8 text") from error
    if not any(line.strip() for line in lines):
        raise InputError(f"{path} is empty: give a file that holds scores")
    return lines


def _format_of(path: Path, first: str) -> str:
    """Return the format that the first line tells.

    Raises:
        InputError: It tells none.
    """
    names = _cells(first)
    for kind, columns in (("bob", _BOB), ("insightface", _INSIGHTFACE)):
        if set(columns) <= {*names}:
            return kind
    if {"probe", "gallery", "score"} <= {*names}:
        return "native"
    words = first.split()
    if len(words) in (1, 2) and all(word.isdigit() for word in words):
        return "lfw"
    if len(names) > 1 and names[0] in ("", "probe"):
        return "matrix"
    raise InputError(f"{path}, line 1: {first[:60]!r} is no known header; {_HINT}")


def _cells(line: str) -> list[str]:
    return [cell.strip() for cell in next(csv.reader([line], delimiter=_separator(line)))]


def _separator(line: str) -> str:
    return max(",;\t", key=line.count)


def _table(path: Path, lines: list[str]) -> Iterator[tuple[int, list[str]]]:
    """Yield the number and the cells of every line that is not blank.

    Raises:
        InputError: A line is no part of a table.
    """
    text = io.StringIO("\n".join(lines), newline="")
    reader = csv.reader(text, delimiter=_separator(lines[0]), strict=True)
    try:
        for cells in reader:
            if any(cell.strip() for cell in cells):
                yield reader.line_num, cells
    except csv.Error as error:
        raise InputError(f"{path}, line {reader.line_num}: {error}; make it again") from error


def _columns(
    path: Path, lines: list[str], needed: Sequence[str]
) -> tuple[dict[str, int], Iterator[tuple[int, list[str]]]]:
    """Return where each column is, and the lines below the header.

    Raises:
        InputError: A column is missing or there twice.
    """
    rows = _table(path, lines)
    names = [name.strip() for name in next(rows)[1]]
    for name in needed:
        if names.count(name) != 1:
            raise InputError(
                f"{path}, line 1: {names.count(name)} columns {name}; wanted one, and there are "
                f"{', '.join(names)[:200]}"
            )
    return {name: place for place, name in enumerate(names)}, rows


def _each(
    path: Path, rows: Iterator[tuple[int, list[str]]], width: int, take: Callable[..., None]
) -> None:
    """Hand over line after line, of which each has as many cells.

    Raises:
        InputError: A line has another number of cells, or something in it is not as it should be.
    """
    number = 0
    for number, cells in rows:
        try:
            _check_width(cells, width)
            take(number, cells)
        except ValueError as error:
            raise InputError(f"{path}, line {number}: {error}; mend the line") from error
    if number == 0:
        raise InputError(f"{path} holds no scores below its header: add some")


def _check_width(cells: Sequence[str], width: int) -> None:
    """Refuse a line that is too short or too long.

    Raises:
        ValueError: It is.
    """
    if len(cells) != width:
        raise ValueError(f"{len(cells)} cells, wanted {width}")


def _read_native(reader: _Reader, path: Path, lines: list[str]) -> None:
    column, rows = _columns(path, lines, ("probe", "gallery", "score", *reader.qualities))
    subjects = set(_SUBJECTS) <= column.keys()
    if not subjects and "mated" not in column:
        raise InputError(
            f"{path}, line 1: who is who? Add a column mated (1 or 0), or {' and '.join(_SUBJECTS)}"
        )
    probe, gallery, score = (column[name] for name in ("probe", "gallery", "score"))
    keys = [(name, column[name]) for name in Name.__dataclass_fields__ if name in column]
    mated, qualities = column.get("mated"), [column[name] for name in reader.qualities]
    people = [column[name] for name in _SUBJECTS] if subjects else []
    parts = ("probe", "gallery") if subjects else ("", "")  # without, a name is one picture
    names: dict[tuple[str, ...], Listing] = {}

    def take(number: int, cells: list[str]) -> None:
        key = tuple(cells[place].strip() for _, place in keys)
        if key not in names:
            name = Name(**{name: text for (name, _), text in zip(keys, key, strict=True)})
            names[key] = reader.listing(name if name.method else _called(name, path), path)
        who = [cells[place].strip() for place in people] or ["", ""]  # who is on it, else by links
        names[key].add(
            number,
            reader.pictures.number(cells[probe], who[0], parts[0]),
            reader.pictures.number(cells[gallery], who[1], parts[1]),
            reader.score(cells[score]),
            mated=-1 if mated is None else _truth(cells[mated]),
            qualities=[_number(cells[k], "quality") for k in qualities],
        )

    _each(path, rows, len(column), take)


def _called(name: Name, path: Path) -> Name:
    """Name a system after its file where nothing else names it."""
    stem = path.name.removesuffix(".gz").rpartition(".")[0] or path.name
    return Name(name.option, name.ipd_px, stem, name.landmarks, name.recogniser)


def _read_bob(reader: _Reader, path: Path, lines: list[str]) -> None:
    column, rows = _columns(path, lines, _BOB)
    listing = reader.listing(_called(Name(), path), path)
    reference, probe, score = (column[name] for name in _BOB)
    template = [
        column.get(name, column[subject])
        for name, subject in (
            ("bio_ref_template_id", "bio_ref_subject_id"),
            ("probe_template_id", "probe_subject_id"),
        )
    ]

    def take(number: int, cells: list[str]) -> None:
        listing.add(
            number,
            reader.pictures.number(cells[template[1]], cells[probe], "probe"),
            reader.pictures.number(cells[template[0]], cells[reference], "gallery"),
            reader.score(cells[score]),
        )

    _each(path, rows, len(column), take)


def _read_bob_columns(reader: _Reader, path: Path, lines: list[str]) -> None:
    """Read the older text: claimed id, [model,] real id, probe, score, parted by blanks.

    Raises:
        InputError: The first line has another number of columns.
    """
    width = len(lines[0].split())
    if width not in (4, 5):
        raise InputError(f"{path}, line 1: {width} columns, wanted 4 or 5 of bob's text; {_HINT}")
    listing = reader.listing(_called(Name(), path), path)

    def take(number: int, cells: list[str]) -> None:
        claimed, model, real, probe, score = cells if width == 5 else (cells[0], *cells)
        listing.add(
            number,
            reader.pictures.number(probe, real, "probe"),
            reader.pictures.number(model, claimed, "gallery"),
            reader.score(score),
        )

    _each(path, _words(lines), width, take)


def _words(lines: list[str], skip: int = 0) -> Iterator[tuple[int, list[str]]]:
    for number, line in enumerate(lines[skip:], start=skip + 1):
        if line.strip():
            yield number, line.split("\t") if "\t" in line.strip() else line.split()


def _read_insightface(reader: _Reader, path: Path, lines: list[str]) -> None:
    """Read pairs of files and whether they show one person; a column more than insightface's."""
    column, rows = _columns(path, lines, _INSIGHTFACE)
    listing = reader.listing(_called(Name(), path), path)
    first, second, label, score = (column[name] for name in _INSIGHTFACE)

    def take(number: int, cells: list[str]) -> None:
        left, right = (reader.pictures.number(cells[place]) for place in (first, second))
        listing.add(number, left, right, reader.score(cells[score]), mated=_truth(cells[label]))

    _each(path, rows, len(column), take)


def _read_lfw(reader: _Reader, path: Path, lines: list[str]) -> None:
    """Read pairs.txt with a score at the end of each line: ``name i j s``, ``name i other j s``."""
    listing = reader.listing(_called(Name(), path), path)
    header = all(word.isdigit() for word in lines[0].split())

    def take(number: int, cells: list[str]) -> None:
        if len(cells) not in (4, 5) or not (cells[1].isdigit() and cells[-2].isdigit()):
            raise ValueError(
                f"{' '.join(cells)[:60]!r}: wanted NAME I J SCORE or NAME I OTHER J SCORE"
            )
        pair = [(cells[0], cells[1]), (cells[-3] if len(cells) == 5 else cells[0], cells[-2])]
        left, right = (
            reader.pictures.number(f"{name}/{name}_{int(place):04d}.jpg", name)
            for name, place in pair
        )
        listing.add(number, left, right, reader.score(cells[-1]))

    for row in _words(lines, skip=int(header)):
        _each(path, iter([row]), len(row[1]), take)


def _read_matrix(reader: _Reader, path: Path, lines: list[str]) -> None:
    """Read a row a probe and a column a gallery image; equal identities are mated.

    Raises:
        InputError: Two columns have one name.
    """
    rows = _table(path, lines)
    ids = [name.strip() for name in next(rows)[1]][1:]
    if len({*ids}) < len(ids):
        twice = next(name for name in ids if ids.count(name) > 1)
        raise InputError(f"{path}, line 1: two columns {twice}; a matrix has one for each person")
    gallery = [reader.pictures.number(name, name, "gallery") for name in ids]
    listing = reader.listing(_called(Name(), path), path)

    def take(number: int, cells: list[str]) -> None:
        who = cells[0].strip()
        probe = reader.pictures.number(who, who, ("probe", number))
        for place, text in zip(gallery, cells[1:], strict=True):
            listing.add(number, probe, place, reader.score(text))

    _each(path, rows, len(ids) + 1, take)


def _read_genuine_impostor(reader: _Reader, files: Sequence[Path]) -> None:
    """Read two files a system, a line a score, as pyeer takes them; ids before it are not read.

    Raises:
        InputError: The number of files is odd, or a line ends in no score.
    """
    if len(files) % 2:
        raise InputError(f"{len(files)} files: give genuine and impostor scores by turns")
    for genuine, impostor in zip(files[::2], files[1::2], strict=True):
        scores = [_plain_scores(reader, path) for path in (genuine, impostor)]
        own, other = (len(part) for part in scores)
        left = [f"pair {k}" for k in range(own + other)]
        right = [*left[:own], *(f"other of {name}" for name in left[own:])]
        source = PairScores(np.array([*scores[0], *scores[1]]), left, right, people_known=False)
        reader.anonymous[_called(Name(), genuine)] = System(source, left, right)


def _plain_scores(reader: _Reader, path: Path) -> list[float]:
    scores: list[float] = []

    def take(_: int, cells: list[str]) -> None:
        scores.append(reader.score(cells[-1]))

    for row in _words(_lines_of(path)):
        _each(path, iter([row]), len(row[1]), take)
    return scores


def _number(text: str, name: str) -> float:
    """Return a number; nothing is a NaN.

    Raises:
        ValueError: The text is none.
    """
    try:  # Python reads 1_000 as a thousand, which no table means
        return float(text.replace("_", " ")) if text.strip() else math.nan
    except ValueError:
        hint = ": save the table with decimal points" if "," in text else ""
        raise ValueError(f"{name} {text[:40]!r} is no number such as 0.25{hint}") from None


def _truth(text: str) -> int:
    """Return 1 for mated, 0 for not.

    Raises:
        ValueError: The text is neither.
    """
    if text.strip().lower() not in _MATED:
        raise ValueError(f"mated {text[:40]!r}: wanted 1 or 0")
    return _MATED[text.strip().lower()]


_READERS: Mapping[str, Callable[[_Reader, Path, list[str]], None]] = {
    "native": _read_native,
    "matrix": _read_matrix,
    "bob": _read_bob,
    "bob_columns": _read_bob_columns,
    "insightface": _read_insightface,
    "lfw": _read_lfw,
}
