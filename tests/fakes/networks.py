"""ONNX files of a few nodes that stand for other people's networks."""

from pathlib import Path

import onnx
from onnx import TensorProto, helper


def write_tones(path: Path, *, side: int = 112, layout: str = "NCHW") -> Path:
    """Average a face over 7 x 7 tiles: 147 numbers."""
    tile = side // 7
    pool = {"kernel_shape": [tile, tile], "strides": [tile, tile]}
    nodes = [
        helper.make_node("AveragePool", ["nchw"], ["tiles"], **pool),
        helper.make_node("Flatten", ["tiles"], ["embeddings"]),
    ]
    shape: list[int | str] = ["batch", 3, side, side]
    if layout == "NHWC":
        nodes.insert(0, helper.make_node("Transpose", ["faces"], ["nchw"], perm=[0, 3, 1, 2]))
        shape = ["batch", side, side, 3]
    name = "faces" if layout == "NHWC" else "nchw"
    faces = helper.make_tensor_value_info(name, TensorProto.FLOAT, shape)
    embeddings = helper.make_tensor_value_info("embeddings", TensorProto.FLOAT, ["batch", 147])
    graph = helper.make_graph(nodes, "tones", [faces], [embeddings])
    opset = helper.make_opsetid("", 18)
    onnx.save(helper.make_model(graph, opset_imports=[opset], ir_version=9), path)
    return path
