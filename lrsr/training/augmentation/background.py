"""What stands behind a face? One even colour, which is keyed out and replaced."""

from dataclasses import dataclass

import numpy as np
import torch
from torch.nn import functional as F

from lrsr.recognition.alignment import CROP_PX, TEMPLATE_PX
from lrsr.training.augmentation.ranges import SHARE, check_ranges
from lrsr.training.augmentation.texture import draw_textures

_TOLERANCE = 6 / 255
"""How far the background's noise carries it from its own colour (by eye)."""
_CORE_PX = (34.0, 46.0)
"""Half width and half height of the ellipse about the nose that is never background."""


@dataclass(frozen=True)
class Background:
    """How many faces stand before something else.

    Attributes:
        share: 0 to 1.

    Raises:
        InputError: It is out of its range.
    """

    share: float = 0.0

    def __post_init__(self) -> None:
        check_ranges(self, "degradation.background", {"share": SHARE})

    def __call__(self, faces: torch.Tensor, rng: np.random.Generator) -> torch.Tensor:
        """Put aligned faces before a random texture.

        Args:
            faces: ``(B, 3, 112, 112)``, srgb, [0, 1], sharp and not compressed.
            rng: Source of every choice.

        Returns:
            The same shape.
        """
        rows = torch.from_numpy(np.flatnonzero(rng.random(len(faces)) < self.share))
        result = faces.clone()
        if len(rows):
            behind = draw_textures(len(rows), CROP_PX, rng).to(faces)
            result[rows] = faces[rows].lerp(behind, _background(faces[rows]))
        return result


def _background(faces: torch.Tensor) -> torch.Tensor:
    """Tell how much of each pixel ``(B, 1, 112, 112)`` has the commonest colour of the edge."""
    edge = torch.cat([faces[..., 0, :], faces[..., :, 0], faces[..., :, -1]], dim=-1)
    apart = (edge[:, :, :, None] - edge[:, :, None, :]).abs().amax(dim=1)
    commonest = (apart < _TOLERANCE).sum(dim=-1).argmax(dim=-1)
    colour = edge[torch.arange(len(faces)), :, commonest][:, :, None, None]
    alike = (faces - colour).abs().amax(dim=1, keepdim=True) < _TOLERANCE
    alike &= ~_CORE.to(faces.device)
    return F.avg_pool2d(alike.to(faces), 3, stride=1, padding=1, count_include_pad=False)


def _core() -> torch.Tensor:
    y, x = np.mgrid[:CROP_PX, :CROP_PX]
    (right, down), (half_width, half_height) = TEMPLATE_PX[2], _CORE_PX
    return torch.from_numpy(((x - right) / half_width) ** 2 + ((y - down) / half_height) ** 2 < 1)


_CORE = _core()
