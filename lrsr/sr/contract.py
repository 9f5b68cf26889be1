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
    reach_px = 40               # how far it looks from a pixel, for tiles without seams; optional

    [output]                    # in the same channels, layout and range
    scale = 4
    lr_made_by = ""             # what small pictures it was trained on; optional

A height and width that the graph fixes are read from the graph; other pictures go through it in
tiles. A ``model.onnx`` of ``lrsr train`` carries all this and needs no contract, and for a quick
trial the fields can be typed: ``sr=onnx sr.model=theirs.onnx sr.contract.scale=4
sr.contract.channels=RGB``.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lrsr.errors import InputError
from lrsr.onnx import check_declared, contract_path, read_declared, sha256_of
from lrsr.sr.weights import LARGEST_SCALE, Card, blank_network

_TABLES = {
    "": ("sha256", "licence", "source"),
    "input": ("channels", "layout", "range", "enlarged", "multiple_of", "reach_px"),
    "output": ("scale", "lr_made_by"),
}
_CHOICES = {
    "input.channels": ("RGB", "BGR", "Y"),
    "input.layout": ("NCHW", "NHWC"),
    "input.range": ("0..1", "0..255"),
    "input.multiple_of": range(1, 1025),
    "input.reach_px": range(1025),
    "output.scale": range(1, LARGEST_SCALE + 1),
}


_USUAL = {"layout": "NCHW", "range": "0..1", "enlarged": False}
"""Of what is typed; a file leaves nothing out that decides about pixels."""


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
    reach_px: int | None = None
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


def read_contract(
    model: Path, properties: dict[str, str], typed: Mapping[str, Any] | None = None
) -> Contract:
    """Read the contract beside ``model``, or else the card that ``lrsr train`` left in it.

    Args:
        model: Path of the ``.onnx`` file.
        properties: The file's own.
        typed: Fields of a contract by name, where neither is there; ``layout``, ``range`` and
            ``enlarged`` have usual values.

    Raises:
        InputError: There is none of them or more than one, or it cannot be used.
    """
    there, ours = contract_path(model).is_file(), "architecture" in properties
    if typed and (there or ours):
        knows = f"{contract_path(model)} says" if there else f"{model} says itself"
        raise InputError(f"sr.contract={dict(typed)}: {knows} what the network takes; leave it")
    if there:
        return read_declared(Contract, model, _TABLES, _CHOICES)
    if ours:
        return _of_card(model, properties)
    if typed:
        return _of_words(model, typed)
    raise InputError(
        f"{model} is not of lrsr train, and {contract_path(model)} is missing: declare"
        " channels, range and scale there, as lrsr/sr/contract.py says, or try it with"
        " sr.contract.scale=... sr.contract.channels=RGB"
    )


def _of_words(model: Path, typed: Mapping[str, Any]) -> Contract:
    document: dict[str, Any] = {"sha256": sha256_of(model), "licence": "", "source": ""}
    fields = _USUAL | dict(typed)
    document["output"] = {name: fields.pop(name) for name in _TABLES["output"] if name in fields}
    return check_declared(Contract, {**document, "input": fields}, _TABLES, _CHOICES, "sr.contract")


def _of_card(model: Path, properties: dict[str, str]) -> Contract:
    try:
        card = Card.from_text(properties)
        reach_px = blank_network(card).reach_px
    except (InputError, TypeError) as error:
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
        reach_px=reach_px,
    )
