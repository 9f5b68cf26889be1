"""What does an embedding model expect and return? Declared in a TOML file beside it, never sniffed.

``face.onnx`` needs ``face.toml``::

    sha256 = "…"                # of face.onnx
    licence = "MIT"
    source = "lrsr train recognition=arcface, seed 7"

    [input]
    layout = "NCHW"             # or "NHWC"
    channels = "RGB"            # or "BGR"
    height_px = 112
    width_px = 112
    mean = 127.5                # the model sees (255 srgb - mean) / scale, each a number or
    scale = 127.5               # three, in the order of `channels`: [104, 117, 123]

    [output]
    dimension = 128
    name = "embeddings"         # may be left out where the graph has one output

    [alignment]
    template = "arcface5"       # or "eyes" or "deepface"
    antialias = true            # average when the face is made smaller; insightface does not

The numbers that the graph states too (sizes, dimension) must agree with it; what it cannot state
(channel order, mean, scale, antialias) is taken from here and from nowhere else.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch

from lrsr.errors import InputError
from lrsr.onnx import PerChannel, contract_path, declared_text, read_declared
from lrsr.recognition.alignment import TEMPLATES

_TABLES = {
    "": ("sha256", "licence", "source"),
    "input": ("layout", "channels", "height_px", "width_px", "mean", "scale"),
    "output": ("dimension", "name"),
    "alignment": ("template", "antialias"),
}
_CHOICES = {
    "input.layout": ("NCHW", "NHWC"),
    "input.channels": ("RGB", "BGR"),
    "alignment.template": TEMPLATES,
}
_SIDES_PX = range(16, 1025)


@dataclass(frozen=True)
class Contract:
    """One model's declared contract; see the module for the meaning of each field."""

    sha256: str
    licence: str
    source: str
    layout: str
    channels: str
    height_px: int
    width_px: int
    mean: PerChannel
    scale: PerChannel
    dimension: int
    template: str
    antialias: bool
    name: str = ""

    @property
    def input_shape(self) -> tuple[int, int, int]:
        """Shape of one image as the model takes it, without the batch."""
        if self.layout == "NCHW":
            return (3, self.height_px, self.width_px)
        return (self.height_px, self.width_px, 3)

    def prepare(self, crops: torch.Tensor) -> torch.Tensor:
        """Turn srgb ``(B, 3, h, w)``, [0, 1], into what the model takes."""
        values = crops * 255
        if self.channels == "BGR":
            values = values.flip(1)
        mean, scale = (
            torch.as_tensor(each, dtype=crops.dtype, device=crops.device).view(-1, 1, 1)
            for each in (self.mean, self.scale)
        )
        values = (values - mean) / scale
        return values.permute(0, 2, 3, 1) if self.layout == "NHWC" else values


def read_contract(model: Path) -> Contract:
    """Read the contract beside ``model`` and check the model's bytes against its sha256.

    Args:
        model: Path of the ``.onnx`` file.

    Raises:
        InputError: Model or contract is missing or unreadable; a field is missing, unknown or
            out of range; or the model is not the one that the contract was written for.
    """
    contract = read_declared(Contract, model, _TABLES, _CHOICES)
    path = contract_path(model)
    if min(np.ravel(contract.scale)) <= 0 or contract.dimension <= 0:
        raise InputError(f"{path}: input.scale and output.dimension must be above 0")
    sizes = contract.height_px, contract.width_px
    if contract.template == "deepface" and len({*sizes}) > 1:
        raise InputError(f"{path}: input is {sizes[0]}×{sizes[1]} px; deepface wants a square")
    if not set(sizes) <= set(_SIDES_PX):
        raise InputError(f"{path}: input is {sizes[0]}×{sizes[1]} px; wanted 16 to 1024 each")
    return contract


def write_contract(contract: Contract) -> str:
    """Return the contract as TOML; :func:`read_contract` reads it back unchanged."""
    document: dict[str, Any] = {}
    for table, names in _TABLES.items():
        values = {name: getattr(contract, name) for name in names}
        told = {name: value for name, value in values.items() if value != ""}
        document |= {table: told} if table else told
    return declared_text(document)
