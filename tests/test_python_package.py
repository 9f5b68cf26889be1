"""pip brings a package's archive, from a folder in place of an index, and nothing of it is run."""

import io
import tarfile
import zipfile
from pathlib import Path

import pytest

from lrsr.errors import InputError
from lrsr.onnx import sha256_of
from lrsr.python_package import download_package


@pytest.fixture(autouse=True)
def index(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Let pip know nothing but a folder, whatever its user has set up."""
    folder = tmp_path / "index"
    folder.mkdir()
    monkeypatch.setenv("PIP_CONFIG_FILE", "/dev/null")
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    monkeypatch.setenv("PIP_FIND_LINKS", str(folder))
    monkeypatch.delenv("PIP_CONSTRAINT", raising=False)
    return folder


def write_sdist(folder: Path, witness: Path) -> Path:
    """Write a package whose setup.py leaves a witness if it is run."""
    path = folder / "some_models-1.0.tar.gz"
    setup = f"open({str(witness)!r}, 'w'); from setuptools import setup; setup(name='some_models')"
    members = {"setup.py": setup.encode(), "PKG-INFO": b"Name: some_models\n", "net.dat": b"net"}
    with tarfile.open(path, "w:gz") as archive:
        for name, content in members.items():
            info = tarfile.TarInfo(f"some_models-1.0/{name}")
            info.size = len(content)
            archive.addfile(info, io.BytesIO(content))
    return path


def test_of_a_source_distribution_nothing_is_run(tmp_path: Path, index: Path) -> None:
    witness = tmp_path / "it was run"
    digest = sha256_of(write_sdist(index, witness))
    got = download_package("some_models==1.0", tmp_path / "got", sha256=digest)
    assert got == tmp_path / "got" / "some_models-1.0.tar.gz"
    assert sha256_of(got) == digest
    assert not witness.exists()


def test_of_a_wheel_what_it_depends_on_stays_away(tmp_path: Path, index: Path) -> None:
    told = "Metadata-Version: 2.1\nName: some_models\nVersion: 1.0\nRequires-Dist: torch>=99\n"
    wheel = index / "some_models-1.0-py3-none-any.whl"
    with zipfile.ZipFile(wheel, "w") as archive:
        archive.writestr("some_models-1.0.dist-info/METADATA", told)
        archive.writestr("some_models-1.0.dist-info/WHEEL", "Wheel-Version: 1.0\n")
        archive.writestr("some_models-1.0.dist-info/RECORD", "")
    got = download_package("some_models==1.0", tmp_path / "got", sha256=sha256_of(wheel))
    assert [path.name for path in (tmp_path / "got").iterdir()] == [got.name] == [wheel.name]


def test_another_archive_is_refused_before_it_is_opened(tmp_path: Path, index: Path) -> None:
    witness = tmp_path / "it was run"
    write_sdist(index, witness)
    with pytest.raises(InputError, match=r"some_models==1.0: pip cannot download it") as caught:
        download_package("some_models==1.0", tmp_path / "got", sha256="0" * 64)
    assert "\n" not in str(caught.value)
    assert not witness.exists()


def test_a_package_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"other==2.0: pip cannot download it .*other==2.0"):
        download_package("other==2.0", tmp_path / "got", sha256="0" * 64)


def test_pip_that_takes_for_ever_is_stopped(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"pip took over 0.01 s"):
        download_package("other==2.0", tmp_path / "got", sha256="0" * 64, timeout_s=0.01)


def test_no_pip_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
    with pytest.raises(InputError, match="no pip; python -m ensurepip"):
        download_package("other==2.0", tmp_path / "got", sha256="0" * 64)
