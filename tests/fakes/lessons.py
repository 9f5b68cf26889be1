"""Lessons that take milliseconds, drawn pictures and painted faces, for every training test."""

from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import torch
from lightning.pytorch import LightningDataModule, Trainer
from torch.utils.data import DataLoader, TensorDataset

from lrsr.camera import Camera
from lrsr.images import resize_bicubic
from lrsr.presets import preset
from lrsr.recognition.alignment import TEMPLATE_PX
from lrsr.training.augmentation.background import Background
from lrsr.training.augmentation.blur import Blur
from lrsr.training.augmentation.colour import Colour
from lrsr.training.augmentation.misalignment import Misalignment
from lrsr.training.augmentation.occlusion import Occlusion
from lrsr.training.degradation import Degradation
from lrsr.training.faces import _draw_views
from lrsr.training.identification import Identification
from lrsr.training.losses.adversarial import AdversarialLoss
from lrsr.training.losses.identity import IdentityLoss
from lrsr.training.order import EpochOrder
from lrsr.training.patches import FacePatches, LuminancePatches, Pair, Patches
from lrsr.training.patchwork import Patchwork
from lrsr.training.restoration import Restoration
from lrsr.training.shrinking.shrinking import Shrinking

cosine = partial(torch.optim.lr_scheduler.CosineAnnealingLR)
quiet = partial(Trainer, accelerator="cpu", devices=1, log_every_n_steps=1)


def draw_pictures(count: int, size: int, seed: int) -> torch.Tensor:
    """Grey discs with sharp edges, (count, 3, size, size) srgb."""
    generator = torch.Generator().manual_seed(seed)
    y, x = torch.meshgrid(torch.arange(size), torch.arange(size), indexing="ij")
    pictures = torch.full((count, 3, size, size), 0.5)
    for picture in pictures:
        for _ in range(12):
            cx, cy, r, tone = torch.rand(4, generator=generator).tolist()
            inside = (x - cx * size) ** 2 + (y - cy * size) ** 2 < (0.05 + 0.15 * r) ** 2 * size**2
            picture[:, inside] = tone
    return pictures


class SyntheticPairs(LightningDataModule):
    """Pictures, shrunk to half, and as they were, as if each were a face of 18 px."""

    def __init__(
        self, *, batch_size: int = 16, count: int = 4, patches: Patches | None = None
    ) -> None:
        super().__init__()
        self.batch_size = batch_size
        cut = (patches or LuminancePatches()).cut
        landmarks_px = torch.from_numpy(TEMPLATE_PX).float().mul(0.5).expand(count, 5, 2)
        self.train_pairs = cut(*self._pairs(count, 62, seed=1), landmarks_px)
        self.val_pairs = self._pairs(2, 48, seed=2)

    @staticmethod
    def _pairs(count: int, size: int, seed: int) -> Pair:
        true = draw_pictures(count, size, seed)
        return resize_bicubic(true, 0.5).clamp(0, 1), true

    def train_dataloader(self) -> DataLoader[Any]:
        data = TensorDataset(*self.train_pairs)
        rows = np.arange(len(data))
        order = EpochOrder(lambda rng: rows.copy(), batch_size=self.batch_size, seed=0)
        return DataLoader(data, sampler=order, batch_size=None)

    def val_dataloader(self) -> DataLoader[Any]:
        return DataLoader(TensorDataset(*self.val_pairs), batch_size=1)


class RedrawnPairs(Patchwork):
    """Pictures through other cameras in every epoch."""

    redrawn = True
    lr_made_by = "drawn"

    def __init__(self) -> None:
        super().__init__()
        self.batch_size, self.seed, self.patches = 8, 0, LuminancePatches()
        self.degradation: Shrinking = preset("degradation", "random_cameras")

    def pairs(self, epoch: int | None) -> Iterator[Pair]:
        true = draw_pictures(3, 48, seed=1).mul(255).round() / 255
        return self.degradation(true, 2, self.degradation_seeds(epoch, 0, 3), Camera())


class FaceLessons(SyntheticPairs):
    """The same, each whole, with landmarks."""

    def __init__(self) -> None:
        super().__init__(batch_size=2, patches=FacePatches(28))


