"""What if a network learns from people and from pictures? Both, each a share of every epoch."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from lrsr.configuration import as_number, require
from lrsr.training.images import Images
from lrsr.training.pairs import Pairs
from lrsr.training.patchwork import Batch, Patchwork


@dataclass(kw_only=True, eq=False)
class Mixed(Patchwork):
    """Patches of rendered people and of pictures, degraded alike; all of both validate.

    Attributes:
        rendered: The people.
        images: The pictures.
        rendered_share: Part of an epoch's patches that show people, between 0 and 1. All of what
            there is less of are shown, and as many of the others, drawn anew in each epoch.

    Raises:
        InputError: The share is out of its range.
    """

    rendered: Pairs
    images: Images
    rendered_share: float = 0.5

    def __post_init__(self) -> None:
        super().__init__()
        share = as_number(self.rendered_share, "data.rendered_share")
        require(0 < share < 1, "data.rendered_share", share, "a number > 0 and < 1")
        self.rendered_share = share
        self.batch_size, self.seed = self.rendered.batch_size, self.rendered.seed
        self.patches = self.rendered.patches
        self.count = 0

    def about(self) -> dict[str, Any]:
        """Return what all of it depends on, in plain values."""
        return self.rendered.about() | self.images.about()

    @property
    def unread(self) -> Mapping[str, str]:
        """Return sections of the configuration that change nothing, and why."""
        return self.rendered.unread

    @property
    def redrawn(self) -> bool:
        """Do the pairs differ from epoch to epoch?"""
        return self.rendered.redrawn or self.images.redrawn

    @property
    def lr_made_by(self) -> str:
        """How the small pictures are made, in words."""
        ways = dict.fromkeys((self.rendered.lr_made_by, self.images.lr_made_by))
        return "; or ".join(ways)

    def prepare_data(self) -> None:
        """Render what the cache lacks.

        Raises:
            InputError: The cache cannot be written or the disk is full.
        """
        self.rendered.prepare_data()

    def setup(self, stage: str | None = None) -> None:
        """Read the pictures, then see the base.

        Args:
            stage: Lightning's; all stages need both.
        """
        self.images.read()
        super().setup(stage)

    def pairs(self, epoch: int | None) -> Iterator[Batch]:
        """Yield pairs of people, then of pictures."""
        yield from self.rendered.pairs(epoch)
        yield from self.images.pairs(epoch)

    def cut(self, epoch: int) -> Batch:
        """Return the patches of an epoch, those of people first."""
        people, pictures = self.rendered.cut(epoch), self.images.cut(epoch)
        self.count = len(people[0])
        return tuple(map(torch.cat, zip(people, pictures, strict=True)))

    def rows(self, rng: np.random.Generator) -> NDArray[np.int64]:
        """Draw the patches of an epoch; the share is met to one patch."""
        of_people, of_pictures = self.count, len(self.lessons) - self.count
        share = self.rendered_share
        shown = min(of_people / share, of_pictures / (1 - share))
        people = rng.permutation(of_people)[: max(1, round(shown * share))]
        pictures = rng.permutation(of_pictures)[: max(1, round(shown * (1 - share)))]
        return np.concatenate([people, of_people + pictures])
