"""How does a sharp face become what a surveillance camera delivers, many times a second?

For training only: the true pipeline renders small faces, but a renderer makes one or two a second
and training wants hundreds. So sharp aligned faces are made small, dim, noisy and compressed here,
and enlarged again as alignment does it. :mod:`lrsr.training.augmentation` does the rest.
"""

from dataclasses import dataclass, field
from functools import partial

import numpy as np
import torch
import torch.nn.functional as F
from numpy.typing import NDArray

from lrsr.camera.codec import jpeg
from lrsr.images import resize_bicubic
from lrsr.recognition.alignment import CROP_PX, TEMPLATE_IPD_PX, warp
from lrsr.training.augmentation.background import Background
from lrsr.training.augmentation.blur import Blur
from lrsr.training.augmentation.colour import Colour
from lrsr.training.augmentation.misalignment import Misalignment
from lrsr.training.augmentation.occlusion import Occlusion
from lrsr.training.augmentation.ranges import SHARE, check_ranges

_SMALL_PX = 10.0
"""IPD that small renderings are taken to have when their landmarks are found."""

_crop = partial(warp, size_px=CROP_PX, antialias=False, outside="border")


@dataclass(frozen=True)
class Degradation:
    """What training does to faces; every number is the width of a random choice.

    Attributes:
        ipd_px: Lowest and highest IPD that a sharp face is made to have, log-uniform, px.
        small_share: How many of the sharp faces are made smaller.
        bicubic_share: How many of those are enlarged bicubically by 2 or 4 before alignment.
        jpeg_share: How many of those are compressed.
        jpeg_quality: Lowest and highest quality.
        noise: Highest standard deviation of the noise, of 1 = white.
        group: Faces that share one size and quality.
        background: Behind sharp faces.
        occlusion: Of sharp faces.
        blur: Of sharp faces.
        colour: Of all faces.
        misalignment: Of all faces.

    Raises:
        InputError: A number is out of its range.
    """

    ipd_px: tuple[float, float] = (6.0, 32.0)
    small_share: float = 0.65
    bicubic_share: float = 0.5
    jpeg_share: float = 0.5
    jpeg_quality: tuple[int, int] = (10, 95)
    noise: float = 0.0
    group: int = 16
    background: Background = field(default_factory=Background)
    occlusion: Occlusion = field(default_factory=Occlusion)
    blur: Blur = field(default_factory=Blur)
    colour: Colour = field(default_factory=Colour)
    misalignment: Misalignment = field(default_factory=Misalignment)

    def __post_init__(self) -> None:
        shares = dict.fromkeys(("small_share", "bicubic_share", "jpeg_share", "noise"), SHARE)
        sizes = {"ipd_px": (1.0, TEMPLATE_IPD_PX), "jpeg_quality": (1, 100), "group": (1, 4096)}
        check_ranges(self, "degradation", shares | sizes, spans=["ipd_px", "jpeg_quality"])

    def __call__(
        self, crops: torch.Tensor, sharp: torch.Tensor, rng: np.random.Generator
    ) -> torch.Tensor:
        """Degrade a batch; the same ``rng`` state gives the same result.

        Args:
            crops: ``(B, 3, 112, 112)`` uint8, srgb.
            sharp: ``(B,)`` bool; the others are recoloured, misaligned and mirrored only.
            rng: Source of every choice.

        Returns:
            ``(B, 3, 112, 112)`` float32, srgb, [0, 1].
        """
        with torch.autocast(crops.device.type, enabled=False):  # 8 bits of a picture, not of bf16
            return self._degrade(crops.float() / 255, sharp.numpy(force=True), rng)

    def _degrade(
        self, faces: torch.Tensor, is_sharp: NDArray[np.bool_], rng: np.random.Generator
    ) -> torch.Tensor:
        if is_sharp.any():
            rows = torch.from_numpy(np.flatnonzero(is_sharp))
            shown = self.occlusion(self.background(faces[rows], rng), rng)
            faces[rows] = self.blur(shown, rng)
        result = torch.empty_like(faces)
        smaller = is_sharp & (rng.random(len(faces)) < self.small_share)
        for kept, ipd_px in ((is_sharp & ~smaller, TEMPLATE_IPD_PX), (~is_sharp, _SMALL_PX)):
            rows = torch.from_numpy(np.flatnonzero(kept))
            if len(rows):
                moved = self.misalignment.matrices(len(rows), ipd_px, rng)
                result[rows] = _crop(expose(faces[rows], self.colour, self.noise, rng), moved)
        chosen = np.flatnonzero(smaller)
        for start in range(0, len(chosen), self.group):
            rows = torch.from_numpy(chosen[start : start + self.group])
            result[rows] = self._make_small(faces[rows], rng)
        mirrored = torch.from_numpy(rng.random(len(faces)) < 0.5)
        result[mirrored] = result[mirrored].flip(-1)
        return result

    def _make_small(self, faces: torch.Tensor, rng: np.random.Generator) -> torch.Tensor:
        """Shrink, expose, compress, enlarge: one size and one codec for the group."""
        low, high = np.log(self.ipd_px)
        side = max(round(CROP_PX * float(np.exp(rng.uniform(low, high))) / TEMPLATE_IPD_PX), 8)
        factor = CROP_PX / side
        phase = np.tile(np.eye(2, 3), (len(faces), 1, 1))  # where the pixel grid meets the face
        phase[:, :, 2] = rng.uniform(-0.5, 0.5, (len(faces), 2)) * factor
        shifted = _crop(faces, phase)
        small = F.interpolate(shifted, size=(side, side), mode="bilinear", antialias=True)
        small = expose(small, self.colour, self.noise, rng)
        if rng.random() < self.jpeg_share:
            small = jpeg(small, int(rng.integers(self.jpeg_quality[0], self.jpeg_quality[1] + 1)))
        if rng.random() < self.bicubic_share:
            by = int(rng.choice((2, 4)))
            small, factor = resize_bicubic(small, by).clamp(0, 1), factor / by
        back = np.zeros((len(faces), 3, 3))
        back[:, 0, 0] = back[:, 1, 1] = factor
        back[:, :2, 2] = (factor - 1) / 2 - phase[:, :, 2]
        back[:, 2, 2] = 1
        moved = self.misalignment.matrices(len(faces), TEMPLATE_IPD_PX * side / CROP_PX, rng)
        return _crop(small, moved @ back)


def expose(
    faces: torch.Tensor, colour: Colour, noise: float, rng: np.random.Generator
) -> torch.Tensor:
    """Recolour faces, add noise, round to 8 bits.

    Args:
        faces: ``(B, 3, H, W)``, srgb, [0, 1].
        colour: How they are recoloured.
        noise: Highest standard deviation, of 1 = white.
        rng: Source of every choice.

    Returns:
        The same shape, srgb, [0, 1].
    """
    sigma = torch.from_numpy(rng.uniform(0, noise, (len(faces), 1, 1, 1))).to(faces)
    drawn = torch.from_numpy(rng.standard_normal(tuple(faces.shape), dtype=np.float32))
    exposed = colour(faces, rng).addcmul(drawn.to(faces), sigma)
    return exposed.clamp_(0, 1).mul_(255).round_().div_(255)
