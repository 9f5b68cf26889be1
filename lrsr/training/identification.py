"""How does a network learn to tell people apart? By an angular margin, judged by verification."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

import numpy as np
import torch
import torch.nn.functional as F
from numpy.typing import NDArray

from lrsr.configuration import as_flag, as_number, as_whole
from lrsr.errors import InputError
from lrsr.evaluation.delong import measure_auc
from lrsr.files import write_text
from lrsr.onnx import contract_path, sha256_of
from lrsr.pictures.recipe import derived_seed
from lrsr.recognition.alignment import CROP_PX
from lrsr.recognition.contract import Contract, write_contract
from lrsr.recognition.embedding import Embedder
from lrsr.sr.weights import read_checkpoint
from lrsr.training.backbone import DIMENSION, Backbone
from lrsr.training.degradation import Degradation
from lrsr.training.export import export_onnx
from lrsr.training.learner import Learner, MakeOptimizer, MakeScheduler
from lrsr.training.margin import AngularMargin

_MEAN = _SCALE = 127.5
"""The network sees (255 srgb - MEAN) / SCALE."""

_Batch = tuple[torch.Tensor, torch.Tensor, torch.Tensor]


class Identification(Learner):
    """Backbone, angular margin, degradation and the validation by verification.

    Args:
        people: How many to learn.
        optimizer: See :class:`Learner`; norms and biases do not decay.
        scheduler: See :class:`Learner`.
        degradation: Makes sharp faces small, dim and noisy.
        scale: s of the angular margin, > 0.
        margin: m of the angular margin, radians, 0 to π/2.
        antialias: How the crops were aligned, for the contract.
        seed: Of the weights and of every degradation, any whole number.

    Raises:
        InputError: A number is out of its range, or the degradation is another network's.
    """

    monitor = "val/auc"
    lessons = ("faces",)

    def __init__(
        self,
        *,
        people: int,
        optimizer: MakeOptimizer,
        scheduler: MakeScheduler | None = None,
        degradation: Degradation,
        scale: float = 32.0,
        margin: float = 0.4,
        antialias: bool = True,
        seed: int = 0,
    ) -> None:
        super().__init__(optimizer, scheduler)
        if not as_number(scale, "module.scale") > 0:
            raise InputError(f"module.scale={scale}: wanted a number > 0")
        if not 0 <= as_number(margin, "module.margin") < np.pi / 2:
            raise InputError(f"module.margin={margin}: wanted 0 to 1.57")
        if not isinstance(degradation, Degradation):
            raise InputError(
                f"degradation={type(degradation).__name__}: wanted photographs, for"
                " recognition=arcface"
            )
        self.people, self.seed = as_whole(people, "module.people"), as_whole(seed, "module.seed")
        self.antialias = as_flag(antialias, "module.antialias")
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(derived_seed(seed, "weights"))
            self.backbone = Backbone().to(memory_format=torch.channels_last)
            self.head = AngularMargin(DIMENSION, people, scale=scale, margin=margin)
        self.degradation = degradation
        self._embedded: dict[str, NDArray[np.float32]] = {}

    def forward(self, srgb: torch.Tensor) -> torch.Tensor:
        """Embed srgb ``(B, 3, 112, 112)``, [0, 1], as ``(B, 128)``."""
        faces = (srgb * 255 - _MEAN) / _SCALE
        embeddings: torch.Tensor = self.backbone(
            faces.contiguous(memory_format=torch.channels_last)
        )
        return embeddings

    def loss(self, batch: _Batch) -> torch.Tensor:
        """Degrade, embed, and return the cross-entropy of the angular margin."""
        crops, people, sharp = batch
        rng = np.random.default_rng(derived_seed(self.seed, "degradation", self.global_step))
        logits = self.head(self(self.degradation(crops, sharp, rng)), people)
        accuracy = (logits.detach().argmax(1) == people).float().mean()
        self.log("train/accuracy", accuracy, on_step=False, on_epoch=True)
        return F.cross_entropy(logits, people)

    def parameter_groups(self) -> list[dict[str, Any]]:
        """Return what decays, and norms and biases, which do not."""
        parameters = list(self.parameters())
        return [
            {"params": [p for p in parameters if p.ndim > 1]},
            {"params": [p for p in parameters if p.ndim <= 1], "weight_decay": 0.0},
        ]

    def validation_step(self, batch: tuple[str, torch.Tensor], batch_idx: int) -> None:
        """Embed one set of validation faces: its name and ``(n, 3, 112, 112)`` uint8."""
        name, crops = batch
        self._embedded[name] = F.normalize(self(crops.float() / 255).float()).numpy(force=True)

    def on_validation_epoch_end(self) -> None:
        """Log val/auc_ipd64 ... and their mean, val/auc."""
        for name, auc in _verification_aucs(self._embedded).items():
            self.log(f"val/{name}", auc)
        self._embedded = {}

    def in_words(self, figures: Mapping[str, float]) -> str:
        """Tell the loss, the accuracy and the AUCs."""
        return ", ".join(f"{name.split('/')[1]} {figures[name]:.3f}" for name in sorted(figures))

    def ship(self, folder: Path, best: Path) -> dict[str, Any]:
        """Write model.onnx and its contract; measure what was written."""
        self.load_state_dict(read_checkpoint(best)["state_dict"])
        network, model = self.backbone.float().cpu().eval(), folder / "model.onnx"
        source = f"lrsr train recognition=arcface: {self.people} rendered people, seed {self.seed}"
        export_onnx(
            model,
            network,
            shapes=[(2, 3, CROP_PX, CROP_PX), (5, 3, CROP_PX, CROP_PX)],
            names=("faces", "embeddings"),
            free={0: "batch"},
            about={"source": source},
        )
        contract = Contract(
            sha256=sha256_of(model),
            licence="MIT",
            source=source,
            layout="NCHW",
            channels="RGB",
            height_px=CROP_PX,
            width_px=CROP_PX,
            mean=_MEAN,
            scale=_SCALE,
            dimension=DIMENSION,
            template="arcface5",
            antialias=self.antialias,
        )
        write_text(contract_path(model), write_contract(contract))
        return {"model_sha256": contract.sha256, "onnx": self._measured(Embedder(model))}

    def _measured(self, embedder: Embedder) -> dict[str, float]:
        sets = cast("Any", self.trainer).datamodule.val_dataloader()
        embedded = {name: embedder(crops.float() / 255) for name, crops in sets}
        return {f"val/{name}": auc for name, auc in _verification_aucs(embedded).items()}


def _verification_aucs(embedded: Mapping[str, NDArray[np.float32]]) -> dict[str, float]:
    """Compare each set of probes with the gallery, everybody with everybody.

    Args:
        embedded: "gallery" and sets of probes, each ``(people, D)``, length 1, in the same order.

    Returns:
        "auc_NAME" for each probe set, and "auc", their mean.

    Example:
        >>> _verification_aucs({"gallery": np.eye(3), "ipd8": np.eye(3)})
        {'auc_ipd8': 1.0, 'auc': 1.0}
    """
    gallery = embedded["gallery"]
    genuine = np.eye(len(gallery), dtype=bool)
    aucs = {}
    for name, probes in embedded.items():
        if name != "gallery":
            scores = probes @ gallery.T
            aucs[f"auc_{name}"] = measure_auc(scores[genuine], scores[~genuine])
    return {**aucs, "auc": float(np.mean(list(aucs.values())))}
