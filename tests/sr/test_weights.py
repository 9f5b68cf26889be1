from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
import torch
from safetensors import safe_open
from safetensors.torch import save_file

from lrsr.errors import InputError
from lrsr.paths import asset
from lrsr.sr.networks.edsr import EDSR
from lrsr.sr.networks.srcnn import SRCNN
from lrsr.sr.weights import ENLARGED_BY, Card, read_checkpoint, read_weights, write_weights

CARD = Card("srcnn", {}, 2, "luminance", lr_made_by="test", enlarged_by=ENLARGED_BY)
EDSR_CARD = Card("edsr", {"scale": 2, "blocks": 1, "features": 8}, 2, "rgb", lr_made_by="test")
HEADER = CARD.as_text()


def write_with(path: Path, header: dict[str, str], network: SRCNN | None = None) -> Path:
    save_file((network or SRCNN()).state_dict(), path, metadata=header)
    return path


def checkpoint_of(network: torch.nn.Module, card: Card) -> dict[str, object]:
    state = {f"network.{name}": value for name, value in network.state_dict().items()}
    return {"state_dict": state | {"loss.weight": torch.ones(1)}, "card": card.as_text()}


@pytest.mark.parametrize("card", [replace(CARD, scale=4), EDSR_CARD], ids=["srcnn", "edsr"])
@pytest.mark.parametrize("ending", ["safetensors", "ckpt"])
def test_weights_come_back_bit_for_bit_with_their_card(
    tmp_path: Path, card: Card, ending: str
) -> None:
    network = SRCNN() if card.architecture == "srcnn" else EDSR(**card.arguments)
    path = tmp_path / f"w.{ending}"
    if ending == "ckpt":
        torch.save(checkpoint_of(network, card), path)
    else:
        write_weights(path, network, card)
    read, card_read = read_weights(path)
    assert card_read == card
    assert list(read.state_dict()) == list(network.state_dict())
    for name, value in network.state_dict().items():
        torch.testing.assert_close(read.state_dict()[name], value, rtol=0, atol=0)


def test_read_network_is_ready_for_use(weights_file: Callable[..., Path]) -> None:
    network, _ = read_weights(weights_file(2))
    assert network.padding == "replicate"
    assert not network.training
    assert not any(parameter.requires_grad for parameter in network.parameters())


def test_arguments_of_training_do_not_matter_in_use(tmp_path: Path) -> None:
    card = replace(CARD, arguments={"padding": "none", "initialisation": "near-identity"})
    write_weights(tmp_path / "w.safetensors", SRCNN(), card)
    network, read = read_weights(tmp_path / "w.safetensors")
    assert network(torch.zeros(1, 1, 5, 6)).shape == (1, 1, 5, 6)
    assert read.arguments == card.arguments


def test_equal_weights_make_equal_bytes(tmp_path: Path) -> None:
    network, path = SRCNN(), tmp_path / "w.safetensors"
    written = set()
    for _ in range(8):
        write_weights(path, network, CARD)
        written.add(path.read_bytes())
    assert len(written) == 1
    assert read_weights(path)[1] == CARD


def test_half_precision_and_channels_last_become_plain_float32(tmp_path: Path) -> None:
    network = SRCNN().to(memory_format=torch.channels_last).half()
    torch.save(checkpoint_of(network, CARD), tmp_path / "w.ckpt")
    for tensor in read_weights(tmp_path / "w.ckpt")[0].state_dict().values():
        assert tensor.dtype == torch.float32
        assert tensor.stride() == torch.empty(tensor.shape).stride()


def test_reading_weights_draws_no_random_number(weights_file: Callable[..., Path]) -> None:
    path = weights_file(2)
    before = torch.random.get_rng_state()
    read_weights(path)
    assert torch.equal(torch.random.get_rng_state(), before)


def test_header_can_be_read_by_any_safetensors_reader(weights_file: Callable[..., Path]) -> None:
    with safe_open(weights_file(2), framework="np") as file:
        assert file.metadata() == HEADER | {"arguments": '{"initialisation": "near-identity"}'}


@pytest.mark.parametrize("scale", [2, 4])
def test_shipped_weights_are_33_kb_and_for_their_scale(scale: int) -> None:
    path = asset(f"weights/srcnn{scale}x.safetensors")
    assert read_weights(path)[1].scale == scale
    assert path.stat().st_size < 34_000


def test_half_a_file_is_refused(tmp_path: Path, weights_file: Callable[..., Path]) -> None:
    half = tmp_path / "half.safetensors"
    half.write_bytes(weights_file(2).read_bytes()[:9000])
    with pytest.raises(InputError, match=r"half.safetensors is no safetensors file"):
        read_weights(half)


def test_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is missing: "):
        read_weights(tmp_path / "none.safetensors")


