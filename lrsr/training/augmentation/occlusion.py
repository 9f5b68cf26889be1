"""What hides a part of a face? A hand, a scarf, a cap, another head: here textured patches.

Rectangles as in Zhong et al., *Random Erasing Data Augmentation* (AAAI 2020), or all of the face
below the nose or above the brows.
"""

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray

from lrsr.recognition.alignment import CROP_PX
from lrsr.training.augmentation.ranges import SHARE, check_ranges
from lrsr.training.augmentation.texture import draw_textures

_MOST_ASPECT = 1 / 0.3
"""Longer over shorter side, Zhong et al., section 4.1."""
_UPPER_PX, _LOWER_PX = (20.0, 45.0), (68.0, 95.0)
"""How far down what hides the brow reaches, and how far up what hides the mouth: the pupils lie at
51.6 px, the tip of the nose at 71.7, the corners of the mouth at 92.3."""


@dataclass(frozen=True)
class Occlusion:
    """How many faces are hidden in part, and how much of them.

    Attributes:
        share: How many, 0 to 1.
        area: Least and most of the picture that a rectangle covers, 0 to 0.5.
        band_share: How many of those lose their lower or upper part instead, 0 to 1.

    Raises:
        InputError: A number is out of its range.
    """

    share: float = 0.0
    area: tuple[float, float] = (0.02, 0.2)
    band_share: float = 0.0

    def __post_init__(self) -> None:
        limits = {"share": SHARE, "area": (0.0, 0.5), "band_share": SHARE}
        check_ranges(self, "degradation.occlusion", limits, spans=["area"])

    def __call__(self, faces: torch.Tensor, rng: np.random.Generator) -> torch.Tensor:
        """Hide parts of aligned faces.

        Args:
            faces: ``(B, 3, 112, 112)``, srgb, [0, 1].
            rng: Source of every choice.

        Returns:
            The same shape.
        """
        hidden = np.flatnonzero(rng.random(len(faces)) < self.share)
        result = faces.clone()
        covers = draw_textures(len(hidden), CROP_PX, rng).to(faces)
        for row, cover in zip(hidden, covers, strict=True):
            band = rng.random() < self.band_share
            top, bottom, left, right = _band(rng) if band else self._rectangle(rng)
            result[row, :, top:bottom, left:right] = cover[:, top:bottom, left:right]
        return result

    def _rectangle(self, rng: np.random.Generator) -> NDArray[np.int64]:
        """Draw top, bottom, left and right of a rectangle within the picture."""
        area, limit = rng.uniform(*self.area), np.log(_MOST_ASPECT)
        aspect = np.exp(rng.uniform(-limit, limit))
        sides = CROP_PX * np.minimum(np.sqrt([area * aspect, area / aspect]), 1)
        start = rng.uniform(0, CROP_PX - sides)
        edges: NDArray[np.int64] = np.stack([start, start + sides], 1).round().astype(np.int64)
        return edges.ravel()


def _band(rng: np.random.Generator) -> tuple[int, int, int, int]:
    if rng.random() < 0.5:
        return 0, round(rng.uniform(*_UPPER_PX)), 0, CROP_PX
    return round(rng.uniform(*_LOWER_PX)), CROP_PX, 0, CROP_PX
