"""How does a network learn a face's position map? By the distance of each texel from the true one.

Features count most, then the rest of the face, and least what is behind it, as in PRNet (Feng et
al., ECCV 2018, section 3.3).
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import torch

from lrsr.configuration import as_number, as_whole, require
from lrsr.files import write_text
from lrsr.identities.photographs.landmarker import Landmarker
from lrsr.identities.photographs.zones import zones
from lrsr.onnx import contract_path, declared_text, sha256_of
from lrsr.pictures.recipe import derived_seed
from lrsr.recognition.alignment import CROP_PX
from lrsr.sr.weights import read_checkpoint
from lrsr.training.export import export_onnx
from lrsr.training.learner import Learner, MakeOptimizer, MakeScheduler
from lrsr.training.map_network import MapNetwork
from lrsr.training.portraits import Portraits
from lrsr.training.position_maps import MAP_SIZE, RULE, skin_mask

_MEAN = _SCALE = 127.5
"""The network sees (255 srgb - mean) / scale."""
_LEAST = 1e-6
"""Square of the distance, of the crop's side, below which a texel pulls less: 0.1 px."""

_Batch = tuple[torch.Tensor, torch.Tensor]


class PositionMapping(Learner):
    """Network, portraits, weights of the texels, and the validation by distance.

    Args:
        optimizer: See :class:`Learner`.
        scheduler: See :class:`Learner`.
        portraits: Makes portraits of rendered faces.
        features: Weight of eyes, brows, nose and mouth, the rest of the face having 1; > 0.
        behind: Weight of the rest of the head, >= 0.
        seed: Of the weights and of every portrait, any whole number.

    Raises:
        InputError: A number is out of its range, or ``portraits`` makes something else.
    """

    monitor = "val/off_px"
    mode = "min"
    lessons = ("position_maps",)
    weights: torch.Tensor
    face: torch.Tensor

    def __init__(
        self,
        *,
        optimizer: MakeOptimizer,
        scheduler: MakeScheduler | None = None,
        portraits: Portraits,
        features: float,
        behind: float,
        seed: int = 0,
    ) -> None:
        super().__init__(optimizer, scheduler)
        features = as_number(features, "module.features")
        behind = as_number(behind, "module.behind")
        require(features > 0, "module.features", features, "a number > 0")
        require(behind >= 0, "module.behind", behind, "a number >= 0")
        kind = type(portraits).__name__
        require(isinstance(portraits, Portraits), "degradation", kind, "portraits")
        self.portraits, self.seed = portraits, as_whole(seed, "module.seed")
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(derived_seed(seed, "weights"))
            self.network = MapNetwork().to(memory_format=torch.channels_last)
        self.register_buffer("weights", _weights(features, behind), persistent=False)
        self.register_buffer("face", _weights(1.0, 0.0) > 0, persistent=False)

    def forward(self, srgb: torch.Tensor) -> torch.Tensor:
        """Map srgb ``(B, 3, 112, 112)``, [0, 1], to ``(B, 3, 64, 64)``, in sides of the crop."""
        faces = (srgb * 255 - _MEAN) / _SCALE
        maps: torch.Tensor = self.network(faces.contiguous(memory_format=torch.channels_last))
        return maps

    def loss(self, batch: _Batch) -> torch.Tensor:
        """Make portraits, and return the weighted mean distance of texels, in sides of the crop."""
        rng = np.random.default_rng(derived_seed(self.seed, "portraits", self.global_step))
        faces, maps = self.portraits(*batch, rng)
        squares = (self(faces) - maps / CROP_PX).square().sum(dim=1)
        loss: torch.Tensor = (self.weights * (squares + _LEAST).sqrt()).mean()
        return loss

    def validation_step(self, batch: _Batch, batch_idx: int) -> None:
        """Log how far texels of the face are from where they should be on the crop, px."""
        crops, maps = batch
        found = CROP_PX * self(crops.float() / 255).float()
        off = (found - maps)[:, :2].norm(dim=1)
        self.log("val/off_px", off[:, self.face].mean(), batch_size=len(crops))

    def in_words(self, figures: Mapping[str, float]) -> str:
        """Tell the loss and the distance."""
        return f"loss {figures['train/loss']:.4f}, {figures['val/off_px']:.2f} px off"

    def ship(self, folder: Path, best: Path) -> dict[str, Any]:
        """Write model.onnx and its contract, as ``lrsr calibrate-reconstructor`` reads it."""
        self.load_state_dict(read_checkpoint(best)["state_dict"])
        network, model = self.network.float().cpu().eval(), folder / "model.onnx"
        source = f"lrsr train reconstructor=position_map: rendered people, seed {self.seed}"
        export_onnx(
            model,
            network,
            shapes=[(2, 3, CROP_PX, CROP_PX), (5, 3, CROP_PX, CROP_PX)],
            names=("faces", "map"),
            free={0: "batch"},
            about={"source": source},
        )
        told = {
            "sha256": sha256_of(model),
            "licence": "MIT",
            "source": source,
            "input": {"channels": "RGB", "size_px": CROP_PX, "mean": _MEAN, "scale": _SCALE},
            "output": {
                "points": "map",
                "shape": [3, MAP_SIZE, MAP_SIZE],
                "unit_px": float(CROP_PX),
                "symmetric": True,
            },
            "crop": {"box": "five", "side": RULE.side, "shift": RULE.shift},
        }
        write_text(contract_path(model), declared_text(told))
        return {"model_sha256": Landmarker(model).contract.sha256}


def _weights(features: float, behind: float) -> torch.Tensor:
    """Return what each texel of a map counts, ``(64, 64)``, 1 on average; 0 outside the skin."""
    zone, covered = zones(MAP_SIZE), skin_mask()
    weights = np.where(zone.features, features, np.where(zone.front, 1.0, behind)) * covered
    return torch.from_numpy(weights / weights.mean()).float()
