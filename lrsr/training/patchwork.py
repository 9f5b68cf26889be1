"""How do pairs of pictures become lessons? Patches by epoch to learn from, wholes to judge."""

from abc import abstractmethod
from collections.abc import Callable, Iterator

import numpy as np
import torch
from lightning.pytorch import LightningDataModule
from numpy.typing import NDArray
from torch.utils.data import DataLoader, Dataset

from lrsr.pictures.recipe import derived_seed
from lrsr.training.order import EpochOrder
from lrsr.training.patches import Pair, Patches

Batch = tuple[torch.Tensor, ...]
"""Small and true pictures, and maybe the landmarks of the latter; or what is cut from them."""


class _EpochPatches(Dataset[Batch]):
    """The patches of one epoch, contiguous; those of the next replace them where they differ.

    Args:
        cut: Returns inputs, targets and what else a loss asks for of an epoch, always as many.
        redrawn: They differ from epoch to epoch.

    Attributes:
        order: Says which epoch it is.
    """

    def __init__(self, cut: Callable[[int], Batch], *, redrawn: bool) -> None:
        self.cut, self.redrawn = cut, redrawn
        self.epoch, self.patches = 0, cut(0)
        self.count = len(self.patches[0])
        self.order: EpochOrder | None = None

    def __len__(self) -> int:
        return self.count

    def __getitem__(self, rows: torch.Tensor) -> Batch:
        epoch = self.order.epoch if self.order else 0
        if self.redrawn and epoch != self.epoch:
            del self.patches  # two epochs at once might not fit in memory
            self.epoch, self.patches = epoch, self.cut(epoch)
        return tuple(part[rows] for part in self.patches)


class Patchwork(LightningDataModule):
    """Pairs of small and true pictures, from wherever a subclass has them.

    ``setup`` cuts patches into two contiguous tensors (SRCNN: 6 kB a pair; 9 patches of a 64×64
    target, 49 of 128×128). Where something is drawn, each epoch's are cut when its first batch is
    asked for; all of them follow from the seed and the number of the epoch.

    Attributes:
        batch_size: Patches in a step.
        seed: All that is drawn follows from it, any whole number.
        patches: Cuts what the network takes and what it should return.
    """

    batch_size: int
    seed: int
    patches: Patches

    @property
    @abstractmethod
    def redrawn(self) -> bool:
        """Do the pairs differ from epoch to epoch?"""

    @property
    @abstractmethod
    def lr_made_by(self) -> str:
        """How the small pictures are made, in words, for the card that goes with the weights."""

    @abstractmethod
    def pairs(self, epoch: int | None) -> Iterator[Batch]:
        """Yield small and true srgb pictures, and landmarks where known; each batch of one size.

        Args:
            epoch: Which of them; not read where nothing is redrawn. None: those to validate on.
        """

    def cut(self, epoch: int) -> Batch:
        """Return the patches of an epoch."""
        cut = [self.patches.cut(*batch) for batch in self.pairs(epoch)]
        return tuple(map(torch.cat, zip(*cut, strict=True)))

    def rows(self, rng: np.random.Generator) -> NDArray[np.int64]:
        """Return which patches an epoch shows, always as many: here all."""
        return np.arange(len(self.lessons))

    def setup(self, stage: str | None = None) -> None:
        """Cut the patches of the first epoch and take the validation pictures, once.

        Args:
            stage: Lightning's; all stages need both.
        """
        if hasattr(self, "lessons"):
            return
        self.lessons = _EpochPatches(self.cut, redrawn=self.redrawn)
        self.validation_pairs = [
            one for batch in self.pairs(None) for one in zip(*batch[:2], strict=True)
        ]

    def train_dataloader(self) -> DataLoader[Batch]:
        """Return batches of what the network takes and should return, in the epoch's order."""
        order = EpochOrder(self.rows, batch_size=self.batch_size, seed=self.seed)
        self.lessons.order = order
        return DataLoader(self.lessons, sampler=order, batch_size=None)

    def val_dataloader(self) -> DataLoader[Pair]:
        """Return whole srgb pictures, ``(1, 3, H, W)`` small and true, one at a time, in order."""
        return DataLoader(self.validation_pairs, batch_size=1)  # type: ignore[arg-type]  # a list serves

    def degradation_seeds(self, epoch: int | None, start: int, count: int) -> list[int]:
        """Return seeds of the degradation of pictures ``start`` to ``start + count - 1``."""
        when = "validation" if epoch is None else epoch
        return [
            derived_seed(self.seed, "degradation", when, index)
            for index in range(start, start + count)
        ]
