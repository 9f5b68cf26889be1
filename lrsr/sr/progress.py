"""What does one see while SRCNN trains? One bar on stderr, and one line an epoch with the gain."""

import sys
from typing import Any

from lightning.pytorch import Callback, LightningModule, Trainer
from tqdm import tqdm


class GainProgress(Callback):
    """Shows the steps of the whole run, and each epoch's gain over bicubic, on stderr."""

    def __init__(self) -> None:
        self._bar: tqdm[Any] | None = None
        self._best_db = float("-inf")

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

    def on_validation_end(self, trainer: Trainer, pl_module: LightningModule) -> None:
        """Say what the epoch brought."""
        figures = {name: float(value) for name, value in trainer.callback_metrics.items()}
        gain_db = figures["val/gain_over_bicubic_db"]
        mark = " (best so far)" if gain_db > self._best_db else ""
        self._best_db = max(self._best_db, gain_db)
        tqdm.write(
            f"epoch {trainer.current_epoch + 1}/{trainer.max_epochs}:"
            f" PSNR-Y {figures['val/psnr_y_db']:.2f} dB, {gain_db:+.2f} dB over bicubic{mark}",
            file=sys.stderr,
        )

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

    def state_dict(self) -> dict[str, Any]:
        """Keep the best gain, so that a resumed run marks the right epochs."""
        return {"best_db": self._best_db}

    def load_state_dict(self, state_dict: dict[str, Any]) -> None:
        """Take it up again."""
        self._best_db = state_dict["best_db"]
