"""How is an embedder trained? The module that Lightning drives."""

from collections.abc import Mapping
from typing import Any

import lightning
import numpy as np
import torch
import torch.nn.functional as F
from numpy.typing import NDArray
from sklearn.metrics import roc_auc_score

from lrsr.errors import NonFiniteError
from lrsr.recognition.backbone import DIMENSION, Backbone
from lrsr.recognition.degradation import Degradation
from lrsr.recognition.margin import AngularMargin

MEAN = SCALE = 127.5
"""The network sees (255 srgb - MEAN) / SCALE."""

Batch = tuple[torch.Tensor, torch.Tensor, torch.Tensor]


class ArcFaceModule(lightning.LightningModule):
    """Backbone, angular margin, degradation and the validation by verification.

    Args:
        people: How many to learn.
        steps: Optimiser steps of the whole training.
        learning_rate: Peak of the one-cycle schedule of AdamW.
        weight_decay: Of the convolutions and directions; norms and biases have none.
        scale: s of the angular margin.
        margin: m of the angular margin, radians.
        seed: Of the weights and of every degradation.
        antialias: How the crops were aligned; kept with the weights for the contract.
    """

    def __init__(
        self,
        people: int,
        steps: int,
        *,
        learning_rate: float = 3e-3,
        weight_decay: float = 0.05,
        scale: float = 32.0,
        margin: float = 0.4,
        seed: int = 0,
        antialias: bool = True,
    ) -> None:
        super().__init__()
        self.save_hyperparameters()
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(seed)
            self.backbone = Backbone().to(memory_format=torch.channels_last)
            self.head = AngularMargin(DIMENSION, people, scale=scale, margin=margin)
        self.degradation = Degradation()
        self.history: list[dict[str, float]] = []
        self._embedded: dict[str, NDArray[np.float32]] = {}

    def forward(self, srgb: torch.Tensor) -> torch.Tensor:
        """Embed srgb ``(B, 3, 112, 112)``, [0, 1], as ``(B, 128)``."""
        faces = (srgb * 255 - MEAN) / SCALE
        embeddings: torch.Tensor = self.backbone(
            faces.contiguous(memory_format=torch.channels_last)
        )
        return embeddings

    def training_step(self, batch: Batch, batch_idx: int) -> torch.Tensor:
        """Degrade, embed, and return the cross-entropy of the angular margin.

        Raises:
            NonFiniteError: The loss is no number; lower the learning rate.
        """
        crops, people, sharp = batch
        rng = np.random.default_rng((self.hparams["seed"], self.global_step))
        logits = self.head(self(self.degradation(crops, sharp, rng)), people)
        loss = F.cross_entropy(logits, people)
        if not bool(torch.isfinite(loss)):
            value = float(loss.detach())
            raise NonFiniteError(f"training loss is {value} at step {self.global_step}")
        accuracy = (logits.detach().argmax(1) == people).float().mean()
        self.log("train/loss", loss, on_step=False, on_epoch=True, prog_bar=True)
        self.log("train/accuracy", accuracy, on_step=False, on_epoch=True, prog_bar=True)
        return loss

    def validation_step(self, batch: Mapping[str, Any], batch_idx: int) -> None:
        """Embed one set of validation faces: ``{"name": str, "crops": (n, 3, 112, 112) uint8}``."""
        embeddings = F.normalize(self(batch["crops"].float() / 255).float())
        self._embedded[batch["name"]] = embeddings.numpy(force=True)

    def on_validation_epoch_end(self) -> None:
        """Log val/auc_ipd64 ... and their mean, val/auc."""
        aucs = verification_aucs(self._embedded)
        self._embedded = {}
        for name, auc in aucs.items():
            self.log(f"val/{name}", auc, prog_bar=name == "auc")

    def on_save_checkpoint(self, checkpoint: dict[str, Any]) -> None:
        """Add the history, an entry an epoch."""
        checkpoint["history"] = self.history

    def on_load_checkpoint(self, checkpoint: dict[str, Any]) -> None:
        """Take the history back."""
        self.history = list(checkpoint["history"])

    def configure_optimizers(self) -> Any:
        """Return AdamW with a one-cycle schedule, a step a batch."""
        parameters = list(self.parameters())
        groups = [
            {
                "params": [p for p in parameters if p.ndim > 1],
                "weight_decay": self.hparams["weight_decay"],
            },
            {"params": [p for p in parameters if p.ndim <= 1], "weight_decay": 0.0},
        ]
        optimiser = torch.optim.AdamW(groups, lr=self.hparams["learning_rate"])
        schedule = torch.optim.lr_scheduler.OneCycleLR(
            optimiser,
            max_lr=self.hparams["learning_rate"],
            total_steps=self.hparams["steps"],
            pct_start=0.15,
            cycle_momentum=False,
        )
        return {
            "optimizer": optimiser,
            "lr_scheduler": {"scheduler": schedule, "interval": "step"},
        }


def verification_aucs(embedded: Mapping[str, NDArray[np.float32]]) -> dict[str, float]:
    """Compare each set of probes with the gallery, everybody with everybody.

    Args:
        embedded: "gallery" and sets of probes, each ``(people, D)``, length 1, in the same order.

    Returns:
        "auc_NAME" for each probe set, and "auc", their mean.

    Example:
        >>> verification_aucs({"gallery": np.eye(3), "ipd8": np.eye(3)})
        {'auc_ipd8': 1.0, 'auc': 1.0}
    """
    gallery = embedded["gallery"]
    genuine = np.eye(len(gallery), dtype=bool).ravel()
    aucs = {
        f"auc_{name}": float(roc_auc_score(genuine, (probes @ gallery.T).ravel()))
        for name, probes in embedded.items()
        if name != "gallery"
    }
    return {**aucs, "auc": float(np.mean(list(aucs.values())))}
