"""Who renders whom, where several processes fill one cache? Whoever claims a person first.

A claim is a lock on one byte of one file, as all disks that several machines share have them; it
ends with its process, a kill included. Without such locks people are rendered twice, and nothing is
lost: equal recipes are equal bytes.
"""

import fcntl
import hashlib
import os
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Self

from lrsr.errors import InputError
from lrsr.files import make_folder

_FILE = ".claims"
_BYTES = 2**31
"""Places in the file, which stays empty: two things of one place wait for each other, once."""


class Claims:
    """What this process has in hand, for the time of a ``with`` block.

    Args:
        folder: Of the cache; made if need be.

    Raises:
        InputError: It cannot be written.
    """

    def __init__(self, folder: Path) -> None:
        path = make_folder(folder) / _FILE
        try:
            self._file = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        except OSError as error:
            reason = error.strerror or error
            raise InputError(f"cannot write {path}: {reason}; choose another folder") from error

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        os.close(self._file)

    def take(self, what: str, *, wait: bool = False) -> bool:
        """Claim something; return whether it is ours now.

        Args:
            what: Any name; all processes use the same.
            wait: Until whoever has it gives it back or ends.
        """
        try:
            fcntl.lockf(self._file, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB), 1, _place(what))
        except (BlockingIOError, PermissionError):  # EAGAIN or EACCES: somebody has it
            return False
        except OSError:  # a disk without locks
            return True
        return True

    def give_back(self, what: str) -> None:
        """Let others have it."""
        with suppress(OSError):
            fcntl.lockf(self._file, fcntl.LOCK_UN, 1, _place(what))


def _place(what: str) -> int:
    return int.from_bytes(hashlib.sha256(what.encode()).digest()[:8], "big") % _BYTES
