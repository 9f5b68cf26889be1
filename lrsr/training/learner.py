"""What must a network say so that the one run can train it? A loss, a figure, what it leaves."""

import inspect
import math
from abc import abstractmethod
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any, ClassVar, Literal

import torch
from lightning.pytorch import LightningModule
from lightning.pytorch.utilities.types import OptimizerLRScheduler

from lrsr.configuration import as_number, require
from lrsr.errors import DivergenceError, InputError, NonFiniteError

MakeOptimizer = partial[torch.optim.Optimizer]
MakeScheduler = partial[torch.optim.lr_scheduler.LRScheduler]


class Learner(LightningModule):
    """A network and how it learns; a subclass gives a loss and what is shipped.

    A checkpoint holds the weights, the history and plain values, no object. Whatever is random in a
    step follows from the seed and the number of the step, so that a resumed run takes the same.

    Args:
        optimizer: Makes the optimiser from :meth:`parameter_groups`.
        scheduler: Makes the schedule of its rates from the optimiser, a step a batch; the length of
            the run is filled in where it takes ``T_max`` or ``total_steps``. None: constant rates.

    Attributes:
        monitor: The logged figure that tells the best epoch.
        mode: Is more better ("max") or less ("min")?
        lessons: The options of ``conf/data`` that it learns from.
        history: Every epoch's figures.

    Raises:
        InputError: Optimiser or schedule cannot be made with these settings.
    """

    monitor: ClassVar[str]
    mode: ClassVar[Literal["max", "min"]] = "max"
    lessons: ClassVar[tuple[str, ...]]

    def __init__(self, optimizer: MakeOptimizer, scheduler: MakeScheduler | None) -> None:
        super().__init__()
        self.make_optimizer, self.make_scheduler = optimizer, scheduler
        tried = try_optimizer(optimizer, "module.optimizer")  # before anything is rendered
        try:
            if scheduler is not None:
                scheduler(tried, **dict.fromkeys(self._lengths(), 2))
        except (TypeError, ValueError) as error:
            raise InputError(f"module.scheduler: {error}") from error
        self.history: list[dict[str, float]] = []

    @abstractmethod
    def loss(self, batch: Any) -> torch.Tensor:
        """Return the loss of a batch, a scalar."""

    @abstractmethod
    def in_words(self, figures: Mapping[str, float]) -> str:
        """Tell an epoch's figures to somebody who waits."""

    @abstractmethod
    def ship(self, folder: Path, best: Path) -> dict[str, Any]:
        """Write what leaves the house from the checkpoint ``best``; return more for metrics.json.

        The trainer and its data are still attached.
        """

    def about(self) -> dict[str, Any]:
        """Return what the weights depend on besides the settings, by its dotted name."""
        return {}

    def parameter_groups(self) -> list[dict[str, Any]]:
        """Return the parameters in groups with settings of their own; here one group."""
        return [{"params": list(self.parameters())}]

    def is_best(self, figures: Mapping[str, float]) -> bool:
        """Tell whether these figures are better than those of every epoch in the history."""
        sign = 1 if self.mode == "max" else -1
        before = [sign * epoch[self.monitor] for epoch in self.history]
        return sign * figures[self.monitor] > max(before, default=-math.inf)

    def on_train_start(self) -> None:
        """Refuse a run that could not tell its best epoch.

        Raises:
            InputError: There is nothing to validate on.
        """
        if not sum(self.trainer.num_val_batches):
            raise InputError("no image to validate on: give at least one validation identity")

    def training_step(self, batch: Any, batch_idx: int) -> torch.Tensor:
        """Return the loss of one batch.

        Raises:
            DivergenceError: The loss is NaN or infinite; the message says at which epoch and step.
            NonFiniteError: So is what was shown.
        """
        loss = self.loss(batch)
        if not math.isfinite(loss.item()):
            told = f"loss is {loss.item()} at epoch {self.current_epoch}, step {self.global_step}"
            if culprit := _culprit(batch):
                raise NonFiniteError(f"{told}: {culprit}")
            raise DivergenceError(
                f"{told}: the patches are finite, so the weights diverged; lower the learning rate"
            )
        self.log("train/loss", loss, on_step=False, on_epoch=True, batch_size=len(batch[0]))
        return loss

    def configure_optimizers(self) -> OptimizerLRScheduler:
        """Make the optimiser and its schedule, as long as the run."""
        optimizer = self.make_optimizer(self.parameter_groups())
        if self.make_scheduler is None:
            return optimizer
        length = int(self.trainer.estimated_stepping_batches) if self.follows_length else 0
        scheduler = self.make_scheduler(optimizer, **dict.fromkeys(self._lengths(), length))
        return {
            "optimizer": optimizer,
            "lr_scheduler": {"scheduler": scheduler, "interval": "step"},
        }

    @property
    def follows_length(self) -> bool:
        """Do the rates, from the first step on, depend on how long the run is to be?"""
        return bool(self._lengths())

    def _lengths(self) -> list[str]:
        """Return the scheduler's arguments that the length of the run is filled in for."""
        if self.make_scheduler is None:
            return []
        asked, unset = inspect.signature(self.make_scheduler).parameters, inspect.Parameter.empty
        names = [name for name in ("T_max", "total_steps") if name in asked]
        return [name for name in names if asked[name].default in (None, unset)]

    def on_save_checkpoint(self, checkpoint: dict[str, Any]) -> None:
        """Add the history."""
        checkpoint["history"] = self.history

    def on_load_checkpoint(self, checkpoint: dict[str, Any]) -> None:
        """Take up the history where it stopped."""
        self.history = list(checkpoint["history"])


def try_optimizer(make: MakeOptimizer, name: str) -> torch.optim.Optimizer:
    """Return the optimiser of one parameter.

    Raises:
        InputError: It cannot be made with these settings, which ``name`` is what messages call.
    """
    require(isinstance(make, partial), name, make, f"{name}._target_=torch.optim.Adam and the like")
    if "lr" in make.keywords:
        as_number(make.keywords["lr"], f"{name}.lr")
    try:
        return make([torch.nn.Parameter(torch.zeros(1))])
    except (TypeError, ValueError) as error:
        raise InputError(f"{name}: {error}") from error


def _culprit(batch: Any) -> str:
    for name, images in zip(("input", "target"), batch, strict=False):
        bad = (~torch.isfinite(images)).reshape(len(images), -1).any(1).nonzero().flatten().tolist()
        if bad:
            return f"the {name} of patch {bad[0]} of the batch is not finite"
    return ""
