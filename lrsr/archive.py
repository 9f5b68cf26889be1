"""How are single files taken out of an archive that anybody may have made? As bytes, by name."""

import lzma
import tarfile
import zipfile
import zlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path, PurePosixPath
from typing import IO, NamedTuple

from lrsr.errors import InputError
from lrsr.files import replacing

_LARGEST = 4 << 30
_CHUNK = 1 << 20
_UNIX_FILE = (0, 8)
"""How a ZIP file's member says that it is a plain file of Unix, or does not say what it is."""

_DAMAGES = (
    *(zipfile.BadZipFile, tarfile.TarError, zlib.error, lzma.LZMAError),
    *(EOFError, RuntimeError, NotImplementedError),  # cut; a password; a method of others
)


class _Member(NamedTuple):
    path: str
    plain: bool
    open: Callable[[], IO[bytes] | None]


def take_files(archive: Path, wanted: Mapping[str, Path], *, largest: int = _LARGEST) -> None:
    """Write some files of an archive; nothing else of it touches the disk, nothing is run.

    Args:
        archive: A ZIP file (a wheel is one) or a tar file, compressed or not.
        wanted: Where each is to lie, by its name in the archive, in whatever folder it is there.
        largest: Bytes of one of them, at most.

    Raises:
        InputError: It is no such archive or is damaged; a file is not in it, is there twice, is a
            link or none, leaves its folder, or is too large. What was written before stays.
    """
    with _members(archive) as members:
        found: dict[str, _Member] = {}
        for member in members:
            path = PurePosixPath(member.path)
            if path.name not in wanted:
                continue
            if not member.plain or path.is_absolute() or ".." in path.parts:
                raise InputError(f"{archive}: {path} is a link, no file, or leaves its folder")
            if path.name in found:
                raise InputError(f"{archive}: {path.name} is in it twice; get another")
            found[path.name] = member
        if missing := sorted(set(wanted) - set(found)):
            raise InputError(f"{archive}: {missing[0]} is not in it; get another")
        for name, target in wanted.items():
            with replacing(target) as part, part.open("wb") as out:
                _copy(found[name], out, f"{archive}: {name}", largest)


def _copy(member: _Member, out: IO[bytes], name: str, largest: int) -> None:
    inside = member.open()
    if inside is None:
        raise InputError(f"{name} is no file")
    with inside:
        while chunk := inside.read(_CHUNK):
            if out.tell() + len(chunk) > largest:
                raise InputError(f"{name} has more than {largest} bytes; get another")
            out.write(chunk)


@contextmanager
def _members(archive: Path) -> Iterator[list[_Member]]:
    try:
        if zipfile.is_zipfile(archive):
            with zipfile.ZipFile(archive) as zipped:
                yield [
                    _Member(
                        one.filename,
                        not one.is_dir() and one.external_attr >> 28 in _UNIX_FILE,
                        partial(zipped.open, one),
                    )
                    for one in zipped.infolist()
                ]
        elif tarfile.is_tarfile(archive):
            with tarfile.open(archive) as tarred:
                yield [
                    _Member(one.name, one.isreg(), partial(tarred.extractfile, one))
                    for one in tarred.getmembers()
                ]
        else:
            raise InputError(f"{archive}: neither a ZIP nor a tar file; get another")
    except _DAMAGES as error:
        raise InputError(f"{archive}: damaged or locked ({error}); get another") from error
