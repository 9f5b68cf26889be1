"""ONNX files of a few nodes that stand for other people's networks."""

from pathlib import Path

import onnx
from onnx import TensorProto, helper

from lrsr.onnx import contract_path, declared_text, sha256_of


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


def write_difference(path: Path, *, inputs: int = 2, channels: str = "RGB") -> Path:
    """Return the mean squared difference of two pictures, (N, 1, 1, 1), as LPIPS would its own."""
    nodes = [
        helper.make_node("Sub", ["a", "b" if inputs == 2 else "a"], ["difference"]),
        helper.make_node("Mul", ["difference", "difference"], ["squared"]),
        helper.make_node("ReduceMean", ["squared", "axes"], ["distance"]),
    ]
    shape = ["batch", 3, "height", "width"]
    pictures = [
        helper.make_tensor_value_info(name, TensorProto.FLOAT, shape) for name in "ab"[:inputs]
    ]
    distance = helper.make_tensor_value_info("distance", TensorProto.FLOAT, ["batch", 1, 1, 1])
    axes = helper.make_tensor("axes", TensorProto.INT64, [3], [1, 2, 3])
    graph = helper.make_graph(nodes, "difference", pictures, [distance], [axes])
    opset = helper.make_opsetid("", 18)
    onnx.save(helper.make_model(graph, opset_imports=[opset], ir_version=9), path)
    told = {"licence": "MIT", "source": "a test", "sha256": sha256_of(path)}
    seen = {"channels": channels, "mean": 127.5, "scale": 127.5}
    contract_path(path).write_text(declared_text({**told, "input": seen}))
    return path
