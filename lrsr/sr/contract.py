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

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lrsr.errors import InputError
from lrsr.onnx import Fields, contract_path, read_fields, sha256_of
from lrsr.sr.weights import LARGEST_SCALE, Card

_TABLES: Fields = {
    "": {"sha256": str, "licence": str, "source": str},
    "input": {"channels": str, "layout": str, "range": str, "enlarged": bool, "multiple_of": 1},
    "output": {"scale": int, "lr_made_by": ""},
}
_CHOICES = {
    "input.channels": ("RGB", "BGR", "Y"),
    "input.layout": ("NCHW", "NHWC"),
    "input.range": ("0..1", "0..255"),
    "input.multiple_of": range(1, 1025),
    "output.scale": range(1, LARGEST_SCALE + 1),
}


@dataclass(frozen=True)
class Contract:
    """One network's declared contract; see the module for the meaning of each field."""

    sha256: str
    licence: str
    source: str
    channels: str
    layout: str
    range: str
    enlarged: bool
    multiple_of: int
    scale: int
    lr_made_by: str

    @property
    def white(self) -> float:
        """What the network calls srgb 1."""
        return 255.0 if self.range == "0..255" else 1.0

    @property
    def takes(self) -> tuple[tuple[int | None, ...], str]:
        """Shape of a batch, None where any size will do, and words for it."""
        channels = len(self.channels)
        nchw, nhwc = (None, channels, None, None), (None, None, None, channels)
        shape = nchw if self.layout == "NCHW" else nhwc
        return shape, f"float {self.layout} of {self.channels}"

    def height_and_width(self, shape: Sequence[object], model: Path) -> Sequence[object]:
        """Take height and width, numbers where they are fixed, out of the shape of the input.

        Raises:
            InputError: Something is fixed, but not the channels: it is of the other layout.
        """
        first = self.layout == "NCHW"
        size, channels = (shape[2:], shape[1]) if first else (shape[1:3], shape[3])
        if not isinstance(channels, int) and any(isinstance(side, int) for side in size):
            raise InputError(
                f"{model}: takes {shape}, its contract says {self.takes[1]};"
                " mend the contract or give the model it was written for"
            )
        return size


def read_contract(model: Path, properties: dict[str, str]) -> Contract:
    """Read the contract beside ``model``, or else the card that ``lrsr train`` left in it.

    Args:
        model: Path of the ``.onnx`` file.
        properties: The file's own.

    Raises:
        InputError: There is neither, or the contract or card cannot be used.
    """
    if contract_path(model).is_file():
        return Contract(**read_fields(model, _TABLES, _CHOICES))
    if "architecture" not in properties:
        raise InputError(
            f"{model} is not of lrsr train, and {contract_path(model)} is missing: declare"
            " channels, range and scale there, as lrsr/sr/contract.py says"
        )
    try:
        card = Card.from_text(properties)
    except InputError as error:
        raise InputError(f"{model} is not of lrsr train: {error}; export it again") from error
    return Contract(sha256=sha256_of(model), **_of_card(card))


def _of_card(card: Card) -> dict[str, Any]:
    return {
        "licence": "",
        "source": card.architecture,
        "channels": "Y" if card.input == "luminance" else "RGB",
        "layout": "NCHW",
        "range": "0..1",
        "enlarged": bool(card.enlarged_by),
        "multiple_of": 1,
        "scale": card.scale,
        "lr_made_by": card.lr_made_by,
    }
