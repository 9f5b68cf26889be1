"""What can recognise, by name? Embedders, dlib's or any ONNX file, features, mixed resolutions.

All of them are one protocol: faces become rows of numbers, and rows become scores.
"""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, Protocol, get_args

import numpy as np
import torch
from numpy.typing import ArrayLike, NDArray

from lrsr.errors import InputError
from lrsr.evaluation.scores import ScoreSource
from lrsr.recognition.dlib_encoder import DlibEncoder, dlib_is_installed
from lrsr.recognition.engine import Engine
from lrsr.recognition.features import FEATURES, Features
from lrsr.recognition.memory import Memory
from lrsr.recognition.mixed_resolution import NAME as MIXED
from lrsr.recognition.mixed_resolution import MixedResolution
from lrsr.recognition.registry import model_file

_SHIPPED = "shipped"
_DLIB = ("dlib", "dlib_resnet")

_EncoderName = Literal["auto", "dlib", "shipped"]
_ENCODERS: tuple[_EncoderName, ...] = get_args(_EncoderName)


class Recogniser(Protocol):
    """Turns faces into numbers, and says how alike two are."""

    def embed(
        self, srgb: torch.Tensor, landmarks_px: ArrayLike, boxes_px: ArrayLike | None = None
    ) -> NDArray[np.float32]:
        """Return ``(B, D)`` for ``(B, 3, H, W)`` srgb and ``(B, 5, 2)`` px; NaN = no face.

        Boxes ``(B, 4)`` px are for those whose alignment wants them.
        """

    def compare(
        self,
        probes: NDArray[Any],
        gallery: NDArray[Any],
        probe_ids: Sequence[str],
        gallery_ids: Sequence[str],
    ) -> ScoreSource:
        """Return scores, higher = more alike, of ``(P, D)`` probes and ``(G, D)`` gallery rows."""

    def describe(self) -> Mapping[str, object]:
        """Return what a report must say of it; JSON-serialisable."""


SMALLEST_ANGLE_DEG = {"dlib": 11.2, "shipped": 20.0}
"""Below it two people count as one. dlib: the smallest among the paper's 1500 identities."""


def resolve_encoder(name: str) -> Literal["dlib", "shipped"]:
    """Turn "auto" into "dlib" where it is installed, else into "shipped".

    Raises:
        InputError: There is no such encoder, or dlib is asked for and not installed.
    """
    if name not in _ENCODERS:
        raise InputError(f"encoder={name}: wanted one of {', '.join(_ENCODERS)}")
    if name == "dlib" and not dlib_is_installed():
        DlibEncoder()  # says what is missing
    if name == "shipped" or not dlib_is_installed():
        return "shipped"
    return "dlib"


def load_encoder(
    name: Literal["dlib", "shipped"],
    model: Path | None = None,
    *,
    device: str = "cpu",
    memory: Memory | None = None,
) -> Recogniser:
    """Load what is to tell whether two people are two: dlib's, as in the paper, or the shipped one.

    Args:
        name: See :func:`resolve_encoder`.
        model: ONNX embedder that stands in for the shipped one.
        device: Where an ONNX embedder runs; see :func:`lrsr.onnx.providers_on`.
        memory: Where embeddings are kept; default: nowhere.

    Raises:
        InputError: A model is missing or broken, or is given although dlib is to compare.
    """
    if name == "dlib" and model is not None:
        raise InputError(f"recognition.model={model}: dlib takes none; add encoder=shipped")
    if name == "dlib":
        return DlibEncoder(memory)
    return Engine(model, device=device, memory=memory)


def find_recognisers(
    names: Sequence[str], model: Path | None = None, weights: Path | None = None
) -> dict[str, str | Path]:
    """Find recognisers without loading them.

    Args:
        names: Each "shipped", "dlib", one of :data:`lrsr.recognition.features.FEATURES`,
            "mixed_resolution", a name that ``lrsr models list`` knows, or a file: ONNX, or
            safetensors of ``lrsr train recognition=mixed_resolution``.
        model: ONNX embedder that stands in for the shipped one.
        weights: Such safetensors for "mixed_resolution".

    Returns:
        A file, or a name that needs none, by what a report calls it: the file's, without ending.

    Raises:
        InputError: There is none, several have one name, one is not here or not known, a model
            stands in for nobody, or weights are missing or for nobody.
    """
    if not names:
        raise InputError("recognition.recognisers=[]: wanted at least one, such as shipped")
    if model is not None and _SHIPPED not in names:
        raise InputError(f"recognition.model={model}: add shipped to recognisers, or leave it")
    if weights is not None and MIXED not in names:
        raise InputError(f"recognition.weights={weights}: add {MIXED} to recognisers, or leave it")
    if weights is None and MIXED in names:
        raise InputError(
            f"recognition.weights=null: {MIXED} has none of its own; give the model.safetensors"
            f" of lrsr train recognition={MIXED}"
        )
    stand_in = {_SHIPPED: model, MIXED: weights}
    found: dict[str, str | Path] = {}
    for name in names:
        known = name in (_SHIPPED, MIXED, *_DLIB, *FEATURES)
        source = stand_in.get(name) or (known and name) or model_file(name, "recogniser")
        label = source.stem if isinstance(source, Path) and name != MIXED else name
        if label in found:
            raise InputError(f"recognition.recognisers: {label} is there twice; give it once")
        found[label] = source
    if any(name in _DLIB for name in names) and not dlib_is_installed():
        DlibEncoder()  # says what is missing
    return found


def load_recognisers(
    found: Mapping[str, str | Path],
    engine: Callable[[Path | None], Engine] = Engine,
    memory: Memory | None = None,
) -> dict[str, Recogniser]:
    """Load recognisers.

    Args:
        found: By :func:`find_recognisers`.
        engine: Makes the one of an ONNX file, None: of the shipped one.
        memory: Where dlib's embeddings are kept; default: nowhere.

    Returns:
        Them, by the same names.

    Raises:
        InputError: A file is broken.
    """
    return {label: _load(source, engine, memory) for label, source in found.items()}


def _load(
    source: str | Path, engine: Callable[[Path | None], Engine], memory: Memory | None
) -> Recogniser:
    if isinstance(source, Path):
        mixed = source.suffix == ".safetensors"
        return MixedResolution(source) if mixed else engine(source)
    if source == _SHIPPED:
        return engine(None)
    return Features(source) if source in FEATURES else DlibEncoder(memory)
