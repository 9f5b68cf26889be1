"""How does ``lrsr train recognition=arcface`` make an embedder, from nobody to an ONNX file?"""

import json
import logging
import time
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import lightning
import numpy as np
import torch
from lightning.pytorch.callbacks import ModelCheckpoint
from torch.utils.data import DataLoader, Dataset

from lrsr.data.cache import RenderCache
from lrsr.data.maker import Maker
from lrsr.errors import InputError
from lrsr.files import write_json
from lrsr.recognition.arcface import ArcFaceModule, verification_aucs
from lrsr.recognition.contract import sha256_of
from lrsr.recognition.embedding import Embedder
from lrsr.recognition.export import export_embedder
from lrsr.recognition.faces import (
    Faces,
    FaceSettings,
    load_training_faces,
    load_validation_faces,
    render_faces,
)

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class TrainingSettings:
    """How an embedder learns.

    Attributes:
        epochs: Passes; an epoch shows each person ``views`` times.
        views: Faces of each person in an epoch, half of them sharp where there are sharp and small.
        batch_size: Faces per step.
        learning_rate: Peak of the one-cycle schedule of AdamW.
        weight_decay: Of AdamW.
        scale: s of the angular margin.
        margin: m of the angular margin, radians.
        precision: "auto", "32-true" or "bf16-mixed"; auto is bfloat16 where the machine has it.
        seed: Of the weights, the order and the degradations.

    Raises:
        InputError: A value is out of its range.
    """

    epochs: int = 40
    views: int = 8
    batch_size: int = 128
    learning_rate: float = 3e-3
    weight_decay: float = 0.05
    scale: float = 32.0
    margin: float = 0.4
    precision: str = "auto"
    seed: int = 0

    def __post_init__(self) -> None:
        ranges = {
            "epochs": self.epochs >= 1,
            "views": self.views >= 1,
            "batch_size": self.batch_size >= 2,
            "learning_rate": self.learning_rate > 0,
            "weight_decay": self.weight_decay >= 0,
            "scale": self.scale > 0,
            "margin": 0 <= self.margin < np.pi / 2,
            "precision": self.precision in {"auto", "32-true", "bf16-mixed"},
        }
        for name, holds in ranges.items():
            if not holds:
                raise InputError(f"training.{name}={getattr(self, name)}: out of its range")


def train_embedder(
    folder: Path,
    cache: RenderCache,
    *,
    faces: FaceSettings | None = None,
    training: TrainingSettings | None = None,
    resume: bool = True,
    progress: bool = True,
    maker: Maker | None = None,
) -> Path:
    """Render what is missing, train, export the best epoch, and record how it went.

    Interrupted, the next call with the same folder and settings goes on after the last whole epoch.

    Args:
        folder: Of the run; receives last.ckpt, best.ckpt, model.onnx, model.toml, metrics.json.
        cache: Of renderings.
        faces: Who and how many.
        training: How they are learned.
        resume: Go on from the folder's last.ckpt where there is one; else begin anew.
        progress: Show a bar on stderr while rendering.
        maker: Renders; Mitsuba when None.

    Returns:
        ``folder``.

    Raises:
        InputError: Folder or cache cannot be written, or the folder holds a run of other settings.
        NonFiniteError: The loss is no number.
    """
    faces, training = faces or FaceSettings(), training or TrainingSettings()
    record = {"faces": asdict(faces), "training": asdict(training)}
    _claim(folder, record, resume=resume)
    render_faces(faces, cache, progress=progress, maker=maker)
    crops = load_training_faces(faces, cache, progress=progress, maker=maker)
    validation = load_validation_faces(faces, cache, progress=progress, maker=maker)
    best = _fit(folder, faces, training, crops, validation)
    return _finish(folder, best, validation, record)


def has_bfloat16() -> bool:
    """Tell whether this CPU multiplies bfloat16 matrices in hardware (AVX512-BF16 or AMX)."""
    flags = Path("/proc/cpuinfo")
    if not flags.is_file():
        return False
    words = set(flags.read_text().split())
    return bool(words & {"avx512_bf16", "amx_bf16"})


