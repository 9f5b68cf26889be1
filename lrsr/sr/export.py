"""What leaves the package: SRCNN as an ONNX file that any runtime takes.

Input ``luminance`` (N, 1, H, W) float32: studio-range BT.601 luminance / 255, already enlarged;
output ``restored``, the same size, not clipped. The replicate padding is part of the graph, and the
file's own properties say for which scale, kernel and kind of small image it was trained.
"""

import logging
import math
import warnings
from pathlib import Path
from typing import cast

import numpy as np
import onnx
import onnxruntime
import torch

from lrsr.errors import NonFiniteError
from lrsr.files import write_bytes
from lrsr.sr.srcnn import SRCNN
from lrsr.sr.weights import Recipe

OPSET = 18
TOLERANCE = 1e-5
_CHECKED_SHAPES = ((1, 1, 32, 32), (2, 1, 13, 40))


def export_onnx(path: Path, network: SRCNN, recipe: Recipe) -> float:
    """Write the network as ONNX (opset 18, dynamic N, H, W), once it agrees with torch.

    Returns:
        The largest difference found between onnxruntime and torch on random images.

    Raises:
        NonFiniteError: The network returns a NaN; nothing is written.
        RuntimeError: The two differ by more than 1e-5; nothing is written.
    """
    network = _keeping_size(network)
    content = _as_onnx(network, recipe)
    session = onnxruntime.InferenceSession(content, providers=["CPUExecutionProvider"])
    difference = max(_difference(session, network, shape) for shape in _CHECKED_SHAPES)
    if not math.isfinite(difference):
        raise NonFiniteError(f"{path} is not written: the network returns NaN or infinity")
    if difference > TOLERANCE:
        raise RuntimeError(f"{path}: ONNX and torch differ by {difference:.1e}, over {TOLERANCE}")
    write_bytes(path, content)
    return difference


def _keeping_size(network: SRCNN) -> SRCNN:
    """Copy the network in float32 on the CPU, with replicate padding."""
    copy = SRCNN(padding="replicate")
    copy.load_state_dict({name: value.float() for name, value in network.state_dict().items()})
    return copy.eval()


def _as_onnx(network: SRCNN, recipe: Recipe) -> bytes:
    batch, height, width = (torch.export.Dim(name) for name in ("N", "H", "W"))
    for name in ("onnx_ir", "onnxscript"):
        logging.getLogger(name).setLevel(logging.WARNING)  # they report each pass
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the exporter warns of its own inner changes
        program = torch.onnx.export(
            network,
            (torch.rand(2, 1, 24, 20),),
            input_names=["luminance"],
            output_names=["restored"],
            dynamic_shapes=({0: batch, 2: height, 3: width},),
            opset_version=OPSET,
            dynamo=True,
            external_data=False,
            verbose=False,
        )
    model: onnx.ModelProto = cast("torch.onnx.ONNXProgram", program).model_proto
    for part in (
        *model.graph.node,
        *model.graph.input,
        *model.graph.output,
        *model.graph.value_info,
    ):
        del part.metadata_props[:]  # they hold stack traces, with the paths of this machine
    onnx.helper.set_model_props(model, recipe.as_text())
    onnx.checker.check_model(model)
    content: bytes = model.SerializeToString()
    return content


def _difference(
    session: onnxruntime.InferenceSession, network: SRCNN, shape: tuple[int, ...]
) -> float:
    luminance = torch.rand(shape, generator=torch.Generator().manual_seed(0))
    (restored,) = session.run(None, {"luminance": luminance.numpy()})
    with torch.no_grad():
        expected = network(luminance).numpy()
    return float(np.abs(restored - expected).max())
