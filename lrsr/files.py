"""How is a file written so that a kill at any moment leaves the old one or the new one, whole?

How do several processes share a folder: one at a time, or each in a folder of its own. And how is
a file read that may be none.
"""

import errno
import fcntl
import json
import os
import secrets
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from itertools import count
from pathlib import Path
from typing import Any

from lrsr.errors import InputError

_NO_FILES = {
    stat.S_IFDIR: "a folder",
    stat.S_IFIFO: "a named pipe",
    stat.S_IFSOCK: "a socket",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
}


def check_file(path: Path) -> Path:
    """Return ``path`` if it is a file: a pipe would be waited for, a device may never end.

    Raises:
        OSError: It is something else, or not there.
    """
    path = Path(path)  # a notebook may give a word
    kind = _NO_FILES.get(stat.S_IFMT(path.stat().st_mode))
    if kind is not None:
        raise OSError(errno.EINVAL, f"{kind}, not a file", str(path))
    return path


def why_no_file(path: Path) -> str:
    """Return what a path is in place of a file, such as "is missing"; nothing where it is one."""
    try:
        check_file(path)
    except FileNotFoundError:
        return "is missing"
    except OSError as error:
        return f"is {error.strerror}"
    return ""


def read_bytes(path: Path) -> bytes:
    """Read a file, and nothing that only looks like one; see :func:`check_file`.

    Raises:
        OSError: It cannot be read, or is no file.
    """
    return check_file(path).read_bytes()


def make_folder(folder: Path) -> Path:
    """Make a folder and those above it; one that is there is as good if it can be written.

    Raises:
        InputError: It cannot be made or written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        reason = error.strerror or error
        raise InputError(f"cannot make folder {folder}: {reason}; choose another") from error
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(f"cannot make files in folder {folder}: no permission; choose another")
    return folder


def fresh_folder(folder: Path) -> Path:
    """Make a folder that was not there and return it: ``folder``, or with -2, -3 ... to its name.

    Raises:
        InputError: It cannot be made.
    """
    make_folder(folder.parent)
    mine = folder
    for k in count(2):
        with suppress(FileExistsError):
            mine.mkdir()
            break
        mine = folder.with_name(f"{folder.name}-{k}")
    return mine


@contextmanager
def locked(folder: Path, *, wait: bool = True) -> Iterator[None]:
    """Let one process at a time into such a block; whatever ends it, a kill too, ends the lock.

    Args:
        folder: Is there. On a disk without locks everybody gets in.
        wait: For the other one: to read, change and write. Without: a run's folder is in use.

    Raises:
        InputError: Somebody has it, and ``wait`` is off.
    """
    handle = os.open(folder, os.O_RDONLY)
    try:
        with suppress(OSError):
            try:
                fcntl.flock(handle, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
            except BlockingIOError:
                raise InputError(
                    f"{folder} is in use by another lrsr command: wait for it or choose another"
                ) from None
        yield
    finally:
        os.close(handle)


@contextmanager
def replacing(path: Path, *, durable: bool = True) -> Iterator[Path]:
    """Give a temporary path beside ``path``; rename it over ``path`` when the block succeeds.

    Args:
        path: What is to be written; its folder is made if it is not there.
        durable: Survive a power cut too (the disk confirms, some 10 ms). Without, a process may
            still be killed at any moment; for what carries a checksum or is quickly made again.

    Raises:
        InputError: The folder cannot be written or the disk is full; ``path`` is left as it was.
    """
    temporary: Path | None = None
    lock: int | None = None
    path = Path(path)  # a notebook may give a word
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary, lock = _locked_part(path)
        yield temporary
        if durable:
            with temporary.open("rb") as written:
                os.fsync(written.fileno())
        temporary.replace(path)
        temporary = None
    except OSError as error:
        raise InputError(
            f"cannot write {path}: {error.strerror or error}; free space or choose another folder"
        ) from error
    finally:
        if temporary is not None:
            temporary.unlink(missing_ok=True)
        if lock is not None:
            os.close(lock)


def _locked_part(path: Path) -> tuple[Path, int]:
    """Make and lock an empty file beside ``path``; where a sweep came between, another one."""
    while True:
        part = path.with_name(f".{path.name}.{secrets.token_hex(4)}.part")
        handle = os.open(part, os.O_CREAT | os.O_EXCL | os.O_RDONLY, 0o666)
        with suppress(OSError):  # a disk without locks is never swept
            fcntl.flock(handle, fcntl.LOCK_EX)
        if part.exists():
            return part, handle
        os.close(handle)


def sweep(folder: Path) -> int:
    """Remove what killed writers left in ``folder`` (not below it); return how many files.

    While :func:`replacing` runs it holds a lock on its file, which the system releases when the
    process dies.
    """
    swept = 0
    for part in folder.glob(".*.part"):
        if (lock := _lock(part)) is not None:
            with suppress(OSError):  # such as on a disk that can only be read
                part.unlink()
                swept += 1
            os.close(lock)
    return swept


def _lock(file: Path) -> int | None:
    """Open and lock a file; None where somebody holds it, or that cannot be had on this disk."""
    handle: int | None = None
    with suppress(OSError):
        handle = os.open(file, os.O_RDONLY)
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        return handle
    if handle is not None:
        os.close(handle)
    return None


def write_bytes(path: Path, content: bytes, *, durable: bool = True) -> None:
    """Write beside and rename; see :func:`replacing`."""
    with replacing(path, durable=durable) as temporary:
        temporary.write_bytes(content)


def write_text(path: Path, content: str) -> None:
    """Write UTF-8 beside and rename; see :func:`replacing`."""
    write_bytes(path, content.encode())


def write_json(path: Path, content: Any) -> None:
    """Write JSON (indented, NaN refused) beside and rename; see :func:`replacing`.

    Raises:
        ValueError: ``content`` holds a NaN or an infinity.
    """
    write_text(path, json.dumps(content, indent=2, allow_nan=False) + "\n")
