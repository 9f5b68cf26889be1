"""What has a long run found so far? A line each, so that a kill at any moment loses one at most."""

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lrsr.errors import InputError
from lrsr.files import read_bytes


@dataclass(frozen=True)
class Journal:
    """A file of lines of JSON, for one set of settings.

    Attributes:
        path: The file; its folder is made with the first line.
        asked: All that decides about what is noted, in plain values.
    """

    path: Path
    asked: Mapping[str, Any]

    def read(self) -> list[dict[str, Any]]:
        """Return what was noted, in order; a line that a kill cut short is left out.

        Raises:
            InputError: It was noted under other settings, or the file cannot be read.
        """
        lines = read_lines(self.path)
        if not lines:
            self.path.unlink(missing_ok=True)  # of a kill, or a full disk, at its first line
            return []
        before, now = lines[0], json.loads(json.dumps(self.asked))
        for name in now.keys() | before.keys():
            if before.get(name) != now.get(name):
                raise InputError(
                    f"{self.path.parent} holds what another {name} made: choose another out, or"
                    " remove it"
                )
        return lines[1:]

    def note(self, told: Mapping[str, Any]) -> None:
        """Add a line.

        Raises:
            InputError: The file cannot be written.
        """
        add_lines(self.path, [told] if self.path.exists() else [self.asked, told])


def read_lines(path: Path) -> list[dict[str, Any]]:
    """Return what the lines of a file say, in order; one that a kill cut short is left out.

    Raises:
        InputError: It is there and cannot be read.
    """
    try:
        text = read_bytes(path).decode() if path.exists() else ""
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"cannot read {path} ({error}): choose another out") from error
    return [line for line in map(_parsed, text.split("\n")) if line is not None]


def add_lines(path: Path, told: Iterable[Mapping[str, Any]]) -> None:
    """Add lines to a file, which is made if need be: after one that was cut short, too.

    In ASCII, so that no letter can be cut in two.

    Raises:
        InputError: It cannot be written.
    """
    text = "".join(f"\n{json.dumps(line)}" for line in told)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("a", encoding="utf-8") as file:
            file.write(text)
    except OSError as error:
        raise InputError(
            f"cannot write {path}: {error.strerror or error}; free space or choose another folder"
        ) from error


def _parsed(line: str) -> dict[str, Any] | None:
    try:
        told = json.loads(line)
    except ValueError:
        return None
    return told if isinstance(told, dict) else None