@pytest.mark.parametrize(
    ("header", "reason"),
    [
        pytest.param({}, "no 'architecture'", id="no header"),
        pytest.param(HEADER | {"scale": "two"}, "invalid literal", id="scale is no number"),
        pytest.param(HEADER | {"scale": "0"}, "scale=0: wanted 1 to 16", id="scale is 0"),
        pytest.param(HEADER | {"architecture": "SRCNN 9-5-5"}, "9-5-5", id="another network"),
        pytest.param(HEADER | {"enlarged_by": "lanczos"}, "lanczos", id="another kernel"),
        pytest.param(HEADER | {"enlarged_by": ""}, "makes 6x7 pixels of 6x7", id="another scale"),
        pytest.param(HEADER | {"input": "rgb"}, "input=rgb: wanted what srcnn takes", id="input"),
        pytest.param(HEADER | {"arguments": "{"}, "card cannot be read", id="no JSON"),
        pytest.param(HEADER | {"arguments": "[1]"}, "names and values", id="a list"),
        pytest.param(HEADER | {"arguments": '{"depth": 3}'}, "depth", id="unknown argument"),
    ],
)
def test_weights_that_would_be_used_wrongly_are_refused(
    tmp_path: Path, header: dict[str, str], reason: str
) -> None:
    path = write_with(tmp_path / "w.safetensors", header)
    with pytest.raises(InputError, match=f"is not of lrsr train: .*({reason})") as caught:
        read_weights(path)
    assert "\n" not in str(caught.value)


def test_a_card_of_another_scale_than_its_network_is_refused(tmp_path: Path) -> None:
    network = EDSR(**EDSR_CARD.arguments)
    write_weights(tmp_path / "w.safetensors", network, replace(EDSR_CARD, scale=4))
    with pytest.raises(InputError, match=r"scale=4, but it makes 12x14 pixels of 6x7"):
        read_weights(tmp_path / "w.safetensors")


@pytest.mark.parametrize("dtype", [torch.complex64, torch.bool])
def test_weights_that_are_no_real_numbers_are_refused(tmp_path: Path, dtype: torch.dtype) -> None:
    checkpoint = checkpoint_of(SRCNN(), CARD)
    state = {name: weight.to(dtype) for name, weight in checkpoint["state_dict"].items()}
    torch.save(checkpoint | {"state_dict": state | {7: torch.zeros(1)}}, tmp_path / "w.ckpt")
    with pytest.raises(InputError, match=rf"holds {dtype}, wanted real numbers"):
        read_weights(tmp_path / "w.ckpt")


def test_tensors_of_another_shape_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "w.safetensors"
    save_file({"extract.weight": torch.zeros(3)}, path, metadata=HEADER)
    with pytest.raises(InputError, match=r"is not of lrsr train: .*extract.weight"):
        read_weights(path)


def test_nan_in_the_weights_is_refused(tmp_path: Path) -> None:
    network = SRCNN()
    with torch.no_grad():
        network.map.bias[3] = float("nan")
    path = write_with(tmp_path / "w.safetensors", HEADER, network)
    with pytest.raises(InputError, match=r"map.bias holds a NaN"):
        read_weights(path)


def test_checkpoint_of_another_training_is_refused(tmp_path: Path) -> None:
    torch.save({"state_dict": {}}, tmp_path / "arcface.ckpt")
    with pytest.raises(InputError, match=r"arcface.ckpt .* holds no card"):
        read_weights(tmp_path / "arcface.ckpt")


def test_checkpoint_that_holds_no_tensor_is_refused(tmp_path: Path) -> None:
    content = {"state_dict": {"network.map.bias": 3}, "card": HEADER}
    torch.save(content, tmp_path / "odd.ckpt")
    with pytest.raises(InputError, match=r"odd.ckpt is not of lrsr train"):
        read_weights(tmp_path / "odd.ckpt")


def test_a_checkpoint_is_read_as_it_was_written(tmp_path: Path) -> None:
    torch.save({"state_dict": {"a": torch.ones(2)}, "epoch": 3}, tmp_path / "last.ckpt")
    read = read_checkpoint(tmp_path / "last.ckpt")
    assert read["epoch"] == 3
    assert read["state_dict"]["a"].tolist() == [1, 1]


class Pickled:
    """What no checkpoint may hold."""


@pytest.mark.parametrize(
    "content",
    [{"state_dict": {}, "object": Pickled()}, {"epoch": 1}, [1, 2], {"state_dict": 3}],
    ids=["pickle", "no weights", "list", "number"],
)
def test_a_file_that_is_no_checkpoint_is_refused(tmp_path: Path, content: object) -> None:
    torch.save(content, tmp_path / "w.ckpt")
    with pytest.raises(InputError, match=r"w.ckpt is no checkpoint of lrsr train") as caught:
        read_checkpoint(tmp_path / "w.ckpt")
    assert "\n" not in str(caught.value)


def test_half_a_checkpoint_and_none_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "w.ckpt"
    torch.save(checkpoint_of(SRCNN(), CARD), path)
    path.write_bytes(path.read_bytes()[:5000])
    for file in (path, tmp_path / "gone.ckpt", tmp_path):
        with pytest.raises(InputError, match="is no checkpoint of lrsr train"):
            read_checkpoint(file)


def test_card_names_network_and_kernel() -> None:
    assert HEADER == {
        "architecture": "srcnn",
        "arguments": "{}",
        "scale": "2",
        "input": "luminance",
        "lr_made_by": "test",
        "enlarged_by": ENLARGED_BY,
    }


def test_card_comes_back_from_its_words_whatever_else_stands_there() -> None:
    assert Card.from_text(EDSR_CARD.as_text() | {"format": "pt"}) == EDSR_CARD


def test_a_card_takes_no_scale_that_is_no_whole_number() -> None:
    with pytest.raises(InputError, match=r"scale=2.5: wanted 1 to 16"):
        replace(CARD, scale=2.5)
