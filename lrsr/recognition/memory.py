"""What was found on these very pictures before? Kept by content, so nothing is looked at twice.

An entry is one batch of pictures: its name is the SHA-256 of the pixels, of all other arrays, and
of what made the numbers (weights, contract, rule). Another picture, network or setting has another
name, so nothing is ever out of date; what is damaged is made again. The folder may be removed.
"""

import hashlib
import io
import json
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lrsr.files import check_file, write_bytes

_FORMAT = 1
"""Part of every name: a change of what the code makes of a picture leaves old entries unread."""

Floats = NDArray[np.float32]


@dataclass(frozen=True)
class Memory:
    """A folder of numbers, safe for any number of processes at once.

    Attributes:
        folder: Made when the first entry is written; None: nothing is kept.
    """

    folder: Path | None = None

    def recall(
        self,
        what: Mapping[str, object],
        arrays: list[NDArray[np.generic]],
        make: Callable[[], Floats],
    ) -> Floats:
        """Return what ``make`` returns, or has returned before for the same arrays.

        Args:
            what: All else that the numbers depend on; JSON-serialisable.
            arrays: All that goes in.
            make: Makes the numbers, one row for each row of the first array.

        Raises:
            InputError: The folder cannot be written.
        """
        if self.folder is None:
            return make()
        digest = hashlib.sha256(json.dumps([_FORMAT, what], sort_keys=True).encode())
        for array in arrays:
            digest.update(f"{array.shape} {array.dtype}".encode())
            digest.update(np.ascontiguousarray(array).tobytes())
        name = digest.hexdigest()
        path = self.folder / name[:2] / f"{name}.npy"
        with suppress(OSError, ValueError, EOFError):
            kept = np.load(check_file(path), allow_pickle=False)
            if kept.dtype == np.float32 and len(kept) == len(arrays[0]):
                return np.asarray(kept)
        made, content = make(), io.BytesIO()
        np.save(content, made, allow_pickle=False)
        write_bytes(path, content.getvalue(), durable=False)
        return made
