"""Does the restored face still show the same person? As a recogniser sees it, with a gradient."""

from typing import cast

import torch
from torch.nn import functional as F

from lrsr.configuration import as_word
from lrsr.errors import InputError
from lrsr.paths import asset
from lrsr.recognition.alignment import Template, align
from lrsr.recognition.contract import read_contract
from lrsr.recognition.registry import model_file
from lrsr.training.losses.onnx_network import OnnxNetwork
from lrsr.training.losses.term import Term


class IdentityLoss(Term):
    """1 - the cosine of a frozen embedder's vectors of restored and true face.

    Both are aligned with the true landmarks, so that only what is shown counts. A network that
    learns from an embedder flatters it: judge the result with another one.

    Args:
        weight: In the sum.
        embedder: "shipped", a name of ``lrsr models list``, or an ONNX file with its contract.

    Raises:
        InputError: There is no such embedder, or no gradient passes through it.
    """

    def __init__(self, *, weight: float, embedder: str = "shipped") -> None:
        super().__init__("identity", weight)
        name = as_word(embedder, "module.losses.identity.embedder")
        shipped = name == "shipped"
        path = asset("weights/arcface_small.onnx") if shipped else model_file(name, "recogniser")
        self.contract = read_contract(path)
        if self.contract.template == "deepface":
            raise InputError(
                f"module.losses.identity.embedder={name}: no gradient passes through its alignment"
                " as DeepFace's; wanted one that is aligned by five points or the eyes"
            )
        self._network = OnnxNetwork(path)

    def forward(
        self,
        restored: torch.Tensor,
        targets: torch.Tensor,
        landmarks_px: torch.Tensor | None = None,
    ) -> torch.Tensor:
        """Return the mean over the faces, 0 to 2; see the base.

        Raises:
            InputError: The patches tell no landmarks.
        """
        if landmarks_px is None:
            raise InputError("module.losses.identity: wanted whole faces; add patches=faces")
        with torch.no_grad():
            true = self._embed(targets, landmarks_px)
        shown = self._embed(restored.clamp(0, 1), landmarks_px)
        return 1 - F.cosine_similarity(shown, true).mean()

    def _embed(self, srgb: torch.Tensor, landmarks_px: torch.Tensor) -> torch.Tensor:
        told = self.contract
        crops, _ = align(
            srgb,
            landmarks_px,
            antialias=told.antialias,
            template=cast("Template", told.template),
            size_px=(told.height_px, told.width_px),
        )
        return self._network(told.prepare(crops), told.name)
