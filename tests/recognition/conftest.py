"""People made of paint: each identity a smooth random picture, seen as the recipe says."""

from collections.abc import Callable, Iterator
from pathlib import Path

import onnx
import pytest
import torch
from fakes.contracts import declare
from onnx import TensorProto, helper


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
