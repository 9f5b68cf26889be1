from collections.abc import Callable
from pathlib import Path

import onnx
import pytest

from lrsr.errors import InputError
from lrsr.onnx import contract_path, sha256_of
from lrsr.sr.contract import read_contract
from lrsr.sr.weights import ENLARGED_BY, Card

SRCNN_CARD = Card("srcnn", {}, 4, "luminance", lr_made_by="rendered", enlarged_by=ENLARGED_BY)
FSRCNN_CARD = Card("fsrcnn", {"scale": 2}, 2, "luminance", lr_made_by="rendered")
EDSR_CARD = Card("edsr", {"scale": 2}, 2, "rgb", lr_made_by="rendered")


def test_a_contract_says_what_the_network_takes(somebodys: Callable[..., Path]) -> None:
    model = somebodys(channels="BGR", layout="NHWC", range="0..255")
    told = read_contract(model, {})
    assert (told.channels, told.white, told.scale, told.enlarged) == ("BGR", 255.0, 2, False)
    assert (told.multiple_of, told.lr_made_by) == (1, "")
    assert told.shape == (None, None, None, 3)
    assert told.sha256 == sha256_of(model)


@pytest.mark.parametrize(
    ("card", "channels", "enlarged"),
    [(SRCNN_CARD, "Y", True), (FSRCNN_CARD, "Y", False), (EDSR_CARD, "RGB", False)],
    ids=["srcnn", "fsrcnn", "edsr"],
)
def test_a_card_in_the_file_stands_in_for_a_contract(
    somebodys: Callable[..., Path], card: Card, channels: str, enlarged: bool
) -> None:
    model = somebodys()
    contract_path(model).unlink()
    told = read_contract(model, card.as_text())
    assert (told.channels, told.enlarged, told.scale) == (channels, enlarged, card.scale)
    assert (told.layout, told.white, told.source) == ("NCHW", 1.0, card.architecture)
    assert told.lr_made_by == "rendered"


def test_a_contract_beside_the_file_overrules_its_card(somebodys: Callable[..., Path]) -> None:
    assert read_contract(somebodys(), SRCNN_CARD.as_text()).channels == "RGB"


def test_without_either_the_remedy_is_named(somebodys: Callable[..., Path]) -> None:
    model = somebodys()
    contract_path(model).unlink()
    with pytest.raises(InputError, match=r"theirs\.toml is missing: declare channels, range"):
        read_contract(model, {"producer": "somebody"})


def test_a_broken_card_is_refused(somebodys: Callable[..., Path]) -> None:
    model = somebodys()
    contract_path(model).unlink()
    with pytest.raises(InputError, match=r"theirs\.onnx is not of lrsr train: scale=99"):
        read_contract(model, EDSR_CARD.as_text() | {"scale": "99"})


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("'RGB'", "'GRB'", "input.channels = 'GRB'; wanted RGB or BGR or Y"),
        ("'0..1'", "'-1..1'", "input.range = '-1..1'; wanted 0..1 or 0..255"),
        ("scale = 2", "scale = 0", "output.scale = 0; wanted 1 to 16"),
        ("enlarged = false", "enlarged = 0", "wanted bool"),
        ("enlarged = false", "multiple_of = 0", "input.enlarged is missing"),
        ("[output]", "multiple_of = 0\n[output]", "input.multiple_of = 0; wanted 1 to 1024"),
    ],
)
def test_a_wrong_contract_is_named_in_one_line(
    somebodys: Callable[..., Path], old: str, new: str, message: str
) -> None:
    model = somebodys()
    text = contract_path(model).read_text()
    assert old in text
    contract_path(model).write_text(text.replace(old, new))
    with pytest.raises(InputError, match=r"theirs\.toml") as caught:
        read_contract(model, {})
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_another_models_contract_is_refused(somebodys: Callable[..., Path]) -> None:
    model = somebodys()
    changed = onnx.load(model)
    changed.producer_name = "another"
    onnx.save(changed, model)
    with pytest.raises(InputError, match=r"theirs\.onnx: sha256 is .* is another model"):
        read_contract(model, {})


def test_what_is_typed_stands_in_for_a_contract(somebodys: Callable[..., Path]) -> None:
    model = somebodys()
    contract_path(model).unlink()
    told = read_contract(model, {}, {"channels": "BGR", "scale": 2, "reach_px": 7})
    assert (told.channels, told.scale, told.reach_px) == ("BGR", 2, 7)
    assert (told.layout, told.range, told.enlarged, told.multiple_of) == ("NCHW", "0..1", False, 1)
    assert told.sha256 == sha256_of(model)


def test_what_is_typed_never_overrules_a_file(somebodys: Callable[..., Path]) -> None:
    model, typed = somebodys(), {"channels": "RGB", "scale": 2}
    with pytest.raises(InputError, match=r"sr\.contract=.*theirs\.toml says .*; leave it"):
        read_contract(model, {}, typed)
    contract_path(model).unlink()
    with pytest.raises(InputError, match=r"theirs\.onnx says itself what the network takes"):
        read_contract(model, EDSR_CARD.as_text(), typed)


@pytest.mark.parametrize(
    ("typed", "message"),
    [
        ({"scale": 2}, "sr.contract: input.channels is missing"),
        ({"channels": "RGB"}, "sr.contract: output.scale is missing"),
        ({"channels": "RGB", "scale": "2"}, "output.scale = '2'; wanted int"),
        ({"channels": "RGB", "scale": 2, "chanels": "Y"}, "unknown field 'chanels' in [input]"),
        ({"channels": "RGB", "scale": 2, "reach_px": -1}, "reach_px = -1; wanted 0 to 1024"),
    ],
)
def test_wrong_words_are_named(
    somebodys: Callable[..., Path], typed: dict[str, object], message: str
) -> None:
    model = somebodys()
    contract_path(model).unlink()
    with pytest.raises(InputError) as caught:
        read_contract(model, {}, typed)
    assert message in str(caught.value)


def test_a_contract_says_how_far_its_network_looks(somebodys: Callable[..., Path]) -> None:
    assert read_contract(somebodys(reach_px=40), {}).reach_px == 40
    assert read_contract(somebodys(), {}).reach_px is None
    model = somebodys()
    contract_path(model).unlink()
    assert read_contract(model, SRCNN_CARD.as_text()).reach_px == 4 + 0 + 2
