"""What leaves the house? A network as an ONNX file for any runtime, once it agrees with torch."""

import logging
import math
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import cast

import numpy as np
import onnx
import torch
from torch import nn

from lrsr.errors import NonFiniteError
from lrsr.files import replacing
from lrsr.onnx import open_session

_OPSET = 18
_TOLERANCE = 1e-5


def export_onnx(
    path: Path,
    network: nn.Module,
    *,
    shapes: Sequence[tuple[int, ...]],
    names: tuple[str, str],
    free: Mapping[int, str],
    about: Mapping[str, str],
) -> float:
    """Write a network of one input and one output as ONNX (float32), once it agrees with torch.

    Args:
        path: Of the ``.onnx`` file.
        network: In evaluation mode, float32, on the CPU.
        shapes: Of the inputs on which both are compared; the first one is traced, its free sizes
            are at least 2.
        names: Of input and output.
        free: The dimensions of the input that may have any size, and their names.
        about: The file's own properties.

    Returns:
        The largest difference found between onnxruntime and torch on random images, relative to the
        largest value where that is over 1.

    Raises:
        NonFiniteError: The network returns a NaN; nothing is written.
        RuntimeError: The two differ by more than 1e-5; nothing is written.
        InputError: The folder cannot be written or the disk is full.
    """
    content = _as_onnx(network, shapes[0], names, free, about)
    with replacing(path) as temporary:
        temporary.write_bytes(content)
        difference = max(_difference(temporary, network, names[0], shape) for shape in shapes)
        if not math.isfinite(difference):
            raise NonFiniteError(f"{path} is not written: the network returns NaN or infinity")
        if difference > _TOLERANCE:
            raise RuntimeError(
                f"{path}: ONNX and torch differ by {difference:.1e}, over {_TOLERANCE}"
            )
    return difference


def _as_onnx(
    network: nn.Module,
    shape: tuple[int, ...],
    names: tuple[str, str],
    free: Mapping[int, str],
    about: Mapping[str, str],
) -> bytes:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the exporter warns of its own inner changes
        logging.disable(logging.WARNING)  # and reports each pass
        try:
            program = torch.onnx.export(
                network,
                (torch.rand(shape),),
                input_names=[names[0]],
                output_names=[names[1]],
                dynamic_shapes=({axis: torch.export.Dim(name) for axis, name in free.items()},),
                opset_version=_OPSET,
                dynamo=True,
                external_data=False,
                verbose=False,
            )
        finally:
            logging.disable(logging.NOTSET)
    model: onnx.ModelProto = cast("torch.onnx.ONNXProgram", program).model_proto
    graph = model.graph
    for part in (*graph.node, *graph.input, *graph.output, *graph.value_info):
        del part.metadata_props[:]  # they hold stack traces, with the paths of this machine
    onnx.helper.set_model_props(model, dict(about))
    onnx.checker.check_model(model)
    content: bytes = model.SerializeToString()
    return content


def _difference(path: Path, network: nn.Module, name: str, shape: tuple[int, ...]) -> float:
    images = torch.rand(shape, generator=torch.Generator().manual_seed(0))
    (found,) = open_session(path).run(None, {name: images.numpy()})
    with torch.no_grad():
        expected = network(images).numpy()
    return float(np.abs(found - expected).max() / max(1.0, np.abs(expected).max()))
