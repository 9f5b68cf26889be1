"""Which files of a folder did we make, and of what? So nothing of others is overwritten.

``upscaled.jsonl`` has a line for each picture that was ever written, appended before the picture
is: whatever moment a kill chooses, a file of ours is known as ours.
"""

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from lrsr.errors import InputError
from lrsr.files import write_bytes
from lrsr.journal import add_lines, read_lines
from lrsr.onnx import sha256_of

RECORD = "upscaled.jsonl"


class Made:
    """What one folder holds.

    Args:
        folder: Where the record lies, and the files at or below it.

    Raises:
        InputError: The record cannot be read.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._rows: dict[str, list[dict[str, Any]]] = {}
        for row in read_lines(folder / RECORD):
            if "file" in row:
                self._rows.setdefault(row["file"], []).append(row)

    def source_of(self, target: Path) -> str | None:
        """Return what a file was last made of; None where it is not ours."""
        rows = self._rows.get(self._name(target))
        return str(rows[-1]["source"]) if rows else None

    def is_done(self, target: Path, source: bytes, made_by: Mapping[str, Any]) -> bool:
        """Tell whether a file is there, as it would be made again."""
        row = self._rows.get(self._name(target), [{}])[-1]
        same = row.get("source_sha256") == _digest(source) and row.get("made_by") == made_by
        return same and target.is_file() and sha256_of(target) == row["sha256"]

    def check_free(self, target: Path) -> None:
        """Refuse to overwrite what we have not made, or what was changed since.

        Raises:
            InputError: The file is there, and its bytes are none that we wrote.
        """
        ours = {row["sha256"] for row in self._rows.get(self._name(target), [])}
        if target.exists() and (not target.is_file() or sha256_of(target) not in ours):
            raise InputError(
                f"{target} is there, and lrsr upscale did not make it so: move it, or choose"
                " another out"
            )

    def write(
        self, target: Path, content: bytes, source: Path, made_of: bytes, made_by: Mapping[str, Any]
    ) -> None:
        """Record a file and write it.

        Args:
            target: The file.
            content: What it is to hold.
            source: What it is made of.
            made_of: The bytes of that.
            made_by: How, in plain values.

        Raises:
            InputError: See :meth:`check_free`; or the disk is full.
        """
        self.check_free(target)
        name = self._name(target)
        row = {
            "file": name,
            "sha256": _digest(content),
            "source": str(source),
            "source_sha256": _digest(made_of),
            "made_by": dict(made_by),
        }
        add_lines(self._folder / RECORD, [row])
        self._rows.setdefault(name, []).append(row)
        write_bytes(target, content, durable=False)

    def _name(self, target: Path) -> str:
        return target.relative_to(self._folder).as_posix()


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
