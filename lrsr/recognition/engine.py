"""What tells one face from another? Align it, embed it; the cosine of two is how alike they are."""

from pathlib import Path

import numpy as np
import torch
from numpy.typing import ArrayLike, NDArray

from lrsr.evaluation.scores import CosineScores
from lrsr.images import check_srgb
from lrsr.paths import asset
from lrsr.recognition.alignment import align
from lrsr.recognition.embedding import Embedder

_DEFAULT_MODEL = "weights/arcface_small.onnx"
"""Trained on rendered faces by ``lrsr train recognition=arcface``; its record lies beside it."""


class Engine:
    """Aligns faces by five given landmarks and embeds them.

    Args:
        model: An ONNX embedder with its contract beside it; default: the one that ships.
        antialias: Overrules the contract's: average when alignment makes a face smaller?
        device: Where the embedder runs; see :func:`lrsr.onnx.providers_on`.

    Raises:
        InputError: See :class:`lrsr.recognition.embedding.Embedder`.
    """

    compare = staticmethod(CosineScores)

    def __init__(
        self, model: Path | None = None, *, antialias: bool | None = None, device: str = "cpu"
    ) -> None:
        self.embedder = Embedder(model or asset(_DEFAULT_MODEL), device=device)
        self.antialias = self.embedder.contract.antialias if antialias is None else antialias

    def embed(self, srgb: torch.Tensor, landmarks_px: ArrayLike) -> NDArray[np.float32]:
        """Embed faces whose landmarks are known.

        Args:
            srgb: ``(B, 3, H, W)`` float32, srgb, [0, 1].
            landmarks_px: ``(B, 5, 2)``, (x, y) in px of ``srgb``; NaN or masked = no face was
                found.

        Returns:
            ``(B, D)`` float32, rows of length 1; a row of NaN is a failure to acquire.

        Raises:
            ImageContractError: Images or landmarks have another shape, their numbers differ, or
                the images lie outside [0, 1] or need a gradient, which would end here.
        """
        check_srgb(srgb)
        contract = self.embedder.contract
        size_px = contract.height_px, contract.width_px
        crops, found = align(srgb, landmarks_px, antialias=self.antialias, size_px=size_px)
        result = np.full((len(crops), contract.dimension), np.nan, dtype=np.float32)
        result[found] = self.embedder(crops[torch.from_numpy(found)])
        return result

    def describe(self) -> dict[str, str | int | float | bool]:
        """Return what a report must say of the recogniser; JSON-serialisable."""
        contract = self.embedder.contract
        return {
            "model": self.embedder.model.name,
            "sha256": contract.sha256,
            "licence": contract.licence,
            "source": contract.source,
            "dimension": contract.dimension,
            "alignment": contract.template,
            "antialias": self.antialias,
            "providers": ", ".join(self.embedder.providers),
        }
