"""How like the truth is what a method made of a picture? Pixels, structure, identity, looks.

The truth is the same scene on a finer film, never a picture that was made smaller.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from lrsr.evaluation.quality import psnr_y, ssim_y
from lrsr.pictures.picture import Picture, stack
from lrsr.recognition.recognisers import Recogniser
from lrsr.sr.perceptual import PerceptualDistance

_Floats = NDArray[np.floating[Any]]

MEASURES = ("psnr_y_db", "ssim_y", "identity_similarity", "lpips")
"""What a row says of likeness, a mean over the probes each."""


def by_size(pictures: Sequence[Picture]) -> list[list[int]]:
    """Return the numbers of pictures that have one size and so make a batch."""
    alike: dict[object, list[int]] = {}
    for number, picture in enumerate(pictures):
        alike.setdefault(picture.image.shape, []).append(number)
    return list(alike.values())


@dataclass(frozen=True, eq=False)
class Truth:
    """True references of some pictures, for all methods that enlarge as much.

    Attributes:
        pictures: In the order of the pictures.
        engine: Says how alike two faces are.
        perceptual: Says how far apart pictures look; None: that is not asked.
    """

    pictures: Sequence[Picture]
    engine: Recogniser
    perceptual: PerceptualDistance | None = None

    @cached_property
    def _embeddings(self) -> _Floats:
        """What the recogniser makes of all, ``(n, D)``: once, however many methods there are."""
        groups, order = by_size(self.pictures), np.empty(len(self.pictures), dtype=np.intp)
        parts = []
        for members in groups:
            images, known = stack([self.pictures[i] for i in members])
            parts.append(self.engine.embed(images, known.numpy()))
        order[np.concatenate(groups)] = np.arange(len(order))
        return np.concatenate(parts)[order]

    def measure(
        self, members: Sequence[int], images: torch.Tensor, embedded: _Floats, scale: int
    ) -> dict[str, _Floats]:
        """Hold what a method made of some of the pictures against their references.

        Args:
            members: Numbers of the pictures, n of one size.
            images: ``(n, 3, H, W)`` srgb, enlarged.
            embedded: ``(n, D)``, aligned with the true landmarks; rows of NaN: not known.
            scale: How much was enlarged; as many pixels are cut from each side.

        Returns:
            Each of :data:`MEASURES` that was asked for, ``(n,)``. The similarity of identities is
            what the recogniser says of picture and reference, for embeddings the cosine.
        """
        true = stack([self.pictures[i] for i in members])[0]
        ids = [str(number) for number in members]
        alike = self.engine.compare(
            embedded.astype(np.float64), self._embeddings[members].astype(np.float64), ids, ids
        )
        pair = images.numpy(), true.numpy()
        found: dict[str, _Floats] = {
            "psnr_y_db": psnr_y(*pair, shave=scale),
            "ssim_y": ssim_y(*pair, shave=scale),
            "identity_similarity": alike.mated_scores(),
        }
        return found | ({"lpips": self.perceptual(images, true)} if self.perceptual else {})
