from pathlib import Path

import numpy as np
import onnx
import onnxruntime
import pytest
import torch
from lrsr.sr.export import OPSET, TOLERANCE, export_onnx
from lrsr.sr.srcnn import SRCNN

from lrsr.errors import NonFiniteError
from lrsr.sr import export
from lrsr.sr.weights import Recipe

RECIPE = Recipe(scale=4, lr_made_by="rendered")


@pytest.fixture(scope="module")
def network() -> SRCNN:
    torch.manual_seed(1)
    return SRCNN(initialisation="default")


@pytest.fixture(scope="module")
def exported(network: SRCNN, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("onnx") / "model.onnx"
    assert export_onnx(path, network, RECIPE) <= TOLERANCE
    return path


@pytest.mark.parametrize("shape", [(1, 1, 1, 1), (3, 1, 5, 50), (2, 1, 128, 96)], ids=str)
def test_onnxruntime_returns_what_torch_does_at_any_size(
    exported: Path, network: SRCNN, shape: tuple[int, ...]
) -> None:
    luminance = torch.rand(shape, generator=torch.Generator().manual_seed(2))
    padded = SRCNN(padding="replicate")
    padded.load_state_dict(network.state_dict())
    (restored,) = onnxruntime.InferenceSession(exported).run(None, {"luminance": luminance.numpy()})
    assert restored.shape == shape
    np.testing.assert_allclose(restored, padded(luminance).detach().numpy(), atol=TOLERANCE)


def test_input_and_output_are_declared_with_free_n_h_w(exported: Path) -> None:
    graph = onnx.load(exported).graph
    for value, name in ((graph.input[0], "luminance"), (graph.output[0], "restored")):
        tensor = value.type.tensor_type
        assert value.name == name
        assert tensor.elem_type == onnx.TensorProto.FLOAT
        sizes = [size.dim_param or size.dim_value for size in tensor.shape.dim]
        assert sizes == ["N", 1, "H", "W"]


def test_opset_is_the_stated_one(exported: Path) -> None:
    assert [(o.domain, o.version) for o in onnx.load(exported).opset_import] == [("", OPSET)]


def test_file_says_for_what_it_was_trained(exported: Path) -> None:
    assert {p.key: p.value for p in onnx.load(exported).metadata_props} == RECIPE.as_text()


def test_file_holds_no_path_of_this_machine(exported: Path) -> None:
    content = exported.read_bytes()
    assert str(Path(export.__file__).parents[2]).encode() not in content
    assert b"site-packages" not in content


def test_export_leaves_the_network_as_it_was(exported: Path, network: SRCNN) -> None:
    assert network.padding == "none"
    assert network.training


def test_onnx_that_differs_from_torch_is_not_written(
    tmp_path: Path, network: SRCNN, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(export, "_difference", lambda *_: 2e-5)
    with pytest.raises(RuntimeError, match=r"ONNX and torch differ by 2.0e-05, over 1e-05"):
        export_onnx(tmp_path / "model.onnx", network, RECIPE)
    assert not (tmp_path / "model.onnx").exists()


def test_network_that_returns_nan_is_not_written(tmp_path: Path) -> None:
    network = SRCNN()
    with torch.no_grad():
        network.reconstruct.bias.fill_(float("nan"))
    with pytest.raises(NonFiniteError, match="is not written: the network returns NaN"):
        export_onnx(tmp_path / "model.onnx", network, RECIPE)
    assert not (tmp_path / "model.onnx").exists()
