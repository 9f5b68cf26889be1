"""In which order are things shown? One that follows from seed and epoch, whenever a run began."""

from collections.abc import Callable, Iterator

import numpy as np
import torch
from numpy.typing import NDArray
from torch.utils.data import Sampler

from lrsr.pictures.recipe import derived_seed


class EpochOrder(Sampler[torch.Tensor]):
    """Batches of row numbers; Lightning says which epoch it is.

    Args:
        draw: Gives the rows of one epoch, always as many; they are shuffled here.
        batch_size: Rows in a batch, or a few more where they do not divide.
        seed: Of the order, any whole number.

    Example:
        >>> order = EpochOrder(lambda rng: np.arange(5), batch_size=2, seed=0)
        >>> [len(batch) for batch in order]
        [3, 2]
    """

    def __init__(
        self,
        draw: Callable[[np.random.Generator], NDArray[np.int64]],
        *,
        batch_size: int,
        seed: int,
    ) -> None:
        self.draw, self.seed, self.epoch = draw, seed, 0
        self.count = max(len(draw(np.random.default_rng(0))) // batch_size, 1)

    def set_epoch(self, epoch: int) -> None:
        """Choose the order of that epoch."""
        self.epoch = epoch

    def __len__(self) -> int:
        return self.count

    def __iter__(self) -> Iterator[torch.Tensor]:
        # Drawn with the first batch: going on, Lightning says which epoch it is after this call.
        rng = np.random.default_rng(derived_seed(self.seed, "order", self.epoch))
        rows = self.draw(rng)
        rng.shuffle(rows)
        yield from map(torch.from_numpy, np.array_split(rows, self.count))
