"""Generators of pictures whose every direction is known: linear, of a few nodes."""

from pathlib import Path

import numpy as np
import onnx
from numpy.typing import NDArray
from onnx import TensorProto, helper, numpy_helper

from lrsr.onnx import contract_path, declared_text, sha256_of

Array = NDArray[np.floating]


def write_generator(
    path: Path,
    matrix: Array,
    base: Array,
    *,
    mapping: Array | None = None,
    layers: int = 0,
    channels: str = "RGB",
    layout: str = "NCHW",
    values: str = "0..1",
    noisy: bool = False,
) -> Path:
    """Make ``base + matrix @ w``: a picture (3, H, W) or (H, W, 3) of w, as it is returned.

    Args:
        path: Of the ONNX file; its contract lies beside it.
        matrix: ``(pixels, w)``.
        base: The picture of w = 0.
        mapping: ``(w, z)`` for w = mapping @ z + 1; None: the generator takes z itself.
        layers: It takes as many rows and looks at their mean; mapping.onnx returns as many.
        channels: For the contract, as the next ones.
        layout: Of ``base``.
        values: The range.
        noisy: Add noise that differs from run to run.
    """
    size = matrix.shape[1]
    nodes = [
        helper.make_node("Gemm", ["mean" if layers else "w", "matrix", "base"], ["flat"], transB=1),
        helper.make_node("Reshape", ["flat", "shape"], ["clean" if noisy else "picture"]),
    ]
    if layers:
        nodes.insert(0, helper.make_node("ReduceMean", ["w", "one"], ["mean"], keepdims=0))
    if noisy:
        nodes += [
            helper.make_node("RandomNormalLike", ["clean"], ["noise"]),
            helper.make_node("Add", ["clean", "noise"], ["picture"]),
        ]
    constants = {"matrix": matrix, "base": base.reshape(1, -1)}
    numbers = {"shape": [-1, *base.shape], "one": [1]}
    takes = ["batch", *([layers] if layers else []), size]
    _save(path, nodes, ("w", takes), ("picture", ["batch", *base.shape]), constants, numbers)
    latent: dict[str, object] = {"z": size}
    if mapping is not None:
        maps = [helper.make_node("Gemm", ["z", "matrix", "one_each"], ["flat"], transB=1)]
        if layers:
            maps.append(helper.make_node("Unsqueeze", ["flat", "one"], ["row"]))
            maps.append(helper.make_node("Tile", ["row", "rows"], ["w"]))
        else:
            maps.append(helper.make_node("Identity", ["flat"], ["w"]))
        constants = {"matrix": mapping, "one_each": np.ones((1, size))}
        numbers = {"one": [1], "rows": [1, layers, 1]}
        takes, returns = ["batch", mapping.shape[1]], ["batch", *takes[1:]]
        _save(
            path.with_name("mapping.onnx"), maps, ("z", takes), ("w", returns), constants, numbers
        )
        latent = {"z": mapping.shape[1], "w": size, "mapping": "mapping.onnx"}
        latent |= {"mapping_sha256": sha256_of(path.with_name("mapping.onnx")), "layers": layers}
    told = {"sha256": sha256_of(path), "licence": "MIT", "source": "a test", "latent": latent}
    output = {"channels": channels, "layout": layout, "range": values}
    contract_path(path).write_text(declared_text({**told, "output": output}))
    return path


def _save(
    path: Path,
    nodes: list[onnx.NodeProto],
    takes: tuple[str, list[int | str]],
    returns: tuple[str, list[int | str]],
    constants: dict[str, Array],
    numbers: dict[str, list[int]],
) -> None:
    known = [
        numpy_helper.from_array(np.ascontiguousarray(value, dtype=np.float32), name)
        for name, value in constants.items()
    ]
    known += [
        numpy_helper.from_array(np.array(value, dtype=np.int64), name)
        for name, value in numbers.items()
    ]
    ends = [
        helper.make_tensor_value_info(name, TensorProto.FLOAT, shape)
        for name, shape in (takes, returns)
    ]
    graph = helper.make_graph(nodes, "linear", ends[:1], ends[1:], known)
    opset = helper.make_opsetid("", 18)
    onnx.save(helper.make_model(graph, opset_imports=[opset], ir_version=9), path)
