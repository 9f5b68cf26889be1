"""How are scores written down? Our own table of every pair, and bob's."""

import csv
import gzip
import io
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np

from lrsr.evaluation.score_files.reading import FURTHER, NATIVE
from lrsr.evaluation.score_files.system import Name, System
from lrsr.files import replacing

_LARGE = 16 << 20
"""Bytes of text from which on our table is gzipped: 16 MiB, some 200,000 scores."""

_BOB = (
    *("probe_subject_id", "probe_template_id", "bio_ref_subject_id", "bio_ref_template_id"),
    "score",
)


class ScoreFile:
    """Our table of scores while it grows, a line a pair: ``scores.csv``, or ``scores.csv.gz``.

    Args:
        folder: Of the run.
        stack: Where the file under way is given back.
        large: From so many bytes on it is gzipped.
    """

    def __init__(self, folder: Path, stack: ExitStack, large: int) -> None:
        self._folder, self._stack, self._large = folder, stack, large
        self._waiting = io.BytesIO()
        self._zipped: gzip.GzipFile | None = None
        self._header: tuple[str, ...] = ()

    def add(self, name: Name, system: System) -> None:
        """Write all pairs of a system, every digit of their scores; NaN = failure to acquire.

        Args:
            name: Of the system.
            system: Its scores; measures of quality are columns, the same for all systems.

        Raises:
            ValueError: It has other measures of quality than the first one.
        """
        header = (*NATIVE, *FURTHER, *_quoted(system.qualities))
        if self._header and header != self._header:
            raise ValueError(f"qualities {list(system.qualities)}: wanted those of the first")
        if not self._header:
            self._write(",".join(header) + "\n")
        self._header = header
        worth = [*zip(*system.qualities.values(), strict=True)] or [()] * len(system.probes)
        source, said = system.source, [name.method, name.landmarks, name.recogniser]
        middle = "".join(f"{text}," for text in _quoted(said))
        option = "".join(f",{text}" for text in _quoted([name.option, name.ipd_px]))
        probes, gallery = _quoted(system.probes), _quoted(system.gallery)
        who = _quoted(source.probe_ids), _quoted(source.gallery_ids)
        for tile in source.tiles():
            mated = np.zeros(tile.scores.shape, dtype=np.intp)
            mated.reshape(-1)[tile.mates] = 1
            flags: Any = mated.tolist()
            values = [["NaN" if s != s else repr(s) for s in row] for row in tile.scores.tolist()]
            for row, scores, same in zip(count(tile.first), values, flags, strict=False):
                part = slice(None) if source.crossed else slice(row, row + 1)
                before, after = f"{probes[row]},", f"{option},{who[0][row]},"
                end = "".join(f",{quality!r}" for quality in worth[row]) + "\n"
                lines = zip(gallery[part], same, scores, who[1][part], strict=True)
                self._write(
                    "".join(
                        f"{before}{name},{m},{middle}{s}{after}{person}{end}"
                        for name, m, s, person in lines
                    )
                )

    def _write(self, text: str) -> None:
        if self._zipped is None and self._waiting.tell() + len(text) >= self._large:
            path = self._stack.enter_context(replacing(self._folder / "scores.csv.gz"))
            raw = self._stack.enter_context(path.open("wb"))
            zipped = gzip.GzipFile("", "wb", 6, raw, mtime=0)  # equal scores, equal bytes
            self._stack.enter_context(zipped)
            zipped.write(self._waiting.getvalue())
            self._zipped = zipped
            self._waiting = io.BytesIO()
        (self._zipped or self._waiting).write(text.encode())

    def finish(self) -> None:
        """Write what is small enough to have waited; remove the other kind of an earlier run."""
        if self._zipped is None:
            path = self._stack.enter_context(replacing(self._folder / "scores.csv"))
            path.write_bytes(self._waiting.getvalue())
        other = "scores.csv" if self._zipped else "scores.csv.gz"
        (self._folder / other).unlink(missing_ok=True)


@contextmanager
def score_file(folder: Path, large: int = _LARGE) -> Iterator[ScoreFile]:
    """Give a table of scores that is there, whole, when the block has succeeded.

    Args:
        folder: Gets ``scores.csv``, or ``scores.csv.gz`` where the text is long.
        large: From so many bytes on it is gzipped.

    Raises:
        InputError: The folder cannot be written or the disk is full.
    """
    with ExitStack() as stack:
        table = ScoreFile(folder, stack, large)
        yield table
        table.finish()


def write_bob(path: Path, system: System) -> None:
    """Write one system's scores as bob.bio.base does, so that its tools and pyeer can check ours.

    Bob calls a pair genuine where both subjects are equal; NaN is its failure to acquire, too.

    Raises:
        InputError: The file cannot be written.
    """
    source = system.source
    with replacing(path) as temporary, temporary.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(_BOB)
        for tile in source.tiles():
            for row, scores in enumerate(tile.scores.tolist(), start=tile.first):
                probe = source.probe_ids[row], system.probes[row]
                part = slice(None) if source.crossed else slice(row, row + 1)
                beside = zip(source.gallery_ids[part], system.gallery[part], scores, strict=True)
                writer.writerows((*probe, *reference) for reference in beside)


def _quoted(cells: Iterable[str]) -> Sequence[str]:
    """Return cells as a CSV holds them: in quotes where they need some."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\0")
    writer.writerows([cell] for cell in cells)
    return ["" if cell == '""' else cell for cell in text.getvalue().split("\0")[:-1]]
