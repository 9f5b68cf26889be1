"""Networks of others are brought, checked, used and removed; a registry of the test's own."""

import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from fakes.detectors import scrfd_lists, write_constants
from fakes.networks import write_tones
from fakes.server import Server, serving

from lrsr.errors import InputError
from lrsr.onnx import contract_path, sha256_of
from lrsr.recognition import store
from lrsr.recognition.contract import read_contract
from lrsr.recognition.detection.contract import read_detector_contract
from lrsr.recognition.recognisers import find_recognisers, load_recognisers
from lrsr.recognition.registry import Model, Source, model_file, records
from lrsr.recognition.store import Wish, add, pull, remove, table, verify

QUIET = Wish(progress=False)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("LRSR_MODELS", str(tmp_path / "models"))
    return tmp_path / "models"


@pytest.fixture
def net(tmp_path: Path) -> Path:
    return write_tones(tmp_path / "net.onnx")


@pytest.fixture
def server(
    tmp_path: Path, net: Path, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[Server]:
    """Let the registry hold a pack, a file of unknown checksum, and a pack for research only."""
    monkeypatch.setenv("NO_PROXY", "127.0.0.1")
    finder = write_constants(tmp_path / "f.onnx", scrfd_lists(32, (8, 16, 32), 2, landmarks=True))
    pack = tmp_path / "pack.zip"
    with zipfile.ZipFile(pack, "w") as archive:
        archive.write(net, "pack/net.onnx")
        archive.write(finder, "pack/finder.onnx")
        archive.writestr("../../evil.py", "raise")
    models = (
        Model("net", "recogniser", {"net.onnx": "net.onnx"}, "insightface", "tests",
              {"net.onnx": sha256_of(net)}),
        Model("finder", "detector", {"finder.onnx": "finder.onnx"}, "scrfd", "tests",
              {"finder.onnx": sha256_of(finder)}),
    )  # fmt: skip
    untold = (Model("untold", "recogniser", {"net.onnx": "untold.onnx"}, "arcface128", "tests"),)
    with serving(pack.read_bytes()) as running:
        url = f"{running.url}/pack.zip"
        known = {
            "pack": Source("pack", "MIT", models, url, sha256=sha256_of(pack)),
            "loose": Source("loose", "MIT", models, url),
            "strict": Source("strict", "research only", models, url, research_only=True),
            "lying": Source("lying", "MIT", models, url, sha256="0" * 64),
            "bare": Source("bare", "MIT", untold, f"{running.url}/net.onnx"),
        }
        for module in ("store", "registry"):
            monkeypatch.setattr(f"lrsr.recognition.{module}.sources", lambda: known)
        yield running


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
    known = store.sources
    monkeypatch.setattr(store, "sources", dict)
    small = write_tones(net.parent / "small.onnx", side=56)
    add(small, "insightface", name="net")
    monkeypatch.setattr(store, "sources", known)
    with pytest.raises(InputError, match="net: another one is here; lrsr models remove net"):
        pull("pack", QUIET)
    assert read_contract(folder / "net.onnx").height_px == 56


def test_a_file_of_ones_own_is_usable_by_name(folder: Path, tmp_path: Path) -> None:
    mine = write_tones(tmp_path / "mine.onnx", side=56, layout="NHWC")
    with pytest.raises(InputError, match=r"cannot be read .*insightface, arcface128"):
        add(mine)
    with pytest.raises(InputError, match=r"^mine\.toml: input is 56×3 px"):
        add(mine, "insightface")
    text = (
        '[input]\nlayout = "NHWC"\nchannels = "BGR"\nheight_px = 56\nwidth_px = 56\nmean = 0\n'
        'scale = [255, 255, 255]\n[output]\ndimension = 147\n[alignment]\ntemplate = "arcface5"\n'
        "antialias = true\n"
    )
    contract_path(mine).write_text(text)
    assert add(mine, licence="CC0") == f"mine: {folder / 'mine.onnx'} (recogniser)"
    contract = read_contract(model_file("mine", "recogniser"))
    assert (contract.licence, contract.source) == ("CC0", "added from mine.onnx")
    assert contract.scale == (255.0, 255.0, 255.0)
    assert "mine" in load_recognisers(find_recognisers(["mine"]))
    assert remove("mine") == ["mine: removed"]
    assert list(folder.iterdir()) == []


def test_a_detector_of_ones_own_takes_its_outputs_names_from_the_graph(
    folder: Path, tmp_path: Path
) -> None:
    lists = scrfd_lists(32, (8, 16, 32), 2, landmarks=False)
    add(write_constants(tmp_path / "find.onnx", lists), "scrfd")
    assert read_detector_contract(model_file("find", "detector")).names == tuple(lists)


def test_a_file_of_the_registry_is_known_by_its_bytes(
    server: Server, folder: Path, net: Path
) -> None:
    renamed = net.rename(net.with_name("downloaded.onnx"))
    assert add(renamed) == f"net: {folder / 'net.onnx'} (recogniser)"
    contract = read_contract(model_file("net", "recogniser"))
    assert (contract.mean, contract.licence) == (127.5, "MIT")
    assert (records()["net"]["trained_on"], contract.source) == ("tests", f"{server.url}/pack.zip")
    remove("net")
    assert add(renamed, "arcface128", name="mine").startswith("mine: ")
    assert read_contract(model_file("mine", "recogniser")).scale == 128
    assert pull("pack", QUIET)[0].startswith("net: ")


@pytest.mark.parametrize(
    ("told", "says"),
    [
        ({"name": "../x"}, "name=../x: wanted letters"),
        ({"name": ".x"}, "wanted letters"),
        ({"name": "buffalo_l"}, "name=buffalo_l: lrsr models list has another file of it"),
        ({"name": "w600k_mbf"}, "name=w600k_mbf: lrsr models list has another file of it"),
        ({"contract": "arcfase"}, "contract=arcfase: cannot be read"),
        ({"file": Path("gone.onnx")}, r"gone\.onnx is missing"),
    ],
)
def test_what_cannot_be_added_is_told(
    folder: Path, net: Path, told: dict[str, object], says: str
) -> None:
    with pytest.raises(InputError, match=says):
        add(**{"file": net, "contract": "insightface", **told})  # type: ignore[arg-type]
    assert not list(folder.glob("*"))


def test_a_contract_of_another_file_is_refused(folder: Path, net: Path) -> None:
    contract_path(net).write_text(f'sha256 = "{"0" * 64}"\n')
    with pytest.raises(InputError, match=r"net\.toml: its sha256 is not that of"):
        add(net)


def test_a_name_is_given_once(folder: Path, net: Path) -> None:
    add(net, "insightface")
    with pytest.raises(InputError, match="name=net: taken; give another, or lrsr models remove"):
        add(net, "insightface")


def test_damage_is_found(folder: Path, net: Path) -> None:
    add(net, "insightface")
    add(net, "insightface", name="two")
    with (folder / "net.onnx").open("ab") as file:
        file.write(b"\0")
    (folder / "two.onnx").unlink()
    with pytest.raises(InputError, match=r"net: .*net.onnx is damaged; .*two: .* is missing"):
        verify()
    with pytest.raises(InputError, match="one is not here"):
        verify(["one"])
    with pytest.raises(InputError, match="one is not here"):
        remove("one")


def test_the_table_says_what_is_here_and_what_could_be(folder: Path, net: Path) -> None:
    add(net, "insightface", licence="CC0")
    lines = table()
    assert lines[1].split()[:3] == ["net", "recogniser", "here"]
    assert any("research only" in line and line.startswith("w600k_r50") for line in lines)
    assert records().keys() == {"net"}


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
    monkeypatch.setattr(store, "sources", lambda: known)
    monkeypatch.setattr(store, "download_package", bring)
    pull("a", QUIET)
    assert {path.name for path in folder.iterdir()} == {"a.dat", "a.json"}
    assert (folder / "a.dat").read_text() == "weights"
