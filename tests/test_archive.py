"""Files come out of an archive by name, and nothing else does."""

import io
import tarfile
import zipfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from lrsr.archive import take_files
from lrsr.errors import InputError

Members = Mapping[str, bytes]


def zipped(path: Path, members: Members) -> Path:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return path


def tarred(path: Path, members: Members, mode: str = "w:gz") -> Path:
    with tarfile.open(path, mode) as archive:  # type: ignore[call-overload]
        for name, content in members.items():
            info = tarfile.TarInfo(name)
            info.size = len(content)
            archive.addfile(info, io.BytesIO(content))
    return path


@pytest.mark.parametrize("make", [zipped, tarred])
@pytest.mark.parametrize("inside", ["net.onnx", "pack/net.onnx", "./deep/er/net.onnx"])
def test_a_file_is_found_in_any_folder_and_alone(make: object, inside: str, tmp_path: Path) -> None:
    archive = make(tmp_path / "pack", {inside: b"weights", "setup.py": b"raise", "x/y.onnx": b""})  # type: ignore[operator]
    take_files(archive, {"net.onnx": tmp_path / "out" / "mine.onnx"})
    assert (tmp_path / "out" / "mine.onnx").read_bytes() == b"weights"
    assert {path.name for path in tmp_path.rglob("*")} == {"pack", "out", "mine.onnx"}


@pytest.mark.parametrize("make", [zipped, tarred])
@pytest.mark.parametrize(
    ("members", "says"),
    [
        ({"a.onnx": b""}, "net.onnx is not in it"),
        ({"a/net.onnx": b"", "b/net.onnx": b""}, "net.onnx is in it twice"),
        ({"../net.onnx": b""}, "leaves its folder"),
        ({"a/../../net.onnx": b""}, "leaves its folder"),
        ({"/etc/net.onnx": b""}, "leaves its folder"),
        ({"net.onnx": bytes(5000)}, "has more than 4096 bytes"),
    ],
)
def test_what_is_missing_or_strange_is_refused(
    make: object, members: Members, says: str, tmp_path: Path
) -> None:
    archive = make(tmp_path / "pack", members)  # type: ignore[operator]
    with pytest.raises(InputError, match=says):
        take_files(archive, {"net.onnx": tmp_path / "net.onnx"}, largest=4096)
    assert [path.name for path in tmp_path.iterdir()] == ["pack"]


@pytest.mark.parametrize("kind", [tarfile.SYMTYPE, tarfile.LNKTYPE, tarfile.DIRTYPE, b"6"])
def test_links_and_devices_of_a_tar_file_are_refused(kind: bytes, tmp_path: Path) -> None:
    info = tarfile.TarInfo("net.onnx")
    info.type, info.linkname = kind, "/etc/passwd"
    with tarfile.open(tmp_path / "pack.tar", "w") as archive:
        archive.addfile(info)
    with pytest.raises(InputError, match=r"net\.onnx is a link, no file"):
        take_files(tmp_path / "pack.tar", {"net.onnx": tmp_path / "net.onnx"})


def test_links_of_a_zip_file_are_refused(tmp_path: Path) -> None:
    info = zipfile.ZipInfo("net.onnx")
    info.external_attr = 0o120777 << 16
    with zipfile.ZipFile(tmp_path / "pack.zip", "w") as archive:
        archive.writestr(info, "/etc/passwd")
    with pytest.raises(InputError, match=r"net\.onnx is a link"):
        take_files(tmp_path / "pack.zip", {"net.onnx": tmp_path / "net.onnx"})


def test_the_size_that_counts_is_that_of_the_bytes(tmp_path: Path) -> None:
    archive = zipped(tmp_path / "pack.zip", {"net.onnx": bytes(1 << 16)})
    data = bytearray(archive.read_bytes())
    for place in (22, data.index(b"PK\x01\x02") + 24):  # both say how long it is
        assert data[place : place + 4] == (1 << 16).to_bytes(4, "little")
        data[place : place + 4] = (1 << 4).to_bytes(4, "little")
    archive.write_bytes(data)
    with pytest.raises(InputError, match="damaged or locked"):
        take_files(archive, {"net.onnx": tmp_path / "net.onnx"}, largest=4096)


@pytest.mark.parametrize("make", [zipped, tarred])
def test_a_damaged_archive_is_refused(make: object, tmp_path: Path) -> None:
    rows = np.random.default_rng(0).bytes(20000)
    archive = make(tmp_path / "pack", {"net.onnx": rows})  # type: ignore[operator]
    data = archive.read_bytes()
    broken = data[:9000] + bytes(40) + data[9040:] if make is zipped else data[:9000]
    archive.write_bytes(broken)
    with pytest.raises(InputError, match="damaged or locked"):
        take_files(archive, {"net.onnx": tmp_path / "net.onnx"})


def test_what_is_no_archive_is_refused(tmp_path: Path) -> None:
    (tmp_path / "pack.zip").write_bytes(b"<html>Sign in</html>")
    with pytest.raises(InputError, match="neither a ZIP nor a tar file"):
        take_files(tmp_path / "pack.zip", {"net.onnx": tmp_path / "net.onnx"})
