"""What does a network that fuses learn from? Bursts of people, and what the first frame shows."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import radians

import numpy as np
import torch

from lrsr.configuration import as_whole, require
from lrsr.errors import InputError
from lrsr.identities.person import Person
from lrsr.pictures.burst import Burst
from lrsr.pictures.recipe import Recipe
from lrsr.pictures.render import CHUNK
from lrsr.rendering.geometry import FRAME_IPDS
from lrsr.resampling import sample_bicubic
from lrsr.sr.learned_fusion import laid_over
from lrsr.sr.registration import Registration
from lrsr.training.pairs import Pairs
from lrsr.training.patches import Pair
from lrsr.training.patchwork import Batch


@dataclass(frozen=True)
class LaidOver:
    """Every frame where the points of the first one are, and the true picture.

    Attributes:
        registration: Finds where that is, as it will in use.
        frame_px: Side of the square amid the frames that is shown, px of the small picture.

    Raises:
        InputError: The side is no number of pixels, at least 8.

    Example:
        >>> from lrsr.sr.registration import Correlation
        >>> small, true = torch.rand(1, 5, 3, 16, 16), torch.zeros(1, 3, 64, 64)
        >>> [tuple(part.shape) for part in LaidOver(Correlation(), 16).cut(small, true)]
        [(1, 5, 64, 16, 16), (1, 3, 64, 64)]
    """

    registration: Registration
    frame_px: int = 32

    def __post_init__(self) -> None:
        side = as_whole(self.frame_px, "data.patches.frame_px")
        require(side >= 8, "data.patches.frame_px", side, "at least 8")

    def least_px(self, scale: int) -> int:
        """Return how wide the small picture is at least."""
        return self.frame_px

    def cut(
        self,
        lr_srgb: torch.Tensor,
        hr_srgb: torch.Tensor,
        landmarks_px: torch.Tensor | None = None,
    ) -> Pair:
        """Return what :func:`lrsr.sr.learned_fusion.laid_over` makes of bursts, and the target.

        Args:
            lr_srgb: ``(B, N, 3, frame_px, frame_px)``, see :class:`Bursts`.
            hr_srgb: ``(B, 3, scale * frame_px, scale * frame_px)``: what the first frames show.
            landmarks_px: Not looked at.

        Raises:
            InputError: There are single pictures.
        """
        if lr_srgb.ndim != 5:
            raise InputError("patches=laid_over takes bursts: give data=bursts, or other patches")
        scale = hr_srgb.shape[-1] // lr_srgb.shape[-1]
        return laid_over(lr_srgb, self.registration(lr_srgb), scale), hr_srgb


@dataclass(kw_only=True, eq=False)
class Bursts(Pairs):
    """Bursts for training and validation, as large as the patches ask for; see the bases, too.

    Each small frame is made of a fine one by the degradation, with noise of its own: all of a burst
    by one camera, where the degradation draws each for at least as many pictures.

    Attributes:
        burst: How the frames of a person differ.
        frames: Of each burst, at least 1; where they are rendered, a divisor of 64.
        moved: Later frames are the first one's fine film, shifted, turned in its plane and enlarged
            as far as the burst says, anew in each epoch; head and face do not move. False: every
            frame is rendered, with all that moves, at N times the cost.

    Raises:
        InputError: A number is out of its range, or the patches are for single pictures.
    """

    patches: LaidOver
    burst: Burst
    frames: int
    moved: bool

    def __post_init__(self) -> None:
        super().__post_init__()
        self.cameras = []  # every small frame is made of a fine one
        fits = self.frames >= 1 and (self.moved or CHUNK % self.frames == 0)
        wish = f"at least 1, and a divisor of {CHUNK} where moved=false"
        require(fits, "data.frames", self.frames, wish)
        got = type(self.patches).__name__
        require(isinstance(self.patches, LaidOver), "data.patches", got, "patches=laid_over")

    def recipes(self, people: Sequence[Person], film: int) -> list[Recipe]:
        """Return what everybody is rendered as, the frames of a burst one after the other."""
        firsts = super().recipes(people, film)
        return [
            self.burst.frame(first, number, self.seed).seeded(self.seed, "probe", number)
            for first in firsts
            for number in range(1 if self.moved else self.frames)
        ]

    @property
    def redrawn(self) -> bool:
        """Do the bursts differ from epoch to epoch?"""
        return self.moved or self.degradation.redrawn

    @property
    def lr_made_by(self) -> str:
        """How the small frames are made, in words."""
        how = "moved in the picture's plane" if self.moved else "rendered"
        made = self.degradation.in_words(self.camera, of_films=False)
        return f"frames {how}, burst {self.burst.name}; {made}"

    def _shrunk(self, people: Sequence[Person], epoch: int | None) -> Iterator[Batch]:
        """Yield ``(B, N, 3, H, W)`` and the first frames' fine films."""
        start = 0
        for stored, _ in self._sharp(people):
            for several in torch.split(stored, 1 if self.moved else self.frames):
                seeds = self.degradation_seeds(epoch, start, self.frames)
                frames = self._shown(several / 255, seeds[0])
                drawn = self.degradation(frames, self.scale, seeds, self.camera)
                small, true = (torch.cat(parts) for parts in zip(*drawn, strict=True))
                yield small.reshape(-1, self.frames, *small.shape[1:]), true[:: self.frames]
                start += self.frames

    def _shown(self, fine: torch.Tensor, seed: int) -> torch.Tensor:
        """Return the middle of fine frames ``(N, 3, h, w)``, or of one that moves."""
        side, film_px = self.scale * self.patches.frame_px, fine.shape[-1]
        if not self.moved:
            margin = (film_px - side) // 2
            return fine[..., margin : margin + side, margin : margin + side]
        rng = np.random.default_rng([seed, 2])  # [seed, 1] is the degradation's
        drawn = torch.from_numpy(rng.uniform(-1, 1, (self.frames, 4))).float()
        drawn[0] = 0
        shift = drawn[:, :2] * self.burst.shift_ipds * film_px / FRAME_IPDS
        angle = drawn[:, 2] * radians(self.burst.roll_deg)
        growth = 1 + drawn[:, 3] * self.burst.nearer
        cos, sin = angle.cos() / growth, angle.sin() / growth
        turn = torch.stack([cos, sin, -sin, cos], dim=-1).reshape(-1, 2, 2)
        line = torch.arange(side) - (side - 1) / 2
        grid = torch.stack(torch.meshgrid(line, line, indexing="xy"), dim=-1)
        from_middle = grid - shift[:, None, None]
        points = torch.einsum("nij,nhwj->nhwi", turn, from_middle) + (film_px - 1) / 2
        return sample_bicubic(fine.expand(self.frames, -1, -1, -1), points[:, None]).clamp(0, 1)
