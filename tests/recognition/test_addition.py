"""Networks of one's own are among the models, or nothing of them is."""

from pathlib import Path

import pytest
from fakes.detectors import scrfd_lists, write_constants
from fakes.networks import write_tones
from fakes.server import Server

from lrsr.errors import InputError
from lrsr.onnx import contract_path
from lrsr.recognition.addition import add
from lrsr.recognition.contract import read_contract
from lrsr.recognition.delivery import Wish, pull
from lrsr.recognition.detection.contract import read_detector_contract
from lrsr.recognition.recognisers import find_recognisers, load_recognisers
from lrsr.recognition.registry import model_file, records
from lrsr.recognition.store import remove


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
    assert pull("pack", Wish(progress=False))[0].startswith("net: ")


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
