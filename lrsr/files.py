"""How is a file written so that a kill at any moment leaves the old one or the new one, whole?

And how do several processes share a folder: one at a time, or each in a folder of its own.
"""

import fcntl
import json
import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from itertools import chain, count
from pathlib import Path
from typing import Any

from lrsr.errors import InputError


def make_folder(folder: Path) -> Path:
    """Make a folder and those above it; one that is there is as good if it can be written.

    Raises:
        InputError: It cannot be made or written.
    """
    with _making(folder):
        folder.mkdir(parents=True, exist_ok=True)
    if not os.access(folder, os.W_OK | os.X_OK):
        raise InputError(f"cannot make files in folder {folder}: no permission; choose another")
    return folder


def fresh_folder(folder: Path) -> Path:
    """Make a folder that was not there and return it: ``folder``, or with -2, -3 ... to its name.

    Raises:
        InputError: It cannot be made.
    """
    make_folder(folder.parent)
    names = chain([folder.name], (f"{folder.name}-{k}" for k in count(2)))
    with _making(folder):
        return next(path for path in map(folder.with_name, names) if _is_new(path))


def _is_new(folder: Path) -> bool:
    try:
        folder.mkdir()
    except FileExistsError:
        return False
    return True


@contextmanager
def _making(folder: Path) -> Iterator[None]:
    """Say that a folder cannot be made.

    Raises:
        InputError: The block failed.
    """
    try:
        yield
    except OSError as error:
        reason = error.strerror or error
        raise InputError(f"cannot make folder {folder}: {reason}; choose another") from error


@contextmanager
def claim(folder: Path) -> Iterator[None]:
    """Keep a folder to this process; whatever ends it, a kill too, gives the folder back.

    Raises:
        InputError: Another process has it, or the folder cannot be written.
    """
    with _held(folder / ".claimed", fcntl.LOCK_NB):
        yield


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Wait until no other process is in such a block of the same folder: read, change, write.

    Raises:
        InputError: The folder cannot be written.
    """
    with _held(folder / ".locked", 0):
        yield


@contextmanager
def _held(path: Path, how: int) -> Iterator[None]:
    """Hold the lock of a file that is there only as long as somebody holds or wants it."""
    while (handle := _locked_file(path, how)) is None:
        pass
    try:
        yield
    finally:
        with suppress(OSError):
            path.unlink()  # while it is locked: who waits for it finds it gone and makes another
        os.close(handle)


def _locked_file(path: Path, how: int) -> int | None:
    """Make, open and lock a file; None where who held it has removed it.

    Raises:
        InputError: It cannot be made, or is held and ``how`` is not to wait.
    """
    try:
        handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
    except OSError as error:
        raise InputError(f"cannot write {path}: {error.strerror}; choose another folder") from error
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | how)
    except BlockingIOError as error:
        os.close(handle)
        raise InputError(
            f"{path.parent} is in use by another lrsr command: wait for it or choose another folder"
        ) from error
    except OSError:
        return handle  # a disk without locks
    with suppress(FileNotFoundError):
        if os.path.samestat(os.fstat(handle), path.stat()):
            return handle
    os.close(handle)
    return None


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
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        lock = _lock(path.parent, fcntl.LOCK_SH)
        temporary = path.with_name(f".{path.name}.{secrets.token_hex(4)}.part")
        temporary.touch(exist_ok=False)
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


def sweep(folder: Path) -> int:
    """Remove what killed writers left in ``folder`` (not below it); return how many files.

    While :func:`replacing` runs it holds a shared lock on the folder, which the system releases
    when the process dies: if anyone is still writing there, nothing is removed.
    """
    lock = _lock(folder, fcntl.LOCK_EX | fcntl.LOCK_NB)
    if lock is None:
        return 0
    try:
        stale = list(folder.glob(".*.part"))
        for part in stale:
            with suppress(OSError):  # such as on a disk that can only be read
                part.unlink(missing_ok=True)
        return len(stale)
    finally:
        os.close(lock)


def _lock(folder: Path, kind: int) -> int | None:
    """Open and lock a folder; None where that cannot be had, or not on this disk at all."""
    handle: int | None = None
    with suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        fcntl.flock(handle, kind)
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
