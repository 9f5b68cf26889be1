"""An embedder of two nodes that tells painted people apart."""

from collections.abc import Iterator
from pathlib import Path

import onnx
import pytest
from fakes.contracts import declare
from fakes.figures import draw_nothing
from onnx import TensorProto, helper


@pytest.fixture(scope="session")
def tone_model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Average a face over 7 x 7 tiles: 147 numbers."""
    path = tmp_path_factory.mktemp("model") / "tones.onnx"
    nodes = [
        helper.make_node(
            "AveragePool", ["faces"], ["tiles"], kernel_shape=[16, 16], strides=[16, 16]
        ),
        helper.make_node("Flatten", ["tiles"], ["embeddings"]),
    ]
    faces = helper.make_tensor_value_info("faces", TensorProto.FLOAT, ["batch", 3, 112, 112])
    embeddings = helper.make_tensor_value_info("embeddings", TensorProto.FLOAT, ["batch", 147])
    graph = helper.make_graph(nodes, "tones", [faces], [embeddings])
    opset = helper.make_opsetid("", 18)
    onnx.save(helper.make_model(graph, opset_imports=[opset], ir_version=9), path)
    return declare(path, 147)


@pytest.fixture(scope="module", autouse=True)
def no_figures() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        draw_nothing(patch)
        yield
