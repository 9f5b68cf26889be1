"""People made of paint: each identity a smooth random picture, seen as the recipe says."""

import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path

import onnx
import pytest
import torch
from fakes.contracts import declare
from fakes.detectors import scrfd_lists, write_constants
from fakes.networks import write_tones
from fakes.server import Server, serving
from onnx import TensorProto, helper

from lrsr.onnx import sha256_of
from lrsr.recognition.registry import Model, Source


@pytest.fixture(scope="module", autouse=True)
def _one_thread() -> Iterator[None]:
    """Let threads not wait for each other: on two busy cores two take ten times as long as one."""
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(threads)


WriteModel = Callable[..., Path]


@pytest.fixture
def write_model(tmp_path: Path) -> WriteModel:
    """Write three nodes that return each channel's mean over the face, and twice that."""

    def write(
        *, layout: str = "NCHW", batch: int | str = "batch", side: int = 112, **declared: object
    ) -> Path:
        path = tmp_path / "tiny.onnx"
        onnx.save(_three_nodes(layout, batch, side), path)
        return declare(path, **{"dimension": 6, "layout": layout, **declared})

    return write


def _three_nodes(layout: str, batch: int | str, side: int) -> onnx.ModelProto:
    shape = [batch, 3, side, side] if layout == "NCHW" else [batch, side, side, 3]
    graph = helper.make_graph(
        [
            helper.make_node("ReduceMean", ["faces", "axes"], ["means"], keepdims=0),
            helper.make_node("Mul", ["means", "two"], ["twice"]),
            helper.make_node("Concat", ["means", "twice"], ["embeddings"], axis=1),
        ],
        "tiny",
        [helper.make_tensor_value_info("faces", TensorProto.FLOAT, shape)],
        [helper.make_tensor_value_info("embeddings", TensorProto.FLOAT, [batch, 6])],
        [
            helper.make_tensor(
                "axes", TensorProto.INT64, [2], [2, 3] if layout == "NCHW" else [1, 2]
            ),
            helper.make_tensor("two", TensorProto.FLOAT, [1], [2.0]),
        ],
    )
    return helper.make_model(graph, opset_imports=[helper.make_opsetid("", 18)], ir_version=9)


@pytest.fixture
def tiny_model(write_model: WriteModel) -> Path:
    return write_model()


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
        for module in ("registry", "delivery", "addition", "store"):
            monkeypatch.setattr(f"lrsr.recognition.{module}.sources", lambda: known)
        yield running
