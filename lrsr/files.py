"""How is a file written so that a kill at any moment leaves the old one or the new one, whole?"""

import fcntl
import json
import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from lrsr.errors import InputError


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
