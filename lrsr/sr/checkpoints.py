"""What does a training run leave behind so that it can be stopped at any moment and go on?

``last.ckpt`` after every epoch, ``best.ckpt`` after the best one; numbers and strings only, so both
load with ``weights_only=True``, and both are replaced whole or not at all.
"""

from pathlib import Path
from typing import Any

import torch
from lightning.pytorch.callbacks import ModelCheckpoint
from lightning.pytorch.plugins.io import TorchCheckpointIO

from lrsr.errors import InputError
from lrsr.files import replacing


def keep_best(monitor: str = "val/psnr_y_db") -> ModelCheckpoint:
    """Return the callback that keeps the epoch of the highest ``monitor`` as ``best.ckpt``."""
    return ModelCheckpoint(
        filename="best",
        monitor=monitor,
        mode="max",
        save_on_train_epoch_end=True,
        enable_version_counter=False,
    )


def keep_last() -> ModelCheckpoint:
    """Return the callback that writes ``last.ckpt`` after each epoch, better or not."""
    return ModelCheckpoint(
        filename="last",
        monitor=None,
        save_on_train_epoch_end=True,
        enable_version_counter=False,
    )


def read_checkpoint(path: Path) -> dict[str, Any]:
    """Read a checkpoint onto the CPU.

    Raises:
        InputError: The file is missing, cut short, or holds more than numbers and strings.
    """
    try:
        checkpoint = torch.load(path, map_location="cpu", weights_only=True)
    except Exception as error:  # broken bytes make the unpickler raise nearly anything
        reason = " ".join(str(error).split())[:200]
        raise InputError(f"{path} is no checkpoint of lrsr train: {reason}") from error
    if not isinstance(checkpoint, dict) or "state_dict" not in checkpoint:
        raise InputError(f"{path} is no checkpoint of lrsr train: it holds no state_dict")
    return checkpoint


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
        with replacing(Path(path)) as temporary:
            torch.save(checkpoint, temporary)

    def load_checkpoint(
        self, path: str | Path, map_location: Any = None, weights_only: bool | None = True
    ) -> dict[str, Any]:
        """Read a checkpoint onto the CPU; Lightning moves it where it belongs.

        Raises:
            InputError: The file is missing, broken, or holds more than numbers and strings.
        """
        return read_checkpoint(Path(path))
