from collections.abc import Callable
from pathlib import Path

import pytest
import torch
from safetensors import safe_open
from safetensors.torch import save_file

from lrsr.errors import InputError
from lrsr.paths import asset
from lrsr.sr.bicubic import ENLARGED_BY
from lrsr.sr.srcnn import SRCNN
from lrsr.sr.weights import ARCHITECTURE, Recipe, read_weights, write_weights

HEADER = Recipe(scale=2, lr_made_by="test").as_text()


def write_with(path: Path, header: dict[str, str], network: SRCNN | None = None) -> Path:
    save_file((network or SRCNN()).state_dict(), path, metadata=header)
    return path


def test_weights_come_back_bit_for_bit_with_their_recipe(tmp_path: Path) -> None:
    network, recipe = SRCNN(), Recipe(scale=4, lr_made_by="rendered")
    write_weights(tmp_path / "w.safetensors", network, recipe)
    read, recipe_read = read_weights(tmp_path / "w.safetensors")
    assert recipe_read == recipe
    for name, value in network.state_dict().items():
        torch.testing.assert_close(read.state_dict()[name], value, rtol=0, atol=0)


def test_read_network_is_ready_for_use(weights_file: Callable[..., Path]) -> None:
    network, _ = read_weights(weights_file(2))
    assert network.padding == "replicate"
    assert not network.training
    assert not any(parameter.requires_grad for parameter in network.parameters())


def test_header_can_be_read_by_any_safetensors_reader(weights_file: Callable[..., Path]) -> None:
    with safe_open(weights_file(2), framework="np") as file:
        assert file.metadata() == HEADER


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
    with pytest.raises(InputError, match="no weights at"):
        read_weights(tmp_path / "none.safetensors")


@pytest.mark.parametrize(
    ("header", "reason"),
    [
        pytest.param({}, "architecture|scale", id="no header"),
        pytest.param(HEADER | {"scale": "two"}, "invalid literal", id="scale is no number"),
        pytest.param(HEADER | {"architecture": "SRCNN 9-5-5"}, "9-5-5", id="another network"),
        pytest.param(HEADER | {"enlarged_by": "lanczos"}, "lanczos", id="another kernel"),
    ],
)
def test_weights_that_would_be_used_wrongly_are_refused(
    tmp_path: Path, header: dict[str, str], reason: str
) -> None:
    path = write_with(tmp_path / "w.safetensors", header)
    with pytest.raises(InputError, match=f"is not SRCNN 9-1-5 from lrsr train: .*({reason})"):
        read_weights(path)


def test_tensors_of_another_shape_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "w.safetensors"
    save_file({"extract.weight": torch.zeros(3)}, path, metadata=HEADER)
    with pytest.raises(InputError, match=r"is not SRCNN 9-1-5 .*extract.weight"):
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
    with pytest.raises(InputError, match=r"arcface.ckpt .* holds no recipe"):
        read_weights(tmp_path / "arcface.ckpt")


def test_recipe_names_network_and_kernel() -> None:
    assert HEADER == {
        "scale": "2",
        "lr_made_by": "test",
        "enlarged_by": ENLARGED_BY,
        "architecture": ARCHITECTURE,
    }
