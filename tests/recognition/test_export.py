from pathlib import Path
from shutil import copyfile

import numpy as np
import onnx
import pytest
import torch

import lrsr.recognition.export as export
from lrsr.errors import InputError
from lrsr.recognition.backbone import Backbone
from lrsr.recognition.embedding import Embedder


@pytest.fixture(scope="module")
def network() -> Backbone:
    torch.manual_seed(3)
    return Backbone().eval()


@pytest.fixture(scope="module")
def exported(network: Backbone, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("export") / "model.onnx"
    export.export_embedder(network, path, antialias=True, source="a test")
    return path


@pytest.mark.parametrize("count", [1, 7])
def test_onnx_and_torch_agree(network: Backbone, exported: Path, count: int) -> None:
    crops = torch.rand(count, 3, 112, 112, generator=torch.Generator().manual_seed(9))
    with torch.no_grad():
        wanted = torch.nn.functional.normalize(network((crops * 255 - 127.5) / 127.5)).numpy()
    assert np.abs(Embedder(exported)(crops) - wanted).max() < 1e-4


def test_the_file_has_the_usual_contract(exported: Path) -> None:
    contract = Embedder(exported).contract
    assert contract.input_shape == (3, 112, 112)
    assert (contract.channels, contract.mean, contract.scale) == ("RGB", 127.5, 127.5)
    assert contract.antialias is True
    onnx.checker.check_model(onnx.load(exported), full_check=True)


def test_the_file_stands_alone_and_is_small(exported: Path) -> None:
    assert sorted(path.name for path in exported.parent.iterdir()) == ["model.onnx", "model.toml"]
    assert exported.stat().st_size < 5e6


def test_the_file_holds_no_paths_of_the_machine_that_made_it(exported: Path) -> None:
    content = exported.read_bytes()
    assert b"stack_trace" not in content
    assert str(Path(export.__file__).parent).encode() not in content


def test_a_model_that_computes_something_else_is_not_shipped(
    exported: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The file of one network, written in the name of another."""
    monkeypatch.setattr(export, "_write_onnx", lambda _, path: copyfile(exported, path))
    torch.manual_seed(4)
    network = Backbone()
    with pytest.raises(RuntimeError, match="differs from the network"):
        export.export_embedder(network, tmp_path / "model.onnx", antialias=True, source="a test")


def test_a_folder_that_is_a_file_is_named(network: Backbone, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot write"):
        export.export_embedder(
            network, tmp_path / "file" / "model.onnx", antialias=True, source="a test"
        )
