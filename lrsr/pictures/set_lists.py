"""Which pictures do the lists of a published set name? Names and numbers of .mat files, no code."""

import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from lrsr.errors import InputError
from lrsr.files import check_file
from lrsr.pictures.folder import Entry
from lrsr.pictures.source import Photographs


def read_listing(path: Path, names: str, ids: str) -> list[tuple[str, str]]:
    """Read file names and whom each shows.

    Args:
        path: Of the .mat file.
        names: The variable with the names, a cell of text each.
        ids: That with as many whole numbers.

    Raises:
        InputError: The file cannot be read, lacks a variable, or a variable holds something else.
    """
    found = _read(path, names, ids)
    files, numbers = _texts(path, names, found[names]), np.ravel(found[ids])
    whole = numbers.dtype.kind in "uif" and (numbers == np.floor(numbers)).all()
    if len(files) != numbers.size or not whole:
        raise InputError(
            f"{path}: {len(files)} {names} and {numbers.size} {ids}: wanted a whole number for"
            " each; download it again"
        )
    return [(file, str(int(number))) for file, number in zip(files, numbers, strict=True)]


def read_pairs(path: Path, name: str) -> list[tuple[str, str]]:
    """Read pairs of file names.

    Args:
        path: Of the .mat file.
        name: The variable, two cells of text a line.

    Raises:
        InputError: The file cannot be read, lacks the variable, or it holds something else.
    """
    files = _texts(path, name, _read(path, name)[name])
    if len(files) % 2:
        raise InputError(f"{path}: {len(files)} {name}: wanted two a line; download it again")
    return list(zip(files[::2], files[1::2], strict=True))


def photographs_of(
    root: Path, folder: str, listing: list[tuple[str, str]], kind: str
) -> Photographs:
    """Return pictures of a folder that a list names, in its order.

    Args:
        root: Of the set.
        folder: Relative to it.
        listing: File and identity of each.
        kind: "probe" or "gallery".

    Raises:
        InputError: A picture is not there.
    """
    there = {path.name for path in (root / folder).glob("*")}
    if missing := [file for file, _ in listing if file not in there]:
        raise InputError(
            f"{root / folder}: {len(missing)} of {len(listing)} pictures are not there, such as"
            f" {missing[0]}; unpack the set again"
        )
    return Photographs(root, [Entry(f"{folder}/{file}", who, kind) for file, who in listing])


def _read(path: Path, *names: str) -> dict[str, Any]:
    """Return variables of a .mat file.

    Raises:
        InputError: It cannot be read, or lacks one.
    """
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    broken = (MatReadError, ValueError, TypeError, NotImplementedError, LookupError)
    try:
        found: dict[str, Any] = loadmat(check_file(path), variable_names=names, squeeze_me=True)
    except (OSError, *broken, struct.error, zlib.error) as error:
        raise InputError(f"cannot read {path}: {error}; download it again") from error
    for name in names:
        if name not in found:
            raise InputError(f"{path}: no variable {name}; is it the file of the set?")
    return found


def _texts(path: Path, name: str, value: Any) -> list[str]:
    """Return text row by row; each must be a plain file's name, so that nothing leads elsewhere.

    Raises:
        InputError: One is not.
    """
    texts: list[str] = np.ravel(value).tolist()
    for text in texts:
        if not isinstance(text, str) or not text or Path(text).name != text:
            told = str(text)[:80]
            raise InputError(f"{path}: {name} names {told!r}: wanted a file's plain name")
    return texts
