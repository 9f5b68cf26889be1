"""What does one see while a network trains? One bar on stderr, and one line an epoch."""

import sys
from typing import Any, cast

from lightning.pytorch import Callback, LightningModule, Trainer
from tqdm import tqdm

from lrsr.training.learner import Learner


class Progress(Callback):
    """Shows the steps of the whole run with the time left, and each epoch's figures, on stderr."""

    def __init__(self) -> None:
        self._bar: tqdm[Any] | None = None

    def on_train_start(self, trainer: Trainer, pl_module: LightningModule) -> None:
        """Open the bar where a resumed run stands."""
        self._bar = tqdm(
            total=int(trainer.estimated_stepping_batches),
            initial=trainer.global_step,
            unit="step",
            file=sys.stderr,
            mininterval=0.2 if sys.stderr.isatty() else 10.0,
            dynamic_ncols=True,
        )

    def on_train_batch_end(self, trainer: Trainer, *_: Any) -> None:
        """Move the bar."""
        if self._bar is not None:
            self._bar.update(1)

    def on_train_epoch_end(self, trainer: Trainer, pl_module: LightningModule) -> None:
        """Say what the epoch brought."""
        learner = cast("Learner", pl_module)
        figures = {name: float(value) for name, value in trainer.callback_metrics.items()}
        mark = " (best so far)" if learner.is_best(figures) else ""
        done = f"epoch {trainer.current_epoch + 1}/{trainer.max_epochs}"
        tqdm.write(f"{done}: {learner.in_words(figures)}{mark}", file=sys.stderr)

    def teardown(self, trainer: Trainer, pl_module: LightningModule, stage: str) -> None:
        """Close the bar."""
        self._close()

    def on_exception(
        self, trainer: Trainer, pl_module: LightningModule, exception: BaseException
    ) -> None:
        """Close the bar before the error is told."""
        self._close()

    def _close(self) -> None:
        if self._bar is not None:
            self._bar.close()
            self._bar = None
