"""What tells one face from another? Find, align, embed; the cosine of two is how alike they are."""

from dataclasses import asdict
from functools import cached_property
from pathlib import Path
from typing import Literal, cast, get_args

import numpy as np
import torch
from numpy.typing import ArrayLike, NDArray

from lrsr.evaluation.scores import CosineScores
from lrsr.images import check_srgb
from lrsr.paths import asset
from lrsr.recognition.alignment import Template, align, read_landmarks, whole_pictures
from lrsr.recognition.detection.detector import Detector
from lrsr.recognition.embedding import Embedder
from lrsr.recognition.finder import Faces, Finder
from lrsr.recognition.memory import Memory

Fallback = Literal["none", "whole_image"]
FALLBACKS: tuple[Fallback, ...] = get_args(Fallback)

_DEFAULT_MODEL = "weights/arcface_small.onnx"
"""Trained on rendered faces by ``lrsr train recognition=arcface``; its record lies beside it."""


class Engine:
    """Finds faces, or takes them where they are known to be, aligns and embeds them.

    Args:
        model: An ONNX embedder with its contract beside it; default: the one that ships.
        antialias: Overrules the contract's: average when alignment makes a face smaller?
        device: Where the networks run; see :func:`lrsr.onnx.providers_on`.
        finder: Default: with the detector that ships, loaded when it is first needed.
        template: Overrules the contract's alignment.
        fallback: What stands for a face that was not found: nothing, or as in DeepFace the whole
            picture, which hides the failure.
        memory: Where embeddings are kept; default: nowhere.

    Raises:
        InputError: See :class:`lrsr.recognition.embedding.Embedder`.
    """

    compare = staticmethod(CosineScores)

    def __init__(
        self,
        model: Path | None = None,
        *,
        antialias: bool | None = None,
        device: str = "cpu",
        finder: Finder | None = None,
        template: Template | None = None,
        fallback: Fallback = "none",
        memory: Memory | None = None,
    ) -> None:
        self.embedder = Embedder(model or asset(_DEFAULT_MODEL), device=device)
        contract = self.embedder.contract
        self.antialias = contract.antialias if antialias is None else antialias
        self.template = template or cast("Template", contract.template)
        self.fallback: Fallback = fallback
        self._finder, self._memory, self._device = finder, memory or Memory(), device

    @cached_property
    def finder(self) -> Finder:
        """What finds faces."""
        return self._finder or Finder(Detector(device=self._device), self._memory)

    def find(self, srgb: torch.Tensor) -> Faces:
        """Find the face that each picture is of; see :class:`lrsr.recognition.finder.Finder`."""
        return self.finder(srgb)

    def embed(
        self, srgb: torch.Tensor, landmarks_px: ArrayLike, boxes_px: ArrayLike | None = None
    ) -> NDArray[np.float32]:
        """Embed faces whose landmarks are known, or were found by :meth:`find`.

        Args:
            srgb: ``(B, 3, H, W)`` float32, srgb, [0, 1].
            landmarks_px: ``(B, 5, 2)``, (x, y) in px of ``srgb``; NaN or masked = no face was
                found.
            boxes_px: ``(B, 4)``, for alignment as DeepFace's.

        Returns:
            ``(B, D)`` float32, rows of length 1; a row of NaN is a failure to acquire.

        Raises:
            ImageContractError: Images or landmarks have another shape, their numbers differ, or
                the images lie outside [0, 1] or need a gradient, which would end here.
        """
        pixels = check_srgb(srgb).numpy(force=True)
        points = read_landmarks(landmarks_px, None)
        boxes = None if boxes_px is None else np.asarray(boxes_px, dtype=np.float64)
        how = {"template": self.template, "antialias": self.antialias, "fallback": self.fallback}
        about = {"embed": asdict(self.embedder.contract), "device": self._device, **how}
        arrays = [pixels, points, *([] if boxes is None else [boxes])]
        return self._memory.recall(about, arrays, lambda: self._embed(srgb, points, boxes))

    def _embed(
        self, srgb: torch.Tensor, points: NDArray[np.float64], boxes: NDArray[np.float64] | None
    ) -> NDArray[np.float32]:
        contract = self.embedder.contract
        crops, found = align(
            srgb,
            points,
            antialias=self.antialias,
            template=self.template,
            boxes_px=boxes,
            size_px=(contract.height_px, contract.width_px),
        )
        if self.fallback == "whole_image" and not found.all():
            missed = torch.from_numpy(~found)
            crops[missed] = whole_pictures(srgb[missed], contract.height_px)
            found = np.ones_like(found)
        result = np.full((len(crops), contract.dimension), np.nan, dtype=np.float32)
        result[found] = self.embedder(crops[torch.from_numpy(found)])
        return result

    def describe(self) -> dict[str, object]:
        """Return what a report must say of the recogniser; JSON-serialisable."""
        contract = self.embedder.contract
        return {
            "model": self.embedder.model.name,
            "sha256": contract.sha256,
            "licence": contract.licence,
            "source": contract.source,
            "dimension": contract.dimension,
            "alignment": self.template,
            "antialias": self.antialias,
            "fallback": self.fallback,
            "providers": ", ".join(self.embedder.providers),
        }
