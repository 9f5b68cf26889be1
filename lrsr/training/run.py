"""How is a network trained? One run, the same for all: go on or begin, fit, ship the best epoch.

``train`` is what ``lrsr train`` calls. A run folder holds ``last.ckpt`` (to go on from),
``best.ckpt``, ``metrics.json``, the logger's files and what the network ships.
"""

import errno
import logging
import signal
import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from lightning.fabric.utilities.exceptions import MisconfigurationException
from lightning.pytorch import Callback, LightningDataModule, Trainer
from lightning.pytorch.loggers import Logger

from lrsr.configuration import as_whole, require
from lrsr.errors import InputError
from lrsr.files import write_json
from lrsr.provenance import versions
from lrsr.training.checkpoints import Keeper, WholeFileIO
from lrsr.training.learner import Learner
from lrsr.training.precision import choose_precision
from lrsr.training.resume import forget, refuse_other_run

_NOISE = (
    ".*does not have many workers.*",
    ".*smaller than the logging interval.*",
    ".*LeafSpec.*",  # Lightning against a newer torch
    ".*exists and is not empty.*",  # the run folder already holds the configuration
)
_FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EACCES}

logger = logging.getLogger(__name__)


def train(
    module: Learner,
    data: LightningDataModule,
    *,
    folder: Path,
    trainer: Callable[..., Trainer],
    callbacks: Sequence[Callback] = (),
    loggers: Sequence[Callable[..., Logger]] = (),
    seed: int = 0,
    resume: bool = True,
    depends_on: Mapping[str, Any],
    record: Callable[[Path], object] = lambda folder: None,
) -> Path:
    """Train until the last epoch, keep the best one, and write what can be shipped.

    Stopped at any moment, the same call goes on after the last whole epoch and ends with the same
    weights, bit for bit, as if it had never been stopped.

    Args:
        module: The network and how it learns.
        data: What it learns from; the order of an epoch follows from its number alone.
        folder: The run folder; made if missing.
        trainer: Makes the Trainer; ``precision`` may be "auto".
        callbacks: More than the keeper of checkpoints, which is always there.
        loggers: Each makes a logger from ``save_dir``.
        seed: Of whatever draws from the global generators, any whole number.
        resume: Go on from the ``last.ckpt`` in ``folder`` where there is one; else begin again.
        depends_on: All that the weights depend on, in plain values; see
            :mod:`lrsr.training.resume`.
        record: Writes into the folder what the run is, once nothing of it is refused any more.

    Returns:
        The run folder.

    Raises:
        InputError: The folder holds a run that depends on something else, cannot be written, or the
            disk is full; or there was nothing to validate on.
        NonFiniteError: The loss became NaN or infinite.
        KeyboardInterrupt: The user stopped the run.
    """
    logging.getLogger("lightning.pytorch").setLevel(logging.WARNING)  # it advertises
    keeper = Keeper(folder, depends_on, seed)
    if resume:
        refuse_other_run(folder, depends_on, follows_length=module.follows_length)
    runner = _build_trainer(folder, trainer, [*callbacks, keeper], loggers)
    endless = module.follows_length and runner.max_epochs == runner.max_steps == -1
    wish = "a number above 0, as the schedule is as long as the run"
    require(not endless, "trainer.max_epochs", -1, wish)
    if not resume:
        forget(folder)
    record(folder)
    last = folder / "last.ckpt" if (folder / "last.ckpt").is_file() else None
    if last is None:
        keeper.tell([])
    else:
        logger.info("going on from %s", last)
    _fit(runner, module, data, last)
    told = _metrics(module, runner) | {"seed": seed, "settings": dict(depends_on)}
    told |= module.ship(folder, folder / "best.ckpt")
    write_json(folder / "metrics.json", told)
    return folder


def _build_trainer(
    folder: Path,
    make: Callable[..., Trainer],
    callbacks: Sequence[Callback],
    loggers: Sequence[Callable[..., Logger]],
) -> Trainer:
    """Make the Trainer that writes into ``folder``.

    Raises:
        InputError: A setting is none, or Lightning refuses it.
    """
    given: Mapping[str, Any] = getattr(make, "keywords", {})
    for name in {"max_epochs", "log_every_n_steps"} & given.keys():
        as_whole(given[name], f"trainer.{name}")  # Lightning takes anything
    for name in ("max_epochs", "max_steps", "limit_train_batches"):
        require(given.get(name) != 0, f"trainer.{name}", 0, "more than 0: nothing would be learned")
    precision = given.get("precision", "auto")
    if precision == "auto":
        precision, why = choose_precision(given.get("accelerator", "auto"))
        logger.info("training in %s", why)
    try:
        return make(
            precision=precision,
            callbacks=list(callbacks),
            logger=[logger(save_dir=str(folder)) for logger in loggers],
            default_root_dir=str(folder),
            plugins=[WholeFileIO()],
            enable_progress_bar=False,
            enable_model_summary=False,
            num_sanity_val_steps=0,
        )
    except (MisconfigurationException, ImportError, TypeError, ValueError) as error:
        raise InputError(f"trainer: {' '.join(str(error).split())}") from error


def _fit(runner: Trainer, module: Learner, data: LightningDataModule, last: Path | None) -> None:
    """Fit; where Lightning turns the user's interrupt into exit status 1, hand it on as it was.

    Raises:
        InputError: The disk is full, whoever wrote.
        OSError: Something else could not be read or written.
        KeyboardInterrupt: The user stopped the run.
    """
    handler = signal.getsignal(signal.SIGINT)
    with warnings.catch_warnings():
        for noise in _NOISE:
            warnings.filterwarnings("ignore", message=noise)
        try:
            runner.fit(module, datamodule=data, ckpt_path=last)
        except SystemExit as stop:
            signal.signal(signal.SIGINT, handler)
            raise KeyboardInterrupt from stop
        except OSError as error:  # of a logger; it may have come while the run was stopping
            if isinstance(error.__context__, InputError):
                raise error.__context__ from error
            if error.errno not in _FULL:
                raise
            raise InputError(
                f"cannot write {error.filename or runner.default_root_dir}: {error.strerror};"
                " free space or choose another folder"
            ) from error


def _metrics(module: Learner, runner: Trainer) -> dict[str, Any]:
    """Return the best epoch's figures, the whole history, and what made them."""
    choose = max if module.mode == "max" else min
    return {
        "finished": True,
        "best": choose(module.history, key=lambda epoch: epoch[module.monitor]),
        "epochs": len(module.history),
        "steps": runner.global_step,
        "steps_per_epoch": runner.num_training_batches,
        "validation_batches": sum(runner.num_val_batches),
        "precision": str(runner.precision),
        "history": module.history,
        "versions": versions(),
    }
