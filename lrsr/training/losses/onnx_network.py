"""How does a gradient pass through an ONNX file? Its operations, done one by one by torch.

onnxruntime returns numbers without a gradient, and converters lag behind the exporters: onnx2torch
1.5.15 has no Reshape of opset 19, which torch writes. Face embedders need few operations; what is
not here is refused by its name.
"""

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import onnx
import torch
from onnx import numpy_helper
from torch.nn import functional as F

from lrsr.errors import InputError

_Inputs = list[Any]
_Attributes = dict[str, Any]
_Operation = Callable[[_Inputs, _Attributes], torch.Tensor]


class OnnxNetwork:
    """A frozen network of one input. Not in any checkpoint; it goes where its input is.

    Args:
        model: The ``.onnx`` file.

    Raises:
        InputError: It cannot be read, or has an operation that is not known here.
    """

    def __init__(self, model: Path) -> None:
        try:
            graph = onnx.load(model).graph
        except Exception as error:  # of protobuf or of the system
            reason = " ".join(str(error).split())[:160]
            raise InputError(
                f"{model}: not a usable ONNX model ({reason}); get it again"
            ) from error
        if unknown := sorted({node.op_type for node in graph.node} - _OPERATIONS.keys()):
            raise InputError(
                f"{model}: no gradient passes through {', '.join(unknown)}; train with another"
                " network, or add it to lrsr/training/losses/onnx_network.py"
            )
        self._values = {one.name: _tensor(one) for one in graph.initializer}
        names = [end.name for end in graph.input if end.name not in self._values]
        if len(names) != 1:
            raise InputError(f"{model}: has {len(names)} inputs; wanted one")
        first = next(end for end in graph.input if end.name == names[0])
        self._input, self._output = names[0], graph.output[0].name
        self._one_by_one = first.type.tensor_type.shape.dim[0].dim_value == 1
        self._steps = [
            (
                _OPERATIONS[node.op_type],
                list(node.input),
                node.output[0],
                {one.name: onnx.helper.get_attribute_value(one) for one in node.attribute},
            )
            for node in graph.node
        ]

    def __call__(self, images: torch.Tensor, output: str = "") -> torch.Tensor:
        """Run the network.

        Args:
            images: What the graph takes; a graph for one image sees one after the other.
            output: Name of the result; "": the first.

        Raises:
            InputError: The graph has no such result.
        """
        if self._one_by_one and len(images) > 1:
            return torch.cat([self(image[None], output) for image in images])
        self._values = {name: value.to(images.device) for name, value in self._values.items()}
        values: dict[str, Any] = {"": None, self._input: images, **self._values}
        for operation, inputs, result, attributes in self._steps:
            values[result] = operation([values[name] for name in inputs], attributes)
            if result == output:
                break
        wanted = output or self._output
        if wanted not in values:
            raise InputError(f"the ONNX file has no output {wanted!r}")
        returned: torch.Tensor = values[wanted]
        return returned


def _tensor(constant: onnx.TensorProto) -> torch.Tensor:
    return torch.from_numpy(numpy_helper.to_array(constant).copy())


def _padded(given: torch.Tensor, told: _Attributes, fill: float = 0.0) -> torch.Tensor:
    """Pad as pads say: tops and lefts, then bottoms and rights.

    Raises:
        InputError: The padding depends on the size.
    """
    if told.get("auto_pad", b"NOTSET") not in (b"NOTSET", b"VALID"):
        raise InputError(f"the ONNX file has auto_pad={told['auto_pad'].decode()}; write pads")
    pads = told.get("pads", [0, 0, 0, 0])
    half = len(pads) // 2
    sides = [side for axis in reversed(range(half)) for side in (pads[axis], pads[half + axis])]
    return F.pad(given, sides, value=fill) if any(sides) else given


def _convolve(given: _Inputs, told: _Attributes) -> torch.Tensor:
    stride, dilation = told.get("strides", 1), told.get("dilations", 1)
    groups = told.get("group", 1)
    bias = given[2] if len(given) > 2 else None
    return F.conv2d(_padded(given[0], told), given[1], bias, stride, 0, dilation, groups)


def _pool_largest(given: _Inputs, told: _Attributes) -> torch.Tensor:
    padded = _padded(given[0], told, fill=-math.inf)
    return F.max_pool2d(
        padded,
        told["kernel_shape"],
        told.get("strides", 1),
        ceil_mode=bool(told.get("ceil_mode", 0)),
    )


