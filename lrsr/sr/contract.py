"""What does somebody's ONNX network for super-resolution take? Declared beside it, never sniffed.

``theirs.onnx`` needs ``theirs.toml``::

    sha256 = "…"                # of theirs.onnx
    licence = "Apache-2.0"
    source = "https://…"

    [input]
    channels = "RGB"            # or "BGR"; "Y": BT.601 luminance, the chroma goes up bicubically
    layout = "NCHW"             # or "NHWC"
    range = "0..1"              # or "0..255"; for Y that is 16..235 of 255
    enlarged = false            # true: bicubically before the network, which keeps its size
    multiple_of = 1             # of height and width, where the network asks for that; optional

    [output]                    # in the same channels, layout and range
    scale = 4
    lr_made_by = ""             # what small pictures it was trained on; optional

A height and width that the graph fixes are read from the graph; other pictures go through it in
tiles. A ``model.onnx`` of ``lrsr train`` carries all this and needs no contract.
"""

from dataclasses import dataclass
from pathlib import Path

from lrsr.errors import InputError
from lrsr.onnx import contract_path, read_declared, sha256_of
from lrsr.sr.weights import LARGEST_SCALE, Card

_TABLES = {
    "": ("sha256", "licence", "source"),
    "input": ("channels", "layout", "range", "enlarged", "multiple_of"),
    "output": ("scale", "lr_made_by"),
}
_CHOICES = {
    "input.channels": ("RGB", "BGR", "Y"),
    "input.layout": ("NCHW", "NHWC"),
    "input.range": ("0..1", "0..255"),
    "input.multiple_of": range(1, 1025),
    "output.scale": range(1, LARGEST_SCALE + 1),
}


@dataclass(frozen=True, kw_only=True)
class Contract:
    """One network's declared contract; see the module for the meaning of each field."""

    sha256: str
    licence: str
    source: str
    channels: str
    layout: str
    range: str
    enlarged: bool
    multiple_of: int = 1
    scale: int
    lr_made_by: str = ""

    @property
    def white(self) -> float:
        """What the network calls srgb 1."""
        return 255.0 if self.range == "0..255" else 1.0

    @property
    def shape(self) -> tuple[int | None, ...]:
        """Shape of a batch, None where any size will do."""
        sides, channels = (None, None), (len(self.channels),)
        return (None, *channels, *sides) if self.layout == "NCHW" else (None, *sides, *channels)


def read_contract(model: Path, properties: dict[str, str]) -> Contract:
    """Read the contract beside ``model``, or else the card that ``lrsr train`` left in it.

    Args:
        model: Path of the ``.onnx`` file.
        properties: The file's own.

    Raises:
        InputError: There is neither, or the contract or card cannot be used.
    """
    if contract_path(model).is_file():
        return read_declared(Contract, model, _TABLES, _CHOICES)
    if "architecture" not in properties:
        raise InputError(
            f"{model} is not of lrsr train, and {contract_path(model)} is missing: declare"
            " channels, range and scale there, as lrsr/sr/contract.py says"
        )
    try:
        card = Card.from_text(properties)
    except InputError as error:
        raise InputError(f"{model} is not of lrsr train: {error}; export it again") from error
    return Contract(
        sha256=sha256_of(model),
        licence="",
        source=card.architecture,
        layout="NCHW",
        range="0..1",
        channels="Y" if card.input == "luminance" else "RGB",
        enlarged=bool(card.enlarged_by),
        scale=card.scale,
        lr_made_by=card.lr_made_by,
    )
