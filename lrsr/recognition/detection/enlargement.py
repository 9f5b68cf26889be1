"""How is a tiny picture made large enough for a detector to see the face on it?

Of 20 rendered faces with 8 px between the eyes the shipped RetinaFace finds 7, and from twice to
eight times larger all of them, the landmarks 0.09 distances of the eyes off. So a picture gets a
border of its own edge pixels (a black one costs detections) and is enlarged bicubically
(:func:`lrsr.images.resize_bicubic`), by a whole factor: a portrait, whose size says how large its
face is, until its shorter side is long enough; a frame on which faces are known to be small, until
these are.
"""

import math
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch.nn import functional as F

from lrsr.configuration import require, settle
from lrsr.images import resize_bicubic

_FACE_IPDS = 4


@dataclass(frozen=True)
class Enlargement:
    """The rule.

    Attributes:
        border: Border on each side, as a share of the picture's height or width; its pixels are
            those of the edge. Where faces are known to be small, it is at most as wide as one:
            4 distances between the pupils.
        shorter_px: The shorter side, without border, is enlarged by the least whole factor that
            makes it at least so long; 4 IPDs wide, as our renderings are, it holds 64 px.
        ipd_px: The same of the distance between the pupils, where that is known; then the sides
            do not matter.
        longest_px: The longer side with its border is not enlarged beyond this, and what is longer
            is shrunk, by the least whole factor that makes it fit.

    Raises:
        InputError: A number is out of its range.
    """

    border: float = 0.25
    shorter_px: int = 256
    ipd_px: float = 48.0
    longest_px: int = 4096

    def __post_init__(self) -> None:
        settle(self, "recognition.enlargement")
        for name, least in (("border", 0), ("shorter_px", 1), ("ipd_px", 1), ("longest_px", 64)):
            value = getattr(self, name)
            require(value >= least, f"recognition.enlargement.{name}", value, f"at least {least}")
        require(self.border <= 2, "recognition.enlargement.border", self.border, "at most 2")

    def factor(self, height: int, width: int, ipd_px: float | None = None) -> float:
        """Return how many times a picture is enlarged: a whole number, or one over one.

        Args:
            height: Of the picture, px.
            width: Of the picture, px.
            ipd_px: Of the faces on it, where that is known.

        Example:
            >>> rule = Enlargement()
            >>> [rule.factor(side, side) for side in (32, 64, 90, 256)]
            [8, 4, 3, 1]
            >>> rule.factor(240, 320, ipd_px=8), rule.factor(6000, 4000)
            (6, 0.3333333333333333)
        """
        longer = max(height, width)
        longer += 2 * self._border_px(longer, ipd_px)
        if longer > self.longest_px:
            return 1 / math.ceil(longer / self.longest_px)
        size, wanted = (
            (min(height, width), self.shorter_px) if ipd_px is None else (ipd_px, self.ipd_px)
        )
        return max(1, min(math.ceil(wanted / size), self.longest_px // longer))

    def _border_px(self, side: int, ipd_px: float | None) -> int:
        most = math.inf if ipd_px is None else _FACE_IPDS * ipd_px
        return round(min(self.border * side, most))

    def __call__(
        self, srgb: torch.Tensor, *, multiple_px: int = 1, ipd_px: float | None = None
    ) -> tuple[torch.Tensor, "Return"]:
        """Enlarge pictures.

        Args:
            srgb: ``(B, 3, H, W)`` float32, srgb, [0, 1].
            multiple_px: Of which height and width of the result shall be multiples; the right and
                the lower border grow.
            ipd_px: Of the faces on them, where that is known.

        Returns:
            ``(B, 3, H', W')``, [0, 1], and the way back to the picture.
        """
        height, width = srgb.shape[-2:]
        factor = self.factor(height, width, ipd_px)
        across, down = self._border_px(width, ipd_px), self._border_px(height, ipd_px)
        whole = max(1, round(1 / factor))  # pixels of the picture in one of the result
        spare = [-(size + 2 * pad) % whole for size, pad in ((width, across), (height, down))]
        padded = _extend(srgb, across, across + spare[0], down, down + spare[1])
        large = resize_bicubic(padded, factor).clamp(0, 1) if factor != 1 else padded
        rest = [-size % multiple_px for size in large.shape[-2:]]
        return _extend(large, 0, rest[1], 0, rest[0]), Return(factor, across, down)


@dataclass(frozen=True)
class Return:
    """The way back from an enlarged picture: its factor and the border before it, px."""

    factor: float
    left_px: int
    top_px: int

    def __call__(self, points_px: NDArray[np.float32]) -> NDArray[np.float32]:
        """Move points ``(..., 2)``, (x, y), of the enlarged picture onto the picture."""
        moved = (points_px + 0.5) / self.factor - 0.5 - np.array([self.left_px, self.top_px])
        return np.asarray(moved, dtype=np.float32)


def _extend(images: torch.Tensor, left: int, right: int, top: int, bottom: int) -> torch.Tensor:
    """Repeat the edge pixels."""
    if not any((left, right, top, bottom)):
        return images
    return F.pad(images, (left, right, top, bottom), mode="replicate")
