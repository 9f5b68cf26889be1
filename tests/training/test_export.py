from pathlib import Path
from typing import Any

import numpy as np
import onnx
import onnxruntime
import pytest
import torch

from lrsr.errors import InputError, NonFiniteError
from lrsr.sr.networks import NETWORKS
from lrsr.training import export
from lrsr.training.backbone import Backbone
from lrsr.training.export import _OPSET, _TOLERANCE, export_onnx

ABOUT = {"scale": "4", "lr_made_by": "rendered"}


def write(path: Path, network: torch.nn.Module) -> float:
    return export_onnx(
        path,
        network,
        shapes=[(2, 1, 24, 20), (1, 1, 32, 32)],
        names=("luminance", "restored"),
        free={0: "N", 2: "H", 3: "W"},
        about=ABOUT,
    )


@pytest.fixture(scope="module")
def network() -> Any:
    torch.manual_seed(1)
    return NETWORKS["srcnn"](padding="replicate").eval()


@pytest.fixture(scope="module")
def exported(network: Any, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("onnx") / "model.onnx"
    assert write(path, network) <= _TOLERANCE
    return path


@pytest.mark.parametrize("shape", [(1, 1, 1, 1), (3, 1, 5, 50), (2, 1, 128, 96)], ids=str)
def test_onnxruntime_returns_what_torch_does_at_any_size(
    exported: Path, network: Any, shape: tuple[int, ...]
) -> None:
    luminance = torch.rand(shape, generator=torch.Generator().manual_seed(2))
    (restored,) = onnxruntime.InferenceSession(exported).run(None, {"luminance": luminance.numpy()})
    assert restored.shape == shape
    np.testing.assert_allclose(restored, network(luminance).detach().numpy(), atol=_TOLERANCE)


def test_input_and_output_are_declared_with_free_n_h_w(exported: Path) -> None:
    graph = onnx.load(exported).graph
    for value, name in ((graph.input[0], "luminance"), (graph.output[0], "restored")):
        tensor = value.type.tensor_type
        assert value.name == name
        assert tensor.elem_type == onnx.TensorProto.FLOAT
        sizes = [size.dim_param or size.dim_value for size in tensor.shape.dim]
        assert sizes == ["N", 1, "H", "W"]


def test_opset_is_the_stated_one(exported: Path) -> None:
    model = onnx.load(exported)
    assert [(o.domain, o.version) for o in model.opset_import] == [("", _OPSET)]
    onnx.checker.check_model(model, full_check=True)


def test_file_says_what_it_is_told_to(exported: Path) -> None:
    assert {p.key: p.value for p in onnx.load(exported).metadata_props} == ABOUT


def test_file_stands_alone_and_holds_no_path_of_this_machine(exported: Path) -> None:
    assert [path.name for path in exported.parent.iterdir()] == ["model.onnx"]
    content = exported.read_bytes()
    assert str(Path(export.__file__).parents[2]).encode() not in content
    assert b"site-packages" not in content
    assert b"stack_trace" not in content


def test_a_backbone_of_any_batch_is_exported_too(tmp_path: Path) -> None:
    torch.manual_seed(3)
    path, network = tmp_path / "model.onnx", Backbone().eval()
    shapes = [(2, 3, 112, 112), (5, 3, 112, 112)]
    names = ("faces", "embeddings")
    export_onnx(path, network, shapes=shapes, names=names, free={0: "batch"}, about={})
    faces = torch.rand(7, 3, 112, 112, generator=torch.Generator().manual_seed(9))
    (found,) = onnxruntime.InferenceSession(path).run(None, {"faces": faces.numpy()})
    with torch.no_grad():
        wanted = torch.nn.functional.normalize(network(faces)).numpy()
    assert np.abs(found / np.linalg.norm(found, axis=1, keepdims=True) - wanted).max() < 1e-4
    assert path.stat().st_size < 5e6


@pytest.fixture
def _as_exported(exported: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Spare the seconds of another export where its content is not the question."""
    content = exported.read_bytes()
    monkeypatch.setattr(export, "_as_onnx", lambda *_: content)


@pytest.mark.usefixtures("_as_exported")
def test_onnx_that_differs_from_torch_is_not_written(
    tmp_path: Path, network: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(export, "_difference", lambda *_: 2e-5)
    with pytest.raises(RuntimeError, match=r"ONNX and torch differ by 2.0e-05, over 1e-05"):
        write(tmp_path / "model.onnx", network)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("_as_exported")
def test_network_that_returns_nan_is_not_written(tmp_path: Path) -> None:
    network: Any = NETWORKS["srcnn"](padding="replicate").eval()
    with torch.no_grad():
        network.reconstruct.bias.fill_(float("nan"))
    with pytest.raises(NonFiniteError, match="is not written: the network returns NaN"):
        write(tmp_path / "model.onnx", network)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("_as_exported")
def test_a_folder_that_is_a_file_is_named(network: Any, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot write"):
        write(tmp_path / "file" / "model.onnx", network)


@pytest.mark.parametrize(
    ("name", "arguments"),
    [
        ("fsrcnn", {"scale": 3, "features": 4, "shrunken": 2, "maps": 1}),
        pytest.param(
            "sparnet",
            {"scale": 3, "blocks": 1, "features": 8, "large_features": 4, "depth": 1},
            marks=pytest.mark.slow,  # ten seconds in torch's exporter
        ),
    ],
    ids=["fsrcnn", "sparnet"],
)
def test_networks_that_enlarge_agree_with_onnxruntime_at_odd_sizes(
    name: str, arguments: dict[str, int], tmp_path: Path
) -> None:
    torch.manual_seed(0)
    network = NETWORKS[name](**arguments).eval()
    channels = 1 if network.input == "luminance" else 3
    difference = export_onnx(
        tmp_path / "model.onnx",
        network,
        shapes=[(2, channels, 24, 20), (2, channels, 13, 40), (1, channels, 1, 1)],
        names=("small", "restored"),
        free={0: "N", 2: "H", 3: "W"},
        about=ABOUT,
    )
    assert 0 < difference <= _TOLERANCE
