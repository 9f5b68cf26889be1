"""How does a trained embedder become a file that anyone can run? ONNX and contract, checked."""

import logging
import warnings
from pathlib import Path
from typing import cast

import numpy as np
import onnx
import torch

from lrsr.files import replacing, write_text
from lrsr.recognition.alignment import CROP_PX
from lrsr.recognition.arcface import MEAN, SCALE
from lrsr.recognition.backbone import DIMENSION, Backbone
from lrsr.recognition.contract import Contract, contract_path, sha256_of, write_contract
from lrsr.recognition.embedding import Embedder, unit_rows

TOLERANCE = 1e-4
"""How far the ONNX model's unit embeddings may be from PyTorch's."""


def export_embedder(backbone: Backbone, path: Path, *, antialias: bool, source: str) -> Contract:
    """Write the network as ONNX (float32, any batch) with its contract, and check it.

    Args:
        backbone: The trained network.
        path: Of the ``.onnx`` file; the contract lands beside it.
        antialias: How faces are aligned for it.
        source: How it was made, for the contract.

    Returns:
        The contract.

    Raises:
        RuntimeError: The ONNX model computes something else than the network.
        InputError: The folder cannot be written.
    """
    network = backbone.float().cpu().eval()
    with replacing(path) as temporary:
        _write_onnx(network, temporary)
    contract = Contract(
        sha256=sha256_of(path),
        licence="MIT",
        source=source,
        layout="NCHW",
        channels="RGB",
        height_px=CROP_PX,
        width_px=CROP_PX,
        mean=MEAN,
        scale=SCALE,
        dimension=DIMENSION,
        template="arcface5",
        antialias=antialias,
    )
    write_text(contract_path(path), write_contract(contract))
    difference = _difference(network, Embedder(path))
    if difference > TOLERANCE:
        raise RuntimeError(f"{path} differs from the network by {difference:.1e}; report this")
    return contract


def _write_onnx(network: Backbone, path: Path) -> None:
    talkers = [logging.getLogger(name) for name in ("torch.onnx", "onnxscript", "onnx_ir")]
    levels = [talker.level for talker in talkers]
    for talker in talkers:
        talker.setLevel(logging.ERROR)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the exporter's own, about its own dependencies
            program = torch.onnx.export(
                network,
                (torch.zeros(2, 3, CROP_PX, CROP_PX),),
                input_names=["faces"],
                output_names=["embeddings"],
                dynamic_shapes={"faces": {0: torch.export.Dim("batch")}},
                external_data=False,
                dynamo=True,
                verbose=False,
            )
    finally:
        for talker, level in zip(talkers, levels, strict=True):
            talker.setLevel(level)
    model: onnx.ModelProto = cast("torch.onnx.ONNXProgram", program).model_proto
    graph = model.graph
    for part in (*graph.node, *graph.input, *graph.output, *graph.value_info):
        del part.metadata_props[:]  # they hold stack traces, with the paths of this machine
    path.write_bytes(model.SerializeToString())


def _difference(network: Backbone, embedder: Embedder) -> float:
    generator = torch.Generator().manual_seed(0)
    crops = torch.rand(5, 3, CROP_PX, CROP_PX, generator=generator)
    with torch.no_grad():
        wanted = unit_rows(network((crops * 255 - MEAN) / SCALE).numpy())
    return float(np.abs(embedder(crops) - wanted).max())
