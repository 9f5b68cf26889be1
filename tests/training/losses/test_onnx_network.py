"""Every operation is what onnxruntime does; a gradient comes back."""

from pathlib import Path
from typing import Any

import numpy as np
import onnx
import onnxruntime
import pytest
import torch
from onnx import TensorProto, helper, numpy_helper

from lrsr.errors import InputError
from lrsr.paths import asset
from lrsr.recognition.embedding import Embedder
from lrsr.training.losses.onnx_network import _OPERATIONS, OnnxNetwork

RNG = np.random.default_rng(0)
KERNEL = {"kernel_shape": [3, 3], "strides": [2, 2], "pads": [1, 0, 1, 1]}


def numbers(*shape: int) -> np.ndarray:
    return RNG.standard_normal(shape).astype(np.float32)


def whole(*values: int) -> np.ndarray:
    return np.array(values, np.int64)


def written(
    path: Path, nodes: list[onnx.NodeProto], constants: dict[str, np.ndarray], **shape: Any
) -> Path:
    """An ONNX file from x ``(N, 4, 6, 5)`` to y, opset 18."""
    ends = [
        helper.make_tensor_value_info("x", TensorProto.FLOAT, shape.get("takes", ["N", 4, 6, 5])),
        helper.make_tensor_value_info("y", TensorProto.FLOAT, None),
    ]
    initialisers = [numpy_helper.from_array(value, name) for name, value in constants.items()]
    graph = helper.make_graph(nodes, "test", ends[:1], ends[1:], initialisers)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 18)], ir_version=9)
    onnx.save(model, path)
    return path


CASES: dict[str, tuple[dict[str, Any], list[np.ndarray]]] = {
    "Abs": ({}, []),
    "Add": ({}, [numbers(1, 4, 1, 1)]),
    "AveragePool": (KERNEL, []),
    "AveragePool-with-pads": (KERNEL | {"count_include_pad": 1}, []),
    "BatchNormalization": (
        {"epsilon": 2e-3},
        [numbers(4), numbers(4), numbers(4), np.abs(numbers(4))],
    ),
    "Clip": ({}, [np.float32(-0.5), np.float32(0.25)]),
    "Concat": ({"axis": 2}, [numbers(2, 4, 3, 5)]),
    "Conv": (KERNEL | {"group": 2}, [numbers(6, 2, 3, 3), numbers(6)]),
    "Conv-plain": ({"dilations": [2, 1]}, [numbers(3, 4, 2, 2)]),
    "Div": ({}, [np.abs(numbers(4, 1, 1)) + 1]),
    "Dropout": ({}, []),
    "Flatten": ({"axis": 2}, []),
    "Gather": ({"axis": 1}, [whole(2, 0)]),
    "GlobalAveragePool": ({}, []),
    "Identity": ({}, []),
    "LeakyRelu": ({"alpha": 0.3}, []),
    "MatMul": ({}, [numbers(5, 7)]),
    "MaxPool": (KERNEL, []),
    "Mul": ({}, [numbers(4, 1, 1)]),
    "PRelu": ({}, [numbers(4, 1, 1)]),
    "ReduceMean": ({"keepdims": 0}, [whole(2, 3)]),
    "Relu": ({}, []),
    "Reshape": ({}, [whole(0, -1, 10)]),
    "Sigmoid": ({}, []),
    "Sub": ({}, [numbers(4, 6, 5)]),
    "Tanh": ({}, []),
    "Transpose": ({"perm": [0, 2, 3, 1]}, []),
    "Unsqueeze": ({}, [whole(1)]),
}


