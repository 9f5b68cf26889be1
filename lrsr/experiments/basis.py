"""On whose scores does a likelihood ratio stand? On those of a file that were made the same way."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from lrsr.errors import InputError
from lrsr.evaluation.score_files.system import Name, System

_FILES = ("scores.csv", "scores.csv.gz")
_PARTS = ("recogniser", "landmarks", "method", "option", "ipd_px")


@dataclass(frozen=True)
class Basis:
    """Scores of known people.

    Attributes:
        path: Of the file.
        name: Of the system among those of the file.
        system: The scores.
    """

    path: Path
    name: Name
    system: System

    def describe(self) -> dict[str, Any]:
        """Return what a report must say of it, in plain values."""
        return {"file": str(self.path), **vars(self.name)}


def scores_file(path: Path, key: str = "scores") -> Path:
    """Return the file of scores that a setting names: itself, or the one in a run's folder.

    Args:
        path: What was given.
        key: The setting.

    Raises:
        InputError: The folder holds none.
    """
    if not path.is_dir():
        return path
    for name in _FILES:
        if (path / name).is_file():
            return path / name
    raise InputError(f"{key}={path} holds no scores.csv: give a run's folder, or a file")


def said_by(path: Path, name: Name) -> Name:
    """Return what a file itself says of a system: one without a method is called after it."""
    called_after = name.method == path.name.removesuffix(".gz").rpartition(".")[0]
    return replace(name, method="") if called_after else name


def choose_basis(path: Path, found: Mapping[Name, System], wanted: Name) -> Basis:
    """Choose the scores that were made as a wanted one.

    Args:
        path: Of the file, for messages.
        found: Its systems.
        wanted: What is known of the score; what is empty, or what no system of the file says, does
            not matter.

    Raises:
        InputError: None fits, or several do; the message says which there are.
    """
    fit, says = dict(found), {name: said_by(path, name) for name in found}
    for part in _PARTS:
        value = getattr(wanted, part)
        if not value or not any(getattr(name, part) for name in says.values()):
            continue
        left = {name: one for name, one in fit.items() if getattr(says[name], part) == value}
        if not left:
            there = ", ".join(sorted({getattr(name, part) or "none" for name in fit}))
            raise InputError(f"{path} has no scores of {part}={value}, but of {there}; give others")
        fit = left
    if len(fit) > 1:
        several = {part: sorted({getattr(name, part) for name in fit}) for part in _PARTS}
        part, values = next((p, v) for p, v in several.items() if len(v) > 1)
        raise InputError(f"{path} has scores of {part} {', '.join(values)}: add {part}={values[0]}")
    ((name, system),) = fit.items()
    return Basis(path, name, system)
