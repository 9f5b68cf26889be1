"""How does a run of SRCNN go from pairs to weights that can be shipped?

``train`` is what ``lrsr train sr=srcnn4x`` calls. A run folder holds ``last.ckpt`` (to go on from),
``best.ckpt``, ``model.onnx``, ``model.safetensors``, ``metrics.json`` and ``metrics.csv``.
"""

import logging
import signal
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

from lightning.pytorch import Callback, LightningDataModule, Trainer, seed_everything
from lightning.pytorch.callbacks import ModelCheckpoint
from lightning.pytorch.loggers import CSVLogger, Logger

from lrsr.errors import InputError
from lrsr.files import write_json
from lrsr.provenance import versions
from lrsr.sr.checkpoints import WholeFileIO, keep_best, keep_last, read_checkpoint
from lrsr.sr.export import export_onnx
from lrsr.sr.module import SRCNNModule
from lrsr.sr.precision import choose_precision
from lrsr.sr.progress import GainProgress
from lrsr.sr.weights import read_weights, write_weights

#: The paper's, by scale.
EPOCHS = {2: 160, 4: 40}

_NOISE = (
    ".*does not have many workers.*",
    ".*smaller than the logging interval.*",
    ".*LeafSpec.*",  # Lightning against a newer torch
    ".*exists and is not empty.*",  # the run folder already holds the configuration
)

log = logging.getLogger(__name__)


def train(
    data: LightningDataModule,
    module: SRCNNModule,
    *,
    folder: Path,
    trainer: Callable[..., Trainer] | None = None,
    callbacks: Sequence[Callback] | None = None,
    loggers: Sequence[Callable[..., Logger]] | None = None,
    seed: int = 0,
    resume: bool = True,
    about: Mapping[str, Any] | None = None,
) -> Path:
    """Train until the last epoch, keep the best one, and write what can be shipped.

    Args:
        data: Gives the pairs that :class:`SRCNNModule` describes.
        module: The network and its rates.
        folder: The run folder; made if missing.
        trainer: Makes the Trainer from ``callbacks``, ``logger``, ``default_root_dir`` and
            ``precision``; by default one of the paper's number of epochs.
        callbacks: By default the best epoch's keeper and the progress bar. A ModelCheckpoint
            without a folder writes into the run folder.
        loggers: Each makes a logger from ``save_dir``; by default ``metrics.csv``.
        seed: Of the order of the patches.
        resume: Go on from the ``last.ckpt`` in ``folder`` where there is one.
        about: Further plain values for ``metrics.json``, such as the number of identities.

    Returns:
        The run folder.

    Raises:
        InputError: ``last.ckpt`` is of another configuration or broken, or there was nothing to
            validate on.
        NonFiniteError: The loss became NaN or infinite.
        KeyboardInterrupt: The user stopped the run; the same call goes on with the last epoch.
    """
    logging.getLogger("lightning.pytorch").setLevel(logging.WARNING)  # it advertises
    seed_everything(seed, workers=True, verbose=False)
    runner = _build_trainer(folder, trainer, module.recipe.scale, callbacks, loggers)
    last = folder / "last.ckpt"
    resumed = resume and last.is_file()
    if resumed:
        _check_same_run(last, module)
        log.info("going on from %s", last)
    _fit(runner, module, data, last if resumed else None)
    network, recipe = read_weights(folder / "best.ckpt")
    write_weights(folder / "model.safetensors", network, recipe)
    export_onnx(folder / "model.onnx", network, recipe)
    write_json(folder / "metrics.json", _metrics(module, runner) | {"seed": seed, **(about or {})})
    return folder


def _build_trainer(
    folder: Path,
    make: Callable[..., Trainer] | None,
    scale: int,
    callbacks: Sequence[Callback] | None,
    loggers: Sequence[Callable[..., Logger]] | None,
) -> Trainer:
    """Make the Trainer that writes into ``folder``, in the fastest precision without loss."""
    make = make or partial(Trainer, max_epochs=EPOCHS[scale])
    given: Mapping[str, Any] = make.keywords if isinstance(make, partial) else {}
    settings: dict[str, Any] = {}
    if "precision" not in given:
        settings["precision"], why = choose_precision(given.get("accelerator", "auto"))
        log.info("training in %s", why)
    callbacks = [keep_best(), keep_last(), GainProgress()] if callbacks is None else callbacks
    for callback in callbacks:
        if isinstance(callback, ModelCheckpoint) and callback.dirpath is None:
            callback.dirpath = str(folder)
    loggers = [partial(CSVLogger, name="csv")] if loggers is None else loggers
    return make(
        callbacks=list(callbacks),
        logger=[logger(save_dir=str(folder)) for logger in loggers],
        default_root_dir=str(folder),
        plugins=[WholeFileIO()],
        enable_progress_bar=False,
        enable_model_summary=False,
        num_sanity_val_steps=0,
        **settings,
    )


def _check_same_run(last: Path, module: SRCNNModule) -> None:
    """Refuse to go on from a checkpoint of another configuration.

    Raises:
        InputError: A setting of the module differs, or the checkpoint is broken.
    """
    before, now = read_checkpoint(last).get("hyper_parameters", {}), dict(module.hparams)
    for name in sorted(before.keys() | now.keys()):
        if before.get(name) != now.get(name):
            raise InputError(
                f"{last} was trained with {name}={before.get(name)}, this run has"
                f" {name}={now.get(name)}: choose another folder or the same setting"
            )


def _fit(
    trainer: Trainer, module: SRCNNModule, data: LightningDataModule, last: Path | None
) -> None:
    """Fit; where Lightning turns the user's interrupt into exit status 1, hand it on as it was.

    Raises:
        KeyboardInterrupt: The user stopped the run.
    """
    handler = signal.getsignal(signal.SIGINT)
    with warnings.catch_warnings():
        for noise in _NOISE:
            warnings.filterwarnings("ignore", message=noise)
        try:
            trainer.fit(module, datamodule=data, ckpt_path=last)
        except SystemExit as stop:
            signal.signal(signal.SIGINT, handler)
            raise KeyboardInterrupt from stop


def _metrics(module: SRCNNModule, trainer: Trainer) -> dict[str, Any]:
    """Return the best epoch's figures, the whole history, and what made them."""
    best = max(module.history, key=lambda epoch: epoch["val/psnr_y_db"])
    return {
        "recipe": asdict(module.recipe),
        "best": best,
        "epochs": len(module.history),
        "steps": trainer.global_step,
        "steps_per_epoch": trainer.num_training_batches,
        "validation_images": sum(trainer.num_val_batches),
        "precision": str(trainer.precision),
        "hyper_parameters": dict(module.hparams),
        "history": module.history,
        "versions": versions(),
    }