class _Epoch(Dataset[tuple[torch.Tensor, torch.Tensor, torch.Tensor]]):
    """The batches of one epoch, their order a function of seed and epoch."""

    def __init__(self, faces: Faces, training: TrainingSettings, epoch: int) -> None:
        self.faces = faces
        rng = np.random.default_rng((training.seed, epoch))
        rows = np.concatenate(list(_draw(faces, training.views, rng)))
        rng.shuffle(rows)
        count = max(len(rows) // training.batch_size, 1)
        self.batches = [torch.from_numpy(part) for part in np.array_split(rows, count)]

    def __len__(self) -> int:
        return len(self.batches)

    def __getitem__(self, number: int) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        return self.faces[self.batches[number]]


def _draw(faces: Faces, views: int, rng: np.random.Generator) -> Iterator[np.ndarray]:
    """Yield rows of every person, half of them sharp where there are both kinds."""
    people, sharp = faces.people.numpy(), faces.sharp.numpy()
    for person in range(int(people.max()) + 1):
        kinds = [np.flatnonzero((people == person) & (sharp == kind)) for kind in (True, False)]
        kinds = [rows for rows in kinds if len(rows)]
        for number, rows in enumerate(kinds):
            share = (views + number) // len(kinds)
            yield rng.choice(rows, share, replace=share > len(rows))


class _FacesData(lightning.LightningDataModule):
    def __init__(
        self, faces: Faces, validation: dict[str, torch.Tensor], training: TrainingSettings
    ) -> None:
        super().__init__()
        self.faces, self.validation, self.training = faces, validation, training

    def train_dataloader(self) -> DataLoader[Any]:
        epoch = self.trainer.current_epoch if self.trainer else 0
        return DataLoader(_Epoch(self.faces, self.training, epoch), batch_size=None)

    def val_dataloader(self) -> DataLoader[Any]:
        sets: Any = [{"name": name, "crops": crops} for name, crops in self.validation.items()]
        return DataLoader(sets, batch_size=None)


class _Record(lightning.Callback):
    """Keep the history, which travels with the checkpoint, and metrics.json up to date."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / "metrics.json"
        self.times_s: list[float] = []

    def on_train_start(self, trainer: Any, pl_module: Any) -> None:
        self.times_s = [time.monotonic()]

    def on_train_epoch_end(self, trainer: Any, pl_module: Any) -> None:
        logged = {name: float(value) for name, value in trainer.callback_metrics.items()}
        pl_module.history.append({"epoch": trainer.current_epoch, **logged})
        write_json(self.path, {"finished": False, "history": pl_module.history})
        self._tell(trainer.current_epoch + 1, trainer.max_epochs, logged)

    def _tell(self, done: int, epochs: int, logged: Mapping[str, float]) -> None:
        """Say how it goes and how long it will take, a line an epoch."""
        self.times_s.append(time.monotonic())
        epoch_s = (self.times_s[-1] - self.times_s[0]) / (len(self.times_s) - 1)
        values = [f"{name.split('/')[1]} {value:.3f}" for name, value in sorted(logged.items())]
        left_min = (epochs - done) * epoch_s / 60
        logger.info("epoch %d of %d: %s; %.1f min left", done, epochs, ", ".join(values), left_min)


def _claim(folder: Path, record: dict[str, Any], *, resume: bool) -> None:
    """Make the folder this run's, or check that it already is; forget what must not be resumed.

    Raises:
        InputError: It holds a run of other settings.
    """
    path = folder / "settings.json"
    wanted = json.loads(json.dumps(record))
    if not resume:
        (folder / "last.ckpt").unlink(missing_ok=True)
    elif path.is_file() and json.loads(path.read_text()) != wanted:
        raise InputError(
            f"{folder} holds a run of other settings: choose another folder, or resume=false"
        )
    write_json(path, wanted)


def _fit(
    folder: Path,
    faces: FaceSettings,
    training: TrainingSettings,
    crops: Faces,
    validation: dict[str, torch.Tensor],
) -> Path:
    logging.getLogger("lightning.pytorch").setLevel(logging.WARNING)  # it advertises
    data = _FacesData(crops, validation, training)
    module = ArcFaceModule(
        people=faces.identities,
        steps=training.epochs * len(_Epoch(crops, training, 0)),
        learning_rate=training.learning_rate,
        weight_decay=training.weight_decay,
        scale=training.scale,
        margin=training.margin,
        seed=training.seed,
        antialias=faces.antialias,
    )
    keep: dict[str, Any] = {
        "dirpath": folder,
        "save_on_train_epoch_end": True,
        "enable_version_counter": False,
    }
    best = ModelCheckpoint(filename="best", monitor="val/auc", mode="max", **keep)
    latest = ModelCheckpoint(filename="last", **keep)
    trainer = lightning.Trainer(
        max_epochs=training.epochs,
        accelerator="auto",
        devices=1,
        precision=_precision(training.precision),
        callbacks=[_Record(folder), best, latest],
        logger=False,
        enable_progress_bar=False,
        enable_model_summary=False,
        num_sanity_val_steps=0,
        reload_dataloaders_every_n_epochs=1,
    )
    last = folder / "last.ckpt"
    with warnings.catch_warnings():
        # Batches are made in this process: on two cores a second one only takes turns with it.
        warnings.filterwarnings("ignore", ".*does not have many workers.*")
        warnings.filterwarnings("ignore", ".*Checkpoint directory .* exists.*")
        warnings.filterwarnings("ignore", ".*LeafSpec.*")  # Lightning against a newer torch
        try:
            trainer.fit(
                module,
                datamodule=data,
                ckpt_path=last if last.is_file() else None,
                weights_only=True,
            )
        except SystemExit as stop:  # Lightning's answer to Ctrl-C
            raise KeyboardInterrupt from stop
    return folder / "best.ckpt"


def _precision(asked: str) -> Any:
    if asked != "auto":
        return asked
    return "bf16-mixed" if torch.cuda.is_available() or has_bfloat16() else "32-true"


def read_checkpoint(path: Path) -> ArcFaceModule:
    """Read a checkpoint of :func:`train_embedder`: numbers and strings only.

    Raises:
        InputError: The file is missing or is no such checkpoint.
    """
    try:
        return ArcFaceModule.load_from_checkpoint(path, map_location="cpu", weights_only=True)
    except Exception as error:  # the formats that a broken file can seem to have are many
        reason = " ".join(str(error).split())[:160]
        raise InputError(f"{path}: no checkpoint of lrsr train ({reason}); train again") from error


def _finish(
    folder: Path, best: Path, validation: dict[str, torch.Tensor], record: dict[str, Any]
) -> Path:
    """Export the best epoch and write the final record, measured on the ONNX file itself."""
    module = read_checkpoint(best)
    people, seed = record["faces"]["identities"], record["training"]["seed"]
    source = f"lrsr train recognition=arcface: {people} rendered people, seed {seed}"
    model = folder / "model.onnx"
    export_embedder(module.backbone, model, antialias=record["faces"]["antialias"], source=source)
    embedder = Embedder(model)
    embedded = {name: embedder(crops.float() / 255) for name, crops in validation.items()}
    history = torch.load(folder / "last.ckpt", map_location="cpu", weights_only=True)["history"]
    result = {
        "finished": True,
        "model_sha256": sha256_of(model),
        "parameters": sum(p.numel() for p in module.backbone.parameters()),
        "best_epoch": module.history[-1]["epoch"],
        "onnx": {f"val/{name}": auc for name, auc in verification_aucs(embedded).items()},
        "settings": record,
        "history": history,
    }
    write_json(folder / "metrics.json", result)
    return folder