def _pool_average(given: _Inputs, told: _Attributes) -> torch.Tensor:
    kernel, stride = told["kernel_shape"], told.get("strides", 1)
    sums = F.avg_pool2d(_padded(given[0], told), kernel, stride)
    if told.get("count_include_pad", 0):
        return sums
    inside = F.avg_pool2d(_padded(torch.ones_like(given[0]), told), kernel, stride)
    return sums / inside


def _normalise(given: _Inputs, told: _Attributes) -> torch.Tensor:
    images, scale, shift, mean, variance = given
    return F.batch_norm(images, mean, variance, scale, shift, eps=told.get("epsilon", 1e-5))


def _multiply(given: _Inputs, told: _Attributes) -> torch.Tensor:
    a, b, *c = given
    a = a.mT if told.get("transA") else a
    b = b.mT if told.get("transB") else b
    product: torch.Tensor = told.get("alpha", 1.0) * (a @ b)
    return product + told.get("beta", 1.0) * c[0] if c else product


def _reshape(given: _Inputs, told: _Attributes) -> torch.Tensor:
    images, shape = given[0], given[1].tolist()
    sizes = [images.shape[axis] if size == 0 else size for axis, size in enumerate(shape)]
    reshaped: torch.Tensor = images.reshape(sizes)
    return reshaped


def _average(given: _Inputs, told: _Attributes) -> torch.Tensor:
    axes = given[1].tolist() if len(given) > 1 else told["axes"]
    mean: torch.Tensor = given[0].mean(axes, keepdim=bool(told.get("keepdims", 1)))
    return mean


def _clip(given: _Inputs, told: _Attributes) -> torch.Tensor:
    low, high = [*given[1:], None, None][:2]
    clipped: torch.Tensor = given[0].clamp(
        told.get("min") if low is None else low, told.get("max") if high is None else high
    )
    return clipped


def _unsqueeze(given: _Inputs, told: _Attributes) -> torch.Tensor:
    (axis,) = given[1].tolist() if len(given) > 1 else told["axes"]
    unsqueezed: torch.Tensor = given[0].unsqueeze(axis)
    return unsqueezed


def _gather(given: _Inputs, told: _Attributes) -> torch.Tensor:
    places, axis = given[1], told.get("axis", 0)
    found: torch.Tensor = given[0].index_select(axis, places.reshape(-1))
    return found.squeeze(axis) if places.ndim == 0 else found


def _constant(given: _Inputs, told: _Attributes) -> torch.Tensor:
    value = told["value"] if "value" in told else next(iter(told.values()))
    return _tensor(value) if isinstance(value, onnx.TensorProto) else torch.tensor(value)


_OPERATIONS: Mapping[str, _Operation] = {
    "Abs": lambda x, _: x[0].abs(),
    "Add": lambda x, _: x[0] + x[1],
    "AveragePool": _pool_average,
    "BatchNormalization": _normalise,
    "Clip": _clip,
    "Concat": lambda x, a: torch.cat(x, a["axis"]),
    "Constant": _constant,
    "Conv": _convolve,
    "Div": lambda x, _: x[0] / x[1],
    "Dropout": lambda x, _: x[0],
    "Flatten": lambda x, a: x[0].reshape(math.prod(x[0].shape[: a.get("axis", 1)]), -1),
    "Gather": _gather,
    "Gemm": _multiply,
    "GlobalAveragePool": lambda x, _: x[0].mean((2, 3), keepdim=True),
    "Identity": lambda x, _: x[0],
    "LeakyRelu": lambda x, a: F.leaky_relu(x[0], a.get("alpha", 0.01)),
    "MatMul": _multiply,
    "MaxPool": _pool_largest,
    "Mul": lambda x, _: x[0] * x[1],
    "PRelu": lambda x, _: torch.where(x[0] < 0, x[0] * x[1], x[0]),
    "ReduceMean": _average,
    "Relu": lambda x, _: F.relu(x[0]),
    "Reshape": _reshape,
    "Shape": lambda x, _: torch.tensor(x[0].shape, device=x[0].device),
    "Sigmoid": lambda x, _: x[0].sigmoid(),
    "Sub": lambda x, _: x[0] - x[1],
    "Tanh": lambda x, _: x[0].tanh(),
    "Transpose": lambda x, a: x[0].permute(a["perm"]),
    "Unsqueeze": _unsqueeze,
}
