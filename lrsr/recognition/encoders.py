"""Which network judges whether two people are two? dlib's, as in the paper, or the one we ship."""

from collections.abc import Mapping
from pathlib import Path
from typing import Literal, Protocol, get_args

import numpy as np
import torch
from numpy.typing import ArrayLike, NDArray

from lrsr.errors import InputError
from lrsr.recognition.dlib_encoder import DlibEncoder, dlib_is_installed
from lrsr.recognition.engine import Engine

_EncoderName = Literal["auto", "dlib", "shipped"]
_ENCODERS: tuple[_EncoderName, ...] = get_args(_EncoderName)


class Encoder(Protocol):
    """Embeds faces whose landmarks are known; the angle between rows tells how alike they are."""

    def embed(self, srgb: torch.Tensor, landmarks_px: ArrayLike) -> NDArray[np.float32]:
        """Return ``(B, D)`` rows of length 1 for ``(B, 3, H, W)`` srgb and ``(B, 5, 2)`` px."""

    def describe(self) -> Mapping[str, object]:
        """Return what a report must say of the encoder; JSON-serialisable."""


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


def load_encoder(name: Literal["dlib", "shipped"], model: Path | None = None) -> Encoder:
    """Load an encoder.

    Args:
        name: See :func:`resolve_encoder`.
        model: ONNX embedder that stands in for the shipped one.

    Raises:
        InputError: A model is missing or broken, or is given although dlib is to compare.
    """
    if name == "dlib" and model is not None:
        raise InputError(f"recognition.model={model}: dlib takes none; add encoder=shipped")
    return DlibEncoder() if name == "dlib" else Engine(model)