def agrees(path: Path) -> None:
    images = numbers(2, 4, 6, 5)
    (expected,) = onnxruntime.InferenceSession(path).run(None, {"x": images})
    found = OnnxNetwork(path)(torch.from_numpy(images))
    np.testing.assert_allclose(found.numpy(), expected, rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("case", CASES)
def test_an_operation_is_onnxruntimes(case: str, tmp_path: Path) -> None:
    attributes, given = CASES[case]
    constants = {f"c{number}": value for number, value in enumerate(given)}
    node = helper.make_node(case.split("-")[0], ["x", *constants], ["y"], **attributes)
    agrees(written(tmp_path / "one.onnx", [node], constants))


def test_a_fully_connected_layer_is_onnxruntimes(tmp_path: Path) -> None:
    constants = {"w": numbers(7, 120), "b": numbers(7)}
    nodes = [
        helper.make_node("Flatten", ["x"], ["flat"]),
        helper.make_node("Gemm", ["flat", "w", "b"], ["y"], transB=1, alpha=0.5, beta=2.0),
    ]
    agrees(written(tmp_path / "gemm.onnx", nodes, constants))


def test_a_shape_that_the_graph_computes_is_followed(tmp_path: Path) -> None:
    """What older exporters write for ``x.view(len(x), -1)``."""
    nodes = [
        helper.make_node("Shape", ["x"], ["sizes"]),
        helper.make_node(
            "Constant", [], ["first"], value=numpy_helper.from_array(np.array(0, np.int64))
        ),
        helper.make_node("Gather", ["sizes", "first"], ["count"]),
        helper.make_node("Unsqueeze", ["count", "zero"], ["rows"]),
        helper.make_node("Concat", ["rows", "rest"], ["wanted"], axis=0),
        helper.make_node("Reshape", ["x", "wanted"], ["y"]),
    ]
    agrees(written(tmp_path / "view.onnx", nodes, {"zero": whole(0), "rest": whole(-1)}))


def test_every_operation_is_tested() -> None:
    assert {case.split("-")[0] for case in CASES} | {"Constant", "Gemm", "Shape"} == {*_OPERATIONS}


def test_the_shipped_embedder_gives_the_same_vectors_with_a_gradient() -> None:
    model = asset("weights/arcface_small.onnx")
    crops = torch.rand(2, 3, 112, 112, generator=torch.Generator().manual_seed(0))
    embedder = Embedder(model)
    crops.requires_grad_()
    vectors = OnnxNetwork(model)(embedder.contract.prepare(crops))
    found = torch.nn.functional.normalize(vectors).detach()
    np.testing.assert_allclose(found.numpy(), embedder(crops.detach()), atol=1e-5)
    vectors.sum().backward()
    assert crops.grad is not None
    assert float(crops.grad.abs().max()) > 0


def test_a_gradient_is_the_slope(tmp_path: Path) -> None:
    nodes = [
        helper.make_node("Conv", ["x", "w"], ["a"]),
        helper.make_node("Sigmoid", ["a"], ["y"]),
    ]
    network = OnnxNetwork(written(tmp_path / "n.onnx", nodes, {"w": numbers(3, 4, 2, 2)}))
    network._values = {name: value.double() for name, value in network._values.items()}
    images = torch.from_numpy(numbers(1, 4, 6, 5)).double().requires_grad_()
    assert torch.autograd.gradcheck(network, (images,))


def test_a_result_on_the_way_can_be_asked_for(tmp_path: Path) -> None:
    nodes = [helper.make_node("Relu", ["x"], ["a"]), helper.make_node("Tanh", ["a"], ["y"])]
    network = OnnxNetwork(written(tmp_path / "n.onnx", nodes, {}))
    images = torch.from_numpy(numbers(1, 4, 6, 5))
    assert torch.equal(network(images, "a"), images.relu())
    with pytest.raises(InputError, match="the ONNX file has no output 'b'"):
        network(images, "b")


def test_a_graph_for_one_image_sees_one_after_the_other(tmp_path: Path) -> None:
    node = helper.make_node("Reshape", ["x", "wanted"], ["y"])
    path = written(tmp_path / "n.onnx", [node], {"wanted": whole(1, 120)}, takes=[1, 4, 6, 5])
    assert OnnxNetwork(path)(torch.rand(3, 4, 6, 5)).shape == (3, 120)


@pytest.mark.parametrize(
    ("nodes", "message"),
    [
        ([helper.make_node("Erf", ["x"], ["y"])], "no gradient passes through Erf; train with"),
        ([helper.make_node("Add", ["x", "z"], ["y"])], None),
    ],
    ids=["unknown", "known"],
)
def test_an_operation_that_is_not_known_is_named(
    nodes: list[onnx.NodeProto], message: str | None, tmp_path: Path
) -> None:
    path = written(tmp_path / "n.onnx", nodes, {"z": numbers(1)})
    if message is None:
        OnnxNetwork(path)
        return
    with pytest.raises(InputError, match=message):
        OnnxNetwork(path)


def test_padding_by_size_is_refused(tmp_path: Path) -> None:
    node = helper.make_node("Conv", ["x", "w"], ["y"], auto_pad="SAME_UPPER")
    network = OnnxNetwork(written(tmp_path / "n.onnx", [node], {"w": numbers(3, 4, 3, 3)}))
    with pytest.raises(InputError, match="auto_pad=SAME_UPPER; write pads"):
        network(torch.rand(1, 4, 6, 5))


def test_a_file_that_is_none_is_refused(tmp_path: Path) -> None:
    (tmp_path / "n.onnx").write_bytes(b"no protobuf")
    with pytest.raises(InputError, match=r"n\.onnx: not a usable ONNX model"):
        OnnxNetwork(tmp_path / "n.onnx")


def test_a_graph_of_two_inputs_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path / "n.onnx", [helper.make_node("Relu", ["x"], ["y"])], {})
    model = onnx.load(path)
    model.graph.input.append(helper.make_tensor_value_info("z", TensorProto.FLOAT, [1]))
    onnx.save(model, path)
    with pytest.raises(InputError, match=r"has 2 inputs; wanted one"):
        OnnxNetwork(path)
