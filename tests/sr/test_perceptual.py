"""Tests of lrsr/sr/perceptual.py."""

from pathlib import Path

import numpy as np
import onnx
import pytest
import torch
from fakes.networks import write_difference

from lrsr.errors import ImageContractError, InputError
from lrsr.onnx import contract_path, sha256_of
from lrsr.sr.perceptual import PerceptualDistance


def pictures(seed: int, count: int = 3, side: int = 20) -> torch.Tensor:
    return torch.rand(count, 3, side, side + 4, generator=torch.Generator().manual_seed(seed))


@pytest.fixture
def model(tmp_path: Path) -> Path:
    return write_difference(tmp_path / "lpips.onnx")


def test_a_pair_goes_through_the_network_as_declared(model: Path) -> None:
    a, b = pictures(0), pictures(1)
    wanted = (2 * (a - b)).square().mean(dim=(1, 2, 3)).numpy()  # it sees -1 to 1
    np.testing.assert_allclose(PerceptualDistance(model)(a, b), wanted, rtol=1e-5)


def test_equal_pictures_are_not_apart(model: Path) -> None:
    assert not PerceptualDistance(model)(pictures(0), pictures(0)).any()


def test_each_channel_has_its_own_scale_in_the_networks_order(tmp_path: Path) -> None:
    model = write_difference(tmp_path / "lpips.onnx", channels="BGR")
    contract = contract_path(model)
    contract.write_text(contract.read_text().replace("scale = 127.5", "scale = [255.0, 1e6, 1e6]"))
    a = pictures(0)
    b = a.clone()
    b[:, 2] = 1 - b[:, 2]  # blue, the first channel of BGR
    wanted = (a - b).square().mean(dim=(1, 2, 3)).numpy()
    np.testing.assert_allclose(PerceptualDistance(model)(a, b), wanted, rtol=1e-5)


def test_a_report_says_which_network_it_was(model: Path) -> None:
    about = PerceptualDistance(model).describe()
    assert (about["model"], about["licence"]) == ("lpips.onnx", "MIT")
    assert about["sha256"] == sha256_of(model)


def test_pictures_of_two_sizes_are_refused(model: Path) -> None:
    with pytest.raises(ImageContractError, match="wanted one shape"):
        PerceptualDistance(model)(pictures(0), pictures(0, side=21))


def test_a_network_of_one_picture_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="wanted two inputs N3HW and one output"):
        PerceptualDistance(write_difference(tmp_path / "one.onnx", inputs=1))


def test_a_network_for_other_pictures_is_refused(model: Path) -> None:
    graph = onnx.load(model)
    for end in graph.graph.input:
        end.type.tensor_type.shape.dim[2].dim_value = 64
    onnx.save(graph, model)
    _declared_again(model)
    with pytest.raises(InputError, match="cannot take two of"):
        PerceptualDistance(model)(pictures(0), pictures(1))


def test_a_map_is_no_distance(model: Path) -> None:
    graph = onnx.load(model)
    del graph.graph.node[2]
    graph.graph.node[1].output[0] = "distance"
    for dim, size in zip(
        graph.graph.output[0].type.tensor_type.shape.dim[1:], (3, 20, 24), strict=True
    ):
        dim.dim_value = size
    onnx.save(graph, model)
    _declared_again(model)
    with pytest.raises(InputError, match="for a pair, not a number"):
        PerceptualDistance(model)(pictures(0), pictures(1))


def test_a_contract_is_needed_and_held(model: Path) -> None:
    contract = contract_path(model)
    text = contract.read_text()
    contract.write_text(text.replace("scale = 127.5", "scale = 0.0"))
    with pytest.raises(InputError, match="scale must be above 0"):
        PerceptualDistance(model)
    contract.unlink()
    with pytest.raises(InputError, match="is missing"):
        PerceptualDistance(model)


def _declared_again(model: Path) -> None:
    contract = contract_path(model)
    lines = contract.read_text().splitlines()
    mended = [f'sha256 = "{sha256_of(model)}"' if "sha256" in one else one for one in lines]
    contract.write_text("\n".join(mended))
