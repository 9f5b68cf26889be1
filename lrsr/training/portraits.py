"""How does a rendered face become a portrait that anybody took? Its position map moves with it."""

from dataclasses import dataclass

import numpy as np
import torch

from lrsr.recognition.alignment import CROP_PX, TEMPLATE_IPD_PX, warp
from lrsr.training.augmentation.background import Background
from lrsr.training.augmentation.blur import Blur
from lrsr.training.augmentation.colour import Colour
from lrsr.training.augmentation.misalignment import Misalignment
from lrsr.training.augmentation.occlusion import Occlusion
from lrsr.training.augmentation.ranges import SHARE, check_ranges
from lrsr.training.degradation import expose


@dataclass(frozen=True)
class Portraits:
    """What training does to crops of faces; see each part.

    Attributes:
        noise: Highest standard deviation of the noise, of 1 = white.
        background: Behind faces.
        occlusion: Of faces.
        blur: Of faces.
        colour: Of faces.
        misalignment: Of the crops.

    Raises:
        InputError: A number is out of its range.
    """

    noise: float
    background: Background
    occlusion: Occlusion
    blur: Blur
    colour: Colour
    misalignment: Misalignment

    def __post_init__(self) -> None:
        check_ranges(self, "degradation", {"noise": SHARE})

    def __call__(
        self, crops: torch.Tensor, maps: torch.Tensor, rng: np.random.Generator
    ) -> tuple[torch.Tensor, torch.Tensor]:
        """Change a batch; the same ``rng`` state gives the same result.

        Args:
            crops: ``(B, 3, 112, 112)`` uint8, srgb.
            maps: ``(B, 3, S, S)`` float32: x, y, nearness, px of the crop; symmetric in layout.
            rng: Source of every choice.

        Returns:
            ``(B, 3, 112, 112)`` float32, srgb, [0, 1], and ``(B, 3, S, S)``, px of these.
        """
        with torch.autocast(crops.device.type, enabled=False):  # 8 bits of a picture, not of bf16
            faces = self.blur(self.occlusion(self.background(crops.float() / 255, rng), rng), rng)
            moved = self.misalignment.matrices(len(faces), TEMPLATE_IPD_PX, rng)
            faces = warp(faces, moved, size_px=CROP_PX, antialias=False, outside="border")
            faces = expose(faces, self.colour, self.noise, rng)
            matrices = torch.from_numpy(moved).to(maps)
            scales = torch.linalg.det(matrices[:, :, :2]).sqrt()[:, None, None]
            places = torch.einsum("bij,bjhw->bihw", matrices[:, :, :2], maps[:, :2])
            places = places + matrices[:, :, 2, None, None]
            maps = torch.cat([places, (maps[:, 2] * scales)[:, None]], dim=1)
            mirrored = torch.from_numpy(np.flatnonzero(rng.random(len(faces)) < 0.5))
            faces[mirrored] = faces[mirrored].flip(-1)
            maps[mirrored] = _mirror(maps[mirrored])
        return faces, maps


def _mirror(maps: torch.Tensor) -> torch.Tensor:
    """Return the maps ``(B, 3, S, S)``, px, of mirrored crops.

    Example:
        >>> two = torch.tensor([[[[10.0, 100.0]], [[50.0, 51.0]], [[2.0, 3.0]]]])
        >>> _mirror(two)[0, :, 0].tolist()
        [[11.0, 101.0], [51.0, 50.0], [3.0, 2.0]]
    """
    turned = maps.flip(-1)
    turned[:, 0] = CROP_PX - 1 - turned[:, 0]
    return turned
