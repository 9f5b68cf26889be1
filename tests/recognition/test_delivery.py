"""Networks of others are brought and checked; a registry of the test's own."""

import zipfile
from pathlib import Path

import pytest
from fakes.networks import write_tones
from fakes.server import Server

from lrsr.errors import InputError
from lrsr.onnx import sha256_of
from lrsr.recognition import addition, delivery, registry
from lrsr.recognition.addition import add
from lrsr.recognition.contract import read_contract
from lrsr.recognition.delivery import Wish, pull
from lrsr.recognition.detection.contract import read_detector_contract
from lrsr.recognition.recognisers import find_recognisers, load_recognisers
from lrsr.recognition.registry import Model, Source, model_file
from lrsr.recognition.store import remove, verify

QUIET = Wish(progress=False)


@pytest.mark.parametrize("name", ["pack", "loose", "net"])
def test_a_pack_is_pulled_and_its_models_are_used_by_name(
    server: Server, folder: Path, name: str
) -> None:
    said = pull(name, QUIET)
    assert said[0].startswith(f"net: {folder / 'net.onnx'} (recogniser; its checksum is right")
    assert {path.name for path in folder.iterdir()} == {
        f"{stem}.{end}" for stem in ("net", "finder") for end in ("onnx", "toml", "json")
    }
    contract = read_contract(model_file("pack", "recogniser"))
    assert (contract.dimension, contract.mean, contract.licence) == (147, 127.5, "MIT")
    finder = read_detector_contract(model_file("finder", "detector"))
    assert finder.names[:4] == ("score_8", "score_16", "score_32", "bbox_8")
    assert (
        load_recognisers(find_recognisers(["net"]))["net"].describe()["source"]
        == f"{server.url}/pack.zip"
    )
    assert verify() == ["finder: as it was recorded", "net: as it was recorded"]


def test_what_is_here_is_not_fetched_again(server: Server, folder: Path) -> None:
    pull("pack", QUIET)
    assert pull("pack", QUIET) == ["net: is here", "finder: is here"]
    assert len(server.paths) == 1


def test_a_licence_for_research_only_wants_a_yes(server: Server, folder: Path) -> None:
    with pytest.raises(InputError, match=r"licence is 'research only'.*add accept=research-only"):
        pull("strict", QUIET)
    assert server.paths == []
    assert len(pull("strict", Wish(["research-only"], progress=False))) == 2


def test_bytes_that_nobody_vouches_for_want_a_yes_or_a_checksum(
    server: Server, folder: Path, net: Path
) -> None:
    server.content = net.read_bytes()
    with pytest.raises(InputError, match=r"no checksum of it is known; add sha256=\.\.\."):
        pull("bare", QUIET)
    with pytest.raises(InputError, match=r"has sha256 .*, wanted 1111"):
        pull("bare", Wish(sha256="1" * 64, progress=False))
    assert not list(folder.glob("*.onnx"))
    (line,) = pull("bare", Wish(["unverified"], progress=False))
    assert "not checked, as no checksum is known" in line
    assert verify(["bare"]) == ["untold: as it came; no checksum of its makers is known"]
    remove("bare")
    (line,) = pull("bare", Wish(sha256=sha256_of(net), progress=False))
    assert "its checksum is right" in line
    assert read_contract(folder / "untold.onnx").scale == 128


def test_a_mirror_takes_the_place_of_the_makers(server: Server, folder: Path) -> None:
    pull("pack", Wish(mirror=f"{server.url}/some/where/", progress=False))
    assert server.paths == ["/some/where/pack.zip"]


@pytest.mark.parametrize("name", ["lying", "loose"])
def test_other_bytes_are_refused_and_nothing_is_kept(
    server: Server, folder: Path, tmp_path: Path, name: str
) -> None:
    other = tmp_path / "other.zip"
    with zipfile.ZipFile(other, "w") as archive:
        archive.writestr("net.onnx", b"other")
        archive.writestr("finder.onnx", b"other")
    server.content = other.read_bytes()
    with pytest.raises(InputError, match="has sha256"):
        pull(name, QUIET)
    assert list(folder.iterdir()) == []


def test_another_checksum_than_the_known_one_is_refused(server: Server, folder: Path) -> None:
    with pytest.raises(InputError, match=r"sha256=1111.*: pack has .*; leave it"):
        pull("pack", Wish(sha256="1" * 64))


def test_a_name_that_is_nobodys_is_refused(server: Server, folder: Path) -> None:
    with pytest.raises(InputError, match="no model 'packs' to pull: one of pack, loose"):
        pull("packs", QUIET)


def test_another_model_of_that_name_is_left_alone(
    server: Server, folder: Path, net: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    known = registry.sources
    monkeypatch.setattr(addition, "sources", dict)
    small = write_tones(net.parent / "small.onnx", side=56)
    add(small, "insightface", name="net")
    monkeypatch.setattr(addition, "sources", known)
    with pytest.raises(InputError, match="net: another one is here; lrsr models remove net"):
        pull("pack", QUIET)
    assert read_contract(folder / "net.onnx").height_px == 56


def test_a_python_package_gives_its_files(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    archive = tmp_path / "some_models-1.0-py3-none-any.whl"

    def bring(package: str, into: Path, *, sha256: str) -> Path:
        assert (package, sha256) == ("some_models==1.0", "f" * 64)
        with zipfile.ZipFile(into / archive.name, "w") as wheel:
            wheel.writestr("some_models/__init__.py", "raise")
            wheel.writestr("some_models/models/a.dat", "weights")
        return into / archive.name

    files = {"a.dat": "a.dat"}
    model = Model("a", "recogniser", files, "", "tests")
    known = {"a": Source("a", "CC0", (model,), package="some_models==1.0", sha256="f" * 64)}
    monkeypatch.setattr(delivery, "sources", lambda: known)
    monkeypatch.setattr(delivery, "download_package", bring)
    pull("a", QUIET)
    assert {path.name for path in folder.iterdir()} == {"a.dat", "a.json"}
    assert (folder / "a.dat").read_text() == "weights"