class PaintedFaces(LightningDataModule):
    """Smooth random faces of a few people, in two guises each."""

    def __init__(self, people: int = 4) -> None:
        super().__init__()
        tones = torch.rand(people, 3, 5, 5, generator=torch.Generator().manual_seed(0))
        faces = torch.nn.functional.interpolate(tones, size=(112, 112), mode="bilinear")
        self.crops = faces.mul(255).to(torch.uint8)
        self.people = torch.arange(people).repeat(2)
        self.sharp = torch.arange(2 * people) < people

    def train_dataloader(self) -> DataLoader[Any]:
        data = TensorDataset(self.crops.repeat(2, 1, 1, 1), self.people, self.sharp)
        draw = partial(_draw_views, self.people.numpy(), self.sharp.numpy(), 2)
        return DataLoader(data, sampler=EpochOrder(draw, batch_size=4, seed=0), batch_size=None)

    def val_dataloader(self) -> DataLoader[Any]:
        sets: Any = [("gallery", self.crops), ("ipd8", self.crops // 2)]
        return DataLoader(sets, batch_size=None)


def make_srcnn(*, lr: float = 1e-3, scheduler: Any = cosine, seed: int = 0) -> Restoration:
    return Restoration(
        architecture="srcnn",
        arguments={"initialisation": "near-identity"},
        scale=2,
        loss="mse",
        optimizer=partial(torch.optim.Adam, lr=lr),
        scheduler=scheduler,
        slower={"reconstruct": 0.1},
        seed=seed,
    )


def make_edsr(**settings: Any) -> Restoration:
    return Restoration(
        architecture="edsr",
        arguments={"scale": 2, "blocks": 1, "features": 8, "initialisation": "near-bicubic"},
        scale=2,
        loss="l1",
        optimizer=partial(torch.optim.Adam, lr=1e-3),
        scheduler=cosine,
        **settings,
    )


def make_told() -> Restoration:
    """A network that is told more than its pixels, by one that learns and one that does not."""
    adam = partial(torch.optim.Adam, lr=1e-3)
    told = {
        "identity": IdentityLoss(weight=0.1),
        "adversarial": AdversarialLoss(weight=0.01, optimizer=adam, features=4),
    }
    return make_edsr(turned=True, losses=told)


def everything() -> Degradation:
    """A little of all that may be done to a face."""
    return Degradation(
        noise=0.03,
        background=Background(0.5),
        occlusion=Occlusion(0.2, band_share=0.5),
        blur=Blur(0.3, sigma=(0.0, 0.03), motion_share=0.5, motion=(0.0, 0.1)),
        colour=Colour(0.15, 0.03, 0.15, 0.1, 0.1, 4.0, 0.1),
        misalignment=Misalignment(0.5, nose_up=0.04, jitter=0.02),
    )


def make_arcface(people: int = 4, *, seed: int = 0) -> Identification:
    return Identification(
        people=people,
        optimizer=partial(torch.optim.AdamW, lr=3e-3, weight_decay=0.05),
        scheduler=partial(
            torch.optim.lr_scheduler.OneCycleLR, max_lr=3e-3, pct_start=0.15, cycle_momentum=False
        ),
        degradation=everything(),
        seed=seed,
    )


def train_fake(network: str, folder: Path, epochs: int) -> None:
    """Train one of the fakes; what a process that is going to be killed runs."""
    from lrsr.training.progress import Progress
    from lrsr.training.run import train

    torch.set_num_threads(1)
    module, data = {
        "srcnn": lambda: (make_srcnn(), SyntheticPairs()),
        "arcface": lambda: (make_arcface(), PaintedFaces()),
    }[network]()
    train(
        module,
        data,
        folder=folder,
        trainer=partial(quiet, max_epochs=epochs),
        callbacks=[Progress()],
        depends_on={"network": network, "epochs": epochs},
    )


def train_by_command(folder: Path, epochs: int, *more: str) -> int:
    """Run ``lrsr train`` itself, on drawn pictures, with constant rates; return its status.

    No ONNX file is written: that takes seconds.
    """
    from lrsr.cli import main
    from lrsr.training import lessons, restoration

    class Drawn(SyntheticPairs):
        unread: Mapping[str, str] = {}

        def about(self) -> dict[str, Any]:
            return {}

    torch.set_num_threads(1)
    lessons.read_lessons = lambda *_: Drawn()  # type: ignore[assignment]
    restoration.export_onnx = lambda *_, **__: 0.0
    words = ["train", "sr=srcnn2x", "module.scheduler=null", f"trainer.max_epochs={epochs}", *more]
    return main([*words, "trainer.accelerator=cpu", "identities.count=2", f"paths.run={folder}"])
