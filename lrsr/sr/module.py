"""How is SRCNN trained: which loss, which steps, and which figure says that it is good?"""

import math
from typing import Any, Literal

import torch
from lightning.pytorch import LightningModule
from lightning.pytorch.utilities.types import OptimizerLRScheduler
from torch.nn import functional as F

from lrsr.errors import InputError, NonFiniteError
from lrsr.sr.psnr import psnr_y_db
from lrsr.sr.srcnn import SRCNN, Initialisation, repeat_edge
from lrsr.sr.weights import Recipe

Pair = tuple[torch.Tensor, torch.Tensor]

#: How the pipeline makes its pairs; written into the weights, for they serve no other input.
RENDERED_PAIRS = "the same scene rendered through a film of 1/scale the pixels, no down-sampling"


class SRCNNModule(LightningModule):
    """SRCNN with mean squared error on the luminance, Adam, and the validation PSNR.

    Batches are pairs: in training (B, 1, 33, 33) enlarged and (B, 1, 21, 21) true luminance, in
    validation (B, 1, H, W) both. The last layer learns ten times slower, as in the SRCNN paper.
    Validation runs in float32 with the edge replicated, as :class:`lrsr.sr.Upscaler` does.

    Args:
        scale: 2 or 4; how much the inputs were enlarged.
        learning_rate: Adam's, of the first two layers.
        last_layer_learning_rate: Adam's, of the last layer.
        decay: "cosine" lets both rates fall to 0 over the run, "none" keeps them.
        initialisation: See :class:`SRCNN`; "near-identity" starts level with bicubic, where the
            paper's start needs a thousand steps to get there.
        lr_made_by: How the small images were made, in words; kept with the weights.
        seed: Of the first weights.
    """

    def __init__(
        self,
        *,
        scale: int,
        learning_rate: float = 1e-3,
        last_layer_learning_rate: float = 1e-4,
        decay: Literal["cosine", "none"] = "cosine",
        initialisation: Initialisation = "near-identity",
        lr_made_by: str = RENDERED_PAIRS,
        seed: int = 0,
    ) -> None:
        super().__init__()
        self.save_hyperparameters()
        self.recipe = Recipe(scale=scale, lr_made_by=lr_made_by)
        self.learning_rates = (learning_rate, last_layer_learning_rate)
        self.decay = decay
        self.history: list[dict[str, float]] = []
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(seed)
            network = SRCNN(initialisation=initialisation)
        self.network = network.to(memory_format=torch.channels_last)

    def on_train_start(self) -> None:
        """Refuse a run that could not tell its best epoch.

        Raises:
            InputError: There is nothing to validate on.
        """
        if not sum(self.trainer.num_val_batches):
            raise InputError("no image to validate on: give at least one validation identity")

    def training_step(self, batch: Pair, batch_idx: int) -> torch.Tensor:
        """Return the mean squared error of one batch.

        Raises:
            NonFiniteError: The loss is NaN or infinite; the message says at which epoch and step.
        """
        enlarged, target = batch
        restored = self.network(enlarged.contiguous(memory_format=torch.channels_last))
        loss = F.mse_loss(restored.float(), target)
        if not math.isfinite(loss.item()):
            raise NonFiniteError(
                f"loss is {loss.item()} at epoch {self.current_epoch}, step {self.global_step}:"
                f" {self._culprit(batch)}"
            )
        self.log("train/mse_y", loss, on_step=False, on_epoch=True, batch_size=len(target))
        return loss

    def _culprit(self, batch: Pair) -> str:
        for name, images in zip(("input", "target"), batch, strict=True):
            bad = (~torch.isfinite(images)).flatten(1).any(1).nonzero().flatten().tolist()
            if bad:
                return f"the {name} of patch {bad[0]} of the batch is not finite"
        return "the patches are finite, so the weights diverged; lower the learning rate"

    def validation_step(self, batch: Pair, batch_idx: int) -> None:
        """Log PSNR and the gain over the bicubic input, both on luminance, means over images.

        Raises:
            NonFiniteError: A restored image holds a NaN.
        """
        enlarged, target = batch
        with torch.autocast(self.device.type, enabled=False):
            restored = self.network(repeat_edge(enlarged))
        shave_px = self.recipe.scale
        psnr_db = psnr_y_db(restored, target, shave_px=shave_px)
        bicubic_db = psnr_y_db(enlarged, target, shave_px=shave_px)
        if bool(psnr_db.isnan().any()):
            raise NonFiniteError(f"a restored image is NaN at epoch {self.current_epoch}")
        figures = {"psnr_y_db": psnr_db, "bicubic_psnr_y_db": bicubic_db}
        figures["gain_over_bicubic_db"] = psnr_db - bicubic_db
        for name, value in figures.items():
            self.log(f"val/{name}", value.mean().float(), batch_size=len(target))

    def on_validation_epoch_end(self) -> None:
        """Remember the epoch's figures; they travel in the checkpoint."""
        figures = {
            name: float(value)
            for name, value in self.trainer.callback_metrics.items()
            if name.startswith("val/")
        }
        self.history.append({"epoch": self.current_epoch, "step": self.global_step} | figures)

    def configure_optimizers(self) -> OptimizerLRScheduler:
        """Return Adam with the two rates, and their decay step by step."""
        network, (rate, last_rate) = self.network, self.learning_rates
        first = [*network.extract.parameters(), *network.map.parameters()]
        last = [*network.reconstruct.parameters()]
        optimizer = torch.optim.Adam(
            [{"params": first, "lr": rate}, {"params": last, "lr": last_rate}]
        )
        if self.decay == "none":
            return optimizer
        steps = self.trainer.estimated_stepping_batches
        schedule = torch.optim.lr_scheduler.LambdaLR(
            optimizer, lambda step: 0.5 * (1.0 + math.cos(math.pi * min(step / steps, 1.0)))
        )
        return {
            "optimizer": optimizer,
            "lr_scheduler": {"scheduler": schedule, "interval": "step"},
        }

    def on_save_checkpoint(self, checkpoint: dict[str, Any]) -> None:
        """Add the recipe and the history, plain values both."""
        checkpoint["recipe"] = self.recipe.as_text()
        checkpoint["history"] = self.history

    def on_load_checkpoint(self, checkpoint: dict[str, Any]) -> None:
        """Take up the history where it stopped."""
        self.history = checkpoint["history"]
