"""What does a run leave behind so that it can be stopped at any moment and go on?

``best.ckpt`` after the best epoch and ``last.ckpt`` after every one; numbers and strings only, so
both load with ``weights_only=True``, and both are replaced whole or not at all.
"""

import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

import torch
from lightning.pytorch import LightningModule, Trainer, seed_everything
from lightning.pytorch.callbacks import Checkpoint
from lightning.pytorch.plugins.io import TorchCheckpointIO

from lrsr.files import write_bytes, write_json
from lrsr.pictures.recipe import derived_seed
from lrsr.sr.weights import read_checkpoint
from lrsr.training.learner import Learner


class WholeFileIO(TorchCheckpointIO):
    """Writes checkpoints beside and renames them, where Lightning's own copies from /tmp.

    Reads numbers and strings only, whichever release of Lightning asks.
    """

    def save_checkpoint(
        self, checkpoint: dict[str, Any], path: str | Path, storage_options: Any | None = None
    ) -> None:
        """Write the checkpoint whole or leave the old one.

        Raises:
            InputError: The folder cannot be written or the disk is full.
        """
        content = io.BytesIO()  # torch.save turns a full disk into an error of its own
        torch.save(checkpoint, content)
        write_bytes(Path(path), content.getvalue())

    def load_checkpoint(
        self, path: str | Path, map_location: Any = None, weights_only: bool | None = True
    ) -> dict[str, Any]:
        """Read a checkpoint onto the CPU; Lightning moves it where it belongs.

        Raises:
            InputError: The file is missing, broken, or holds more than numbers and strings.
        """
        return read_checkpoint(Path(path))


class Keeper(Checkpoint):
    """Keeps the best and the last epoch and, in metrics.json, how far the run is.

    Knows no path but the run folder's, which may have moved since the last epoch.

    Args:
        folder: Of the run.
        depends_on: What the weights depend on, in plain values; it goes into every checkpoint.
        seed: Whatever an epoch draws from the global generators follows from this and its number.
    """

    def __init__(self, folder: Path, depends_on: Mapping[str, Any], seed: int) -> None:
        self.folder, self.depends_on, self.seed = folder, dict(depends_on), seed

    def on_train_batch_start(
        self, trainer: Trainer, pl_module: LightningModule, batch: Any, batch_idx: int
    ) -> None:
        """Begin an epoch alike in every run; going on, there is no on_train_epoch_start."""
        if batch_idx == 0:
            of_epoch = derived_seed(self.seed, "training", trainer.current_epoch)
            seed_everything(of_epoch, workers=True, verbose=False)

    def on_save_checkpoint(
        self, trainer: Trainer, pl_module: LightningModule, checkpoint: dict[str, Any]
    ) -> None:
        """Add what the weights depend on."""
        checkpoint["depends_on"] = self.depends_on

    def on_train_epoch_end(self, trainer: Trainer, pl_module: LightningModule) -> None:
        """Remember the figures, then write the epoch; Lightning has let everybody else go first.

        Raises:
            InputError: The folder cannot be written or the disk is full.
        """
        learner = cast("Learner", pl_module)
        figures = {name: float(value) for name, value in trainer.callback_metrics.items()}
        names = ["best", "last"] if learner.is_best(figures) else ["last"]
        epoch = {"epoch": trainer.current_epoch, "step": trainer.global_step}
        learner.history.append(epoch | figures)
        for name in names:
            trainer.save_checkpoint(self.folder / f"{name}.ckpt")
        self.tell(learner.history)

    def tell(self, history: list[dict[str, float]]) -> None:
        """Write how far the run is.

        Raises:
            InputError: The folder cannot be written or the disk is full.
        """
        told = {"finished": False, "history": history, "settings": self.depends_on}
        write_json(self.folder / "metrics.json", told)
