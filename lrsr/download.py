"""How does a large file come over a bad line, whole and the right one? Piece by piece, checked."""

import re
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tqdm import tqdm

from lrsr.errors import InputError
from lrsr.files import make_folder
from lrsr.onnx import sha256_of

if TYPE_CHECKING:
    import requests

_TRIES = 5
"""In a row without a new byte."""
_PAUSE_S = 1.0
_CHUNK = 1 << 14
"""Bytes that are lost when the line breaks, at most."""
_LARGEST = 4 << 30
_SOON = {408, 429, 500, 502, 503, 504}
"""HTTP statuses that another try may mend."""


def download(
    url: str,
    path: Path,
    *,
    sha256: str = "",
    size: int = 0,
    stall_s: float = 30.0,
    progress: bool = True,
) -> Path:
    """Fetch a file; what an earlier call left half done is gone on with.

    Proxies and certificates are those of the environment (``HTTPS_PROXY``, ``NO_PROXY``,
    ``REQUESTS_CA_BUNDLE``).

    Args:
        url: Of the file, http or https.
        path: Where it is to lie; until it is whole and right it is ``NAME.partial``.
        sha256: Of its bytes; empty: not known.
        size: Their number; 0: not known.
        stall_s: How long nothing may come before another try, seconds.
        progress: Show a bar on stderr.

    Returns:
        ``path``.

    Raises:
        InputError: It cannot be had, or is not what was asked for; then nothing is left of it.
    """
    make_folder(path.parent)
    partial = path.with_name(f"{path.name}.partial")
    with _bar(path.name, size, progress) as bar:
        _fetch_all(url, partial, size, stall_s, bar)
    got, digest = partial.stat().st_size, sha256_of(partial)
    wrong = (size and got != size and f"has {got} bytes, wanted {size}") or (
        sha256 and digest != sha256 and f"has sha256 {digest}, wanted {sha256}"
    )
    if wrong:
        partial.unlink()
        raise InputError(f"{url} {wrong}: it is not that file; try again or give a mirror")
    return partial.replace(path)


@contextmanager
def _bar(name: str, size: int, progress: bool) -> Iterator[Any]:
    with tqdm(
        desc=name, total=size or None, unit="B", unit_scale=True, disable=not progress
    ) as bar:
        yield bar


def _fetch_all(url: str, partial: Path, size: int, stall_s: float, bar: Any) -> None:
    import requests  # a tenth of a second that other commands need not pay

    tries, most = 0, size or _LARGEST
    with requests.Session() as session:
        while True:
            before = partial.stat().st_size if partial.exists() else 0
            try:
                if _fetch_some(session, url, partial, most, stall_s, bar):
                    return
                error: Exception = OSError("it ended early")
            except ValueError as wrong:  # requests' word for what is no address
                raise InputError(f"{url}: no address ({wrong}); give another") from wrong
            except requests.RequestException as failed:
                error = failed
            after = partial.stat().st_size if partial.exists() else 0
            tries = 0 if after > before else tries + 1
            if tries >= _TRIES:
                why = " ".join(str(error).split())[:200]
                raise InputError(
                    f"{url}: {after} bytes came, and in {_TRIES} tries no more ({why});"
                    " the same command goes on from there"
                ) from error
            time.sleep(_PAUSE_S * tries)


def _fetch_some(
    session: "requests.Session", url: str, partial: Path, most: int, stall_s: float, bar: Any
) -> bool:
    """Ask for what is missing and append it; tell whether it is whole, as far as the server says.

    Raises:
        InputError: The server refuses for good, or sends more than wanted.
    """
    start = partial.stat().st_size if partial.exists() else 0
    headers = {"Accept-Encoding": "identity"} | ({"Range": f"bytes={start}-"} if start else {})
    with session.get(url, headers=headers, stream=True, timeout=stall_s) as response:
        if response.status_code == 416:  # nothing behind what is there: whole, or of another file
            total = re.fullmatch(r"bytes \*/(\d+)", response.headers.get("Content-Range", ""))
            whole = total is not None and int(total[1]) == start
            if not whole:
                partial.unlink()
            return whole
        if response.status_code in _SOON:
            response.raise_for_status()
        if response.status_code not in (200, 206):
            raise InputError(f"{url}: the server says {response.status_code} {response.reason}")
        follows = response.headers.get("Content-Range", "").startswith(f"bytes {start}-")
        resumed = response.status_code == 206 and follows
        if response.status_code == 206 and not resumed:
            partial.unlink(missing_ok=True)  # another part than was asked for: from the start
            return False
        told = response.headers.get("Content-Length", "")
        bar.reset(int(told) + start * resumed if told.isdigit() else bar.total)
        bar.update(start * resumed)
        with partial.open("ab" if resumed else "wb") as file:
            for chunk in response.iter_content(_CHUNK):
                file.write(chunk)
                bar.update(len(chunk))
                if file.tell() > most:
                    break
    got = partial.stat().st_size
    if got > most:
        partial.unlink()
        raise InputError(f"{url} sends more than {most} bytes: it is not that file")
    return got == most or most == _LARGEST
