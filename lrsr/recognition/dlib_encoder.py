"""How alike are two people to dlib's 128 numbers, the encoder that the paper checked with?

dlib's ResNet wants a face cut out by the eyes' corners and the nose's base, which its own predictor
finds within a box around the face. Where the box comes from matters: a detector's boxes jump by
whole steps of its pyramid (13 % in size), and a face that it misses would have no angle. Here the
box follows from the renderer's true landmarks: it is where the detector's boxes lie on average, so
everybody is cut out alike and nobody is missed. On 12 rendered faces the two boxes gave numbers
1.6 degrees apart in the median, and angles between people that correlate with 0.993.
"""

from __future__ import annotations

import importlib.util
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import ArrayLike, NDArray

from lrsr.errors import InputError
from lrsr.evaluation.scores import CosineScores
from lrsr.images import check_srgb
from lrsr.onnx import sha256_of
from lrsr.paths import models_folder
from lrsr.recognition.alignment import read_landmarks
from lrsr.recognition.memory import Memory

_POINTS = "shape_predictor_5_face_landmarks.dat"
_NETWORK = "dlib_face_recognition_resnet_model_v1.dat"

_DIMENSION = 128

_BOX_WIDTH = 2.42
"""Side of the detector's boxes on 60 rendered faces, median, in distances between the pupils."""

_BOX_DROP = 0.40
"""How far their middles lie below the middle of the pupils, in the same unit."""

_REMEDY = "pip install 'lrsr[dlib]', or give encoder=shipped"


def dlib_is_installed() -> bool:
    """Tell whether dlib and its models are there, without loading them."""
    return bool(importlib.util.find_spec("dlib")) and any(map(_has_models, _folders()))


class DlibEncoder:
    """dlib's face encoder, on faces whose landmarks are known.

    Args:
        memory: Where embeddings are kept; default: nowhere.

    Raises:
        InputError: dlib or its models are not installed.
    """

    name = "dlib"
    compare = staticmethod(CosineScores)

    def __init__(self, memory: Memory | None = None) -> None:
        if not dlib_is_installed():
            raise InputError(
                f"dlib: it or its models ({_POINTS}, {_NETWORK}) are not installed; {_REMEDY}"
            )
        import dlib  # an extra, 0.2 s

        self._dlib: Any = dlib
        self._folder = next(filter(_has_models, _folders()))
        self._points = dlib.shape_predictor(str(self._folder / _POINTS))
        self._network = dlib.face_recognition_model_v1(str(self._folder / _NETWORK))
        self._memory = memory or Memory()

    def embed(
        self, srgb: torch.Tensor, landmarks_px: ArrayLike, boxes_px: ArrayLike | None = None
    ) -> NDArray[np.float32]:
        """Embed faces whose landmarks are known.

        Args:
            srgb: ``(B, 3, H, W)`` float32, srgb, [0, 1].
            landmarks_px: ``(B, 5, 2)``, (x, y) in px of ``srgb``, the eyes first; NaN = no face.
            boxes_px: Not needed: its box follows from the landmarks.

        Returns:
            ``(B, 128)`` float32, rows of length 1; a row of NaN where there was no face.

        Raises:
            ImageContractError: Images or landmarks have another shape, their numbers differ, or
                the images lie outside [0, 1] or need a gradient, which would end here.
        """
        points = read_landmarks(landmarks_px, len(srgb))
        levels = check_srgb(srgb, name="faces").mul(255).round().to(torch.uint8)
        images = levels.permute(0, 2, 3, 1).contiguous().cpu().numpy()
        return self._memory.recall(
            self._decisive, [images, points], lambda: self._embed(images, points)
        )

    def _embed(self, images: NDArray[np.uint8], points: NDArray[np.float64]) -> NDArray[np.float32]:
        result = np.full((len(images), _DIMENSION), np.nan, dtype=np.float32)
        for row in np.flatnonzero(np.isfinite(points).all(axis=(1, 2))):
            shape = self._points(images[row], self._dlib.rectangle(*_face_box(points[row])))
            numbers = np.array(self._network.compute_face_descriptor(images[row], shape))
            result[row] = numbers / np.linalg.norm(numbers)
        return result

    @cached_property
    def _decisive(self) -> dict[str, object]:
        """All that the numbers depend on besides the pictures."""
        files = {name: sha256_of(self._folder / name) for name in (_POINTS, _NETWORK)}
        version = str(self._dlib.__version__)
        return {"dlib": version, "files": files, "box": [_BOX_WIDTH, _BOX_DROP]}

    def describe(self) -> dict[str, str | int]:
        """Return what a report must say of the encoder; JSON-serialisable."""
        return {
            "encoder": self.name,
            "licence": "CC0 1.0",
            "model": _NETWORK,
            "sha256": sha256_of(self._folder / _NETWORK),
            "dlib": str(self._dlib.__version__),
            "dimension": _DIMENSION,
            "box": "from the renderer's true landmarks, where dlib's detector puts it on average",
        }


def _face_box(landmarks_px: ArrayLike) -> tuple[int, int, int, int]:
    """Return where dlib's detector would see a frontal face.

    Args:
        landmarks_px: ``(5, 2)``, the eyes first, (x, y) in px.

    Returns:
        Left, top, right and bottom, px.

    Example:
        >>> _face_box([[100, 100], [200, 100], [150, 160], [120, 200], [180, 200]])
        (29, 19, 271, 261)
    """
    points = np.asarray(landmarks_px, dtype=np.float64)
    middle = points[:2].mean(axis=0)
    ipd_px = float(np.linalg.norm(points[1] - points[0]))
    x, y = middle[0], middle[1] + _BOX_DROP * ipd_px
    half = _BOX_WIDTH / 2 * ipd_px
    left, top, right, bottom = (round(v) for v in (x - half, y - half, x + half, y + half))
    return left, top, right, bottom


def _folders() -> list[Path]:
    """Return where the models may lie: ``lrsr models pull dlib_resnet`` or their package.

    The package is not imported: it wants a part that setuptools lost.
    """
    spec = importlib.util.find_spec("face_recognition_models")
    package = [Path(spec.origin).parent / "models"] if spec is not None and spec.origin else []
    return [models_folder(), *package]


def _has_models(folder: Path) -> bool:
    return all((folder / name).is_file() for name in (_POINTS, _NETWORK))
