"""How does a sharp face become what a surveillance camera delivers, many times a second?

For training only: the true pipeline renders small faces, but a renderer makes one or two a second
and training wants hundreds. So sharp aligned faces are made small, dim, noisy and compressed here,
and enlarged again as alignment does it.
"""

from dataclasses import dataclass
from functools import partial

import numpy as np
import torch
import torch.nn.functional as F
from numpy.typing import NDArray

from lrsr.camera.codec import jpeg
from lrsr.configuration import settle
from lrsr.images import resize_bicubic
from lrsr.recognition.alignment import CROP_PX, TEMPLATE_PX, warp

_TEMPLATE_IPD_PX = float(np.linalg.norm(TEMPLATE_PX[1] - TEMPLATE_PX[0]))
"""Distance of the eyes in the aligned face: 35.24 px."""

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
        gain: Standard deviation of the logarithm of the brightness.
        tint: Standard deviation of the logarithm of each colour's brightness.
        contrast: Standard deviation of the logarithm of the contrast about the mean.
        jitter: Standard deviation of the errors of alignment: shift over the IPD, relative size,
            roll in radians.
        group: Faces that share one size, kernel and quality.
    """

    ipd_px: tuple[float, float] = (6.0, 32.0)
    small_share: float = 0.65
    bicubic_share: float = 0.5
    jpeg_share: float = 0.5
    jpeg_quality: tuple[int, int] = (10, 95)
    noise: float = 0.03
    gain: float = 0.15
    tint: float = 0.03
    contrast: float = 0.15
    jitter: float = 0.02
    group: int = 16

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            InputError: One is none.
        """
        settle(self, "module.degradation")

    def __call__(
        self, crops: torch.Tensor, sharp: torch.Tensor, rng: np.random.Generator
    ) -> torch.Tensor:
        """Degrade a batch; the same ``rng`` state gives the same result.

        Args:
            crops: ``(B, 3, 112, 112)`` uint8, srgb.
            sharp: ``(B,)`` bool; the others are shifted, tinted and mirrored only.
            rng: Source of every choice.

        Returns:
            ``(B, 3, 112, 112)`` float32, srgb, [0, 1].
        """
        faces = crops.float() / 255
        result = torch.empty_like(faces)
        smaller = sharp.numpy(force=True) & (rng.random(len(faces)) < self.small_share)
        kept = np.flatnonzero(~smaller)
        if len(kept):
            rows = torch.from_numpy(kept)
            jitter = self._jitter(len(kept), rng)
            result[rows] = _crop(self._expose(faces[rows], rng), jitter)
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
        side = max(round(CROP_PX * float(np.exp(rng.uniform(low, high))) / _TEMPLATE_IPD_PX), 8)
        factor = CROP_PX / side
        phase = np.tile(np.eye(2, 3), (len(faces), 1, 1))  # where the pixel grid meets the face
        phase[:, :, 2] = rng.uniform(-0.5, 0.5, (len(faces), 2)) * factor
        shifted = _crop(faces, phase)
        small = F.interpolate(shifted, size=(side, side), mode="bilinear", antialias=True)
        small = self._expose(small, rng)
        if rng.random() < self.jpeg_share:
            small = jpeg(small, int(rng.integers(self.jpeg_quality[0], self.jpeg_quality[1] + 1)))
        if rng.random() < self.bicubic_share:
            by = int(rng.choice((2, 4)))
            small, factor = resize_bicubic(small, by).clamp(0, 1), factor / by
        back = np.zeros((len(faces), 3, 3))
        back[:, 0, 0] = back[:, 1, 1] = factor
        back[:, :2, 2] = (factor - 1) / 2 - phase[:, :, 2]
        back[:, 2, 2] = 1
        return _crop(small, self._jitter(len(faces), rng) @ back)

    def _expose(self, faces: torch.Tensor, rng: np.random.Generator) -> torch.Tensor:
        """Change brightness, colour and contrast, add noise, round to 8 bits."""
        count = len(faces)

        def a_face(values: NDArray[np.float64]) -> torch.Tensor:
            return torch.from_numpy(values.reshape(count, -1, 1, 1)).to(faces)

        gain = rng.normal(0, self.gain, (count, 1)) + rng.normal(0, self.tint, (count, 3))
        contrast = rng.normal(0, self.contrast, count)
        sigma = rng.uniform(0, self.noise, count)
        noise = torch.from_numpy(rng.standard_normal(tuple(faces.shape), dtype=np.float32))
        bright = faces * a_face(np.exp(gain))
        mean = bright.mean(dim=(1, 2, 3), keepdim=True)
        exposed = (bright - mean).mul_(a_face(np.exp(contrast))).add_(mean)
        exposed = exposed.addcmul_(noise.to(faces), a_face(sigma))
        return exposed.clamp_(0, 1).mul_(255).round_().div_(255)

    def _jitter(self, count: int, rng: np.random.Generator) -> NDArray[np.float64]:
        """Draw small similarities about the crop's centre, ``(count, 2, 3)``."""
        size = np.exp(rng.normal(0, self.jitter, count))
        roll = rng.normal(0, self.jitter, count)
        shift = rng.normal(0, self.jitter * _TEMPLATE_IPD_PX, (count, 2))
        cosine, sine = size * np.cos(roll), size * np.sin(roll)
        linear = np.stack([np.stack([cosine, -sine], -1), np.stack([sine, cosine], -1)], axis=1)
        centre = np.full(2, (CROP_PX - 1) / 2)
        moved = centre - np.einsum("bij,j->bi", linear, centre) + shift
        return np.concatenate([linear, moved[:, :, None]], axis=2)
