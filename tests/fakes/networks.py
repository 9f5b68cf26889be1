"""ONNX files of a few nodes that stand for other people's networks."""

from pathlib import Path

import numpy as np
import onnx
from numpy.typing import NDArray
from onnx import TensorProto, helper, numpy_helper

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


def write_colour_finder(
    path: Path, colours: NDArray[np.float64], *, size_px: int, as_map: bool = False
) -> Path:
    """Find where each colour ``(K, 3)`` is on a black picture, and name four corners besides.

    A list of x, y, 0 of K + 4 points, px, of RGB ``(N, 3, size, size)``; as a map it is made as
    another house would: of BGR ``(N, size, size, 3)``, (255 srgb - 100) / 50, ``(N, 3, 4, ...)``,
    in units of 2 px. The contract lies beside it.
    """
    mean, scale, unit = (100.0, 50.0, 2.0) if as_map else (0.0, 255.0, 1.0)
    sharp, order = 200.0, [2, 1, 0] if as_map else [0, 1, 2]
    ordered = colours[:, order].astype(np.float32)
    y, x = np.mgrid[:size_px, :size_px].reshape(2, -1).astype(np.float32)
    last = size_px - 1.0
    constants = {
        "gain": np.array([scale / 255], np.float32),
        "offset": np.array([mean / 255], np.float32),
        "weight": 2 * sharp * ordered[:, :, None, None],
        "bias": -sharp * (ordered**2).sum(axis=1),
        "sharp": np.array([-sharp], np.float32),
        "one": np.array([1]),
        "flat": np.array([0, len(colours), -1]),
        "grid": np.stack([x, y, 0 * x], axis=1) / np.float32(unit),
        "zero": np.array([0]),
        "four": np.array([4]),
        "nothing": np.zeros(1, np.float32),
        "corners": (np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]) * last / unit).astype(
            np.float32
        ),
        "shape": np.array([0, 4, -1, 3]),
    }
    name = "nhwc" if as_map else "nchw"
    nodes = [helper.make_node("Transpose", ["nhwc"], ["nchw"], perm=[0, 3, 1, 2])] * as_map + [
        helper.make_node("Mul", ["nchw", "gain"], ["brighter"]),
        helper.make_node("Add", ["brighter", "offset"], ["srgb"]),
        helper.make_node("Conv", ["srgb", "weight", "bias"], ["alike"]),
        helper.make_node("Mul", ["srgb", "srgb"], ["squares"]),
        helper.make_node("ReduceSum", ["squares", "one"], ["square"]),
        helper.make_node("Mul", ["square", "sharp"], ["apart"]),
        helper.make_node("Add", ["alike", "apart"], ["near"]),
        helper.make_node("Reshape", ["near", "flat"], ["rows"]),
        helper.make_node("Softmax", ["rows"], ["shares"], axis=-1),
        helper.make_node("MatMul", ["shares", "grid"], ["found"]),
        helper.make_node("Slice", ["found", "zero", "four", "one"], ["some"]),
        helper.make_node("Mul", ["some", "nothing"], ["nought"]),
        helper.make_node("Add", ["nought", "corners"], ["named"]),
        helper.make_node("Concat", ["found", "named"], ["points"], axis=1),
    ]
    shape: list[int | str] = ["batch", 3, size_px, size_px]
    returned: list[int | str] = ["batch", len(colours) + 4, 3]
    if as_map:
        nodes += [
            helper.make_node("Reshape", ["points", "shape"], ["map"]),
            helper.make_node("Transpose", ["map"], ["moved"], perm=[0, 3, 1, 2]),
        ]
        shape = ["batch", size_px, size_px, 3]
        returned = ["batch", 3, 4, len(colours) // 4 + 1]
    output = "moved" if as_map else "points"
    graph = helper.make_graph(
        nodes,
        "colours",
        [helper.make_tensor_value_info(name, TensorProto.FLOAT, shape)],
        [helper.make_tensor_value_info(output, TensorProto.FLOAT, returned)],
        [numpy_helper.from_array(value, key) for key, value in constants.items()],
    )
    opset = helper.make_opsetid("", 18)
    onnx.save(helper.make_model(graph, opset_imports=[opset], ir_version=9), path)
    told = {"licence": "MIT", "source": "a test", "sha256": sha256_of(path)}
    seen: dict[str, object] = {"channels": "RGB", "size_px": size_px}
    found: dict[str, object] = {"points": output}  # a mirror does not change colours
    if as_map:
        seen |= {"channels": "BGR", "layout": "NHWC", "mean": mean, "scale": scale}
        found = {"points": output, "shape": returned[1:], "unit_px": unit}
    crop = {"side": 1.5, "box": "five"}
    text = declared_text({**told, "input": seen, "output": found, "crop": crop})
    contract_path(path).write_text(text)
    return path
