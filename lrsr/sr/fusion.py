"""How does a burst of small frames become one larger picture? Laid over each other, and fused."""

from abc import ABC, abstractmethod
from typing import Protocol

import numpy as np
import torch

from lrsr.configuration import as_number, as_whole, require
from lrsr.errors import ImageContractError
from lrsr.images import check_images, check_srgb, scale_points
from lrsr.resampling import bicubic_matrix, sample_bicubic
from lrsr.sr.registration import Correlation, Registration
from lrsr.sr.tiles import check_size
from lrsr.sr.upscaler import blaming_weights
from lrsr.sr.weights import LARGEST_SCALE


class BurstUpscaler(Protocol):
    """Makes one larger picture of several frames; see :class:`lrsr.sr.upscaler.Upscaler`.

    Attributes:
        label: Its name in tables.
        scale: New size over old.
        learned: Did it learn from pictures?
    """

    label: str
    scale: int
    learned: bool

    def __call__(
        self, srgb: torch.Tensor, landmarks_px: torch.Tensor | None = None
    ) -> torch.Tensor:
        """Make ``(B, 3, scale * H, scale * W)`` of ``(B, N, 3, H, W)`` srgb in [0, 1].

        It shows what the first frame shows, clipped to [0, 1]. No gradient is kept.

        Args:
            srgb: Bursts of N frames, N >= 1.
            landmarks_px: ``(B, N, P, 2)``, (x, y) px, for a registration that needs them.
        """

    def describe(self) -> dict[str, object]:
        """Return what a report must say of it: label, scale, kind, registration, ..."""


class Registering(ABC):
    """What every fusion shares: the contract at both ends, registration, batches."""

    learned = False
    about: dict[str, object]
    _kind: str
    _batch_size = 16

    def __init__(self, scale: int, registration: Registration | None, label: str) -> None:
        scale = as_whole(scale, "scale")
        require(1 <= scale <= LARGEST_SCALE, "scale", scale, f"1 to {LARGEST_SCALE}")
        self.label, self.scale = label, scale
        self._register = registration or Correlation()
        self.about = {}

    @torch.no_grad()
    def __call__(
        self, srgb: torch.Tensor, landmarks_px: torch.Tensor | None = None
    ) -> torch.Tensor:
        """Fuse; see :class:`BurstUpscaler`.

        Raises:
            ImageContractError: The bursts break the contract or lie outside [0, 1], or there are no
                landmarks although the registration needs them.
            InputError: A network returned a NaN or an infinity.
        """
        if not isinstance(srgb, torch.Tensor) or srgb.ndim != 5 or 0 in srgb.shape:
            got = f"{type(srgb).__name__} {tuple(getattr(srgb, 'shape', ()))}"
            raise ImageContractError(f"bursts: got {got}, wanted a torch.Tensor (B, N, 3, H, W)")
        check_srgb(srgb.flatten(0, 1), name="bursts", may_need_gradient=True)
        motions = self._register(srgb.detach(), landmarks_px)
        parts = []
        few = (torch.split(both, self._batch_size) for both in (srgb.detach(), motions))
        for frames, moved in zip(*few, strict=True):
            with blaming_weights(self.label, self.about):
                larger = check_images(self._fuse(frames, moved), name=self.label)
            check_size(larger, frames[:, 0], self.scale, self.label)
            parts.append(larger.clamp(0.0, 1.0))
        return torch.cat(parts)

    @abstractmethod
    def _fuse(self, frames: torch.Tensor, motions: torch.Tensor) -> torch.Tensor:
        """Fuse ``(B, N, 3, H, W)``, which motions ``(B, N, 2, 3)`` lay over the first."""

    def describe(self) -> dict[str, object]:
        """Return label, scale, kind and registration."""
        about = {"label": self.label, "scale": self.scale, "kind": self._kind}
        return {**about, "registration": self._register.describe()}


class Mean(Registering):
    """The mean of all frames, each looked at bicubically where the first one's points are.

    Of one frame that is the bicubic. Where a frame does not reach, it does not count; a frame that
    could not be registered counts nowhere.

    Args:
        scale: New size over old, 1 to 16.
        registration: Default: by correlation.
        label: Its name in tables.

    Raises:
        InputError: The scale is out of range.

    Example:
        >>> Mean(2)(torch.full((1, 4, 3, 8, 6), 0.5)).shape
        torch.Size([1, 3, 16, 12])
    """

    _kind = "mean"

    def __init__(
        self, scale: int, registration: Registration | None = None, label: str = "Mean"
    ) -> None:
        super().__init__(scale, registration, label)

    def _fuse(self, frames: torch.Tensor, motions: torch.Tensor) -> torch.Tensor:
        return lay_over(frames, motions, self.scale).nanmean(dim=1)


class ShiftAndAdd(Registering):
    """The picture that, seen as the camera sees, is nearest to all frames by the sum of deviations.

    Farsiu, Robinson, Elad and Milanfar, "Fast and robust multiframe super resolution", IEEE TIP
    13(10), 2004, section II-E: steepest descent on ::

        sum_k |D H F_k X - Y_k| / N  +  weight * sum_{l, m} decay^(|l| + |m|) |X - S_x^l S_y^m X|

    with l from -reach to reach, m from 0 to reach, l + m >= 0: F_k moves, H blurs, D takes every
    scale-th pixel, S shifts by a pixel; all norms are L1, so that neither a bad frame nor an edge
    weighs more than its sign. Two things are our own: blur comes before motion (they commute, but
    for the growth of an affine one), and steps shrink linearly to nothing. Colours are fused one by
    one, in srgb. The descent begins at the median of the registered frames.

    Args:
        scale: New size over old, 1 to 16.
        registration: Default: by correlation.
        label: Its name in tables.
        blur_px: Standard deviation of the camera's Gaussian, px of a frame, > 0.
        weight: Of the bilateral total variation, >= 0.
        decay: Of its terms by distance, 0 to 1.
        reach: Its farthest neighbour, px, 1 to 4.
        iterations: Steps, >= 1.
        step: The first step's length, srgb.

    Raises:
        InputError: A number is out of range.
    """

    _kind = "shift and add, L1 with bilateral total variation"

    def __init__(
        self,
        scale: int,
        registration: Registration | None = None,
        label: str = "Shift-add",
        *,
        blur_px: float = 0.5,
        weight: float = 0.05,
        decay: float = 0.6,
        reach: int = 2,
        iterations: int = 50,
        step: float = 0.02,
    ) -> None:
        super().__init__(scale, registration, label)
        self.blur_px, self.weight = as_number(blur_px, "blur_px"), as_number(weight, "weight")
        self.decay, self.step = as_number(decay, "decay"), as_number(step, "step")
        self.reach, self.iterations = as_whole(reach, "reach"), as_whole(iterations, "iterations")
        require(0 < self.blur_px <= 4, "blur_px", blur_px, "above 0, at most 4")
        require(self.weight >= 0, "weight", weight, "0 or more")
        require(0 <= self.decay <= 1, "decay", decay, "0 to 1")
        require(0 < self.step <= 1, "step", step, "above 0, at most 1")
        require(1 <= self.reach <= 4, "reach", reach, "1 to 4")
        require(self.iterations >= 1, "iterations", iterations, "at least 1")

    def _fuse(self, frames: torch.Tensor, motions: torch.Tensor) -> torch.Tensor:
        picture = lay_over(frames, motions, self.scale).nanquantile(0.5, dim=1)
        there = motions.isfinite().all(dim=(-2, -1))
        places = pixels_through(_inverse(motions), (frames.shape[-2], frames.shape[-1]))
        share = self.scale**2 * there / there.sum(dim=1, keepdim=True)
        fused = [
            self._descend(*burst)
            for burst in zip(picture, frames, scale_points(places, self.scale), share, strict=True)
        ]
        return torch.stack(fused)

    def _descend(
        self,
        picture: torch.Tensor,
        frames: torch.Tensor,
        places: torch.Tensor,
        share: torch.Tensor,
    ) -> torch.Tensor:
        """Go down from a picture ``(3, h, w)``.

        Both terms are sums of absolute values, and their slopes the signs of what is added up. A
        frame pixel spreads over scale² pixels of the picture: times that, which ``share`` holds,
        both terms move a pixel by about 1.

        Args:
            picture: Where to begin.
            frames: ``(N, 3, H, W)``.
            places: ``(N, H, W, 2)`` where the pixels of each lie in the picture.
            share: ``(N,)`` of each frame.
        """
        height, width = picture.shape[-2:]
        reaches = share > 0
        look = bicubic_matrix(places[reaches].reshape(-1, 2), height, width)
        shown = frames[reaches].movedim(1, -1)
        seen = shown.reshape(-1, 3).numpy()
        pulls = share[reaches, None, None].expand(shown.shape[:-1]).reshape(-1, 1).numpy()
        pull = look.multiply(pulls).T.tocsr()
        down, right = (_blur_matrix(size, self.blur_px * self.scale) for size in (height, width))
        for number in range(self.iterations):
            blurred = (down @ picture @ right.T).movedim(0, -1).reshape(-1, 3).numpy()
            found = torch.from_numpy(pull @ np.sign(look @ blurred - seen))
            found = found.reshape(height, width, 3).movedim(-1, 0)
            slope = down.T @ found @ right + self.weight * self._variation(picture)
            picture = picture - self.step * (1 - number / self.iterations) * slope
        return picture

    def _variation(self, picture: torch.Tensor) -> torch.Tensor:
        """Return the slope of the bilateral total variation."""
        height, width = picture.shape[-2:]
        slope = torch.zeros_like(picture)
        for right in range(-self.reach, self.reach + 1):
            for down in range(self.reach + 1):
                if right + down < 0 or right == down == 0:
                    continue
                here = ..., slice(down, None), slice(max(0, right), width + min(0, right))
                there = ..., slice(height - down), slice(max(0, -right), width - max(0, right))
                signs = (picture[here] - picture[there]).sign_()
                signs *= self.decay ** (abs(right) + down)
                slope[here] += signs
                slope[there] -= signs
        return slope

    def describe(self) -> dict[str, object]:
        """Return all of its settings."""
        names = ("blur_px", "weight", "decay", "reach", "iterations", "step")
        return {**super().describe(), **{name: getattr(self, name) for name in names}}


def lay_over(frames: torch.Tensor, motions: torch.Tensor, scale: int) -> torch.Tensor:
    """Look at every frame where the points of the first one are, on a grid ``scale`` times finer.

    Args:
        frames: ``(B, N, 3, H, W)``.
        motions: ``(B, N, 2, 3)`` of :class:`lrsr.sr.registration.Registration`.
        scale: New size over old.

    Returns:
        ``(B, N, 3, scale * H, scale * W)``; NaN where a frame does not reach or is not registered.
    """
    height, width = frames.shape[-2:]
    points = pixels_through(motions, (scale * height, scale * width), scale)
    edge = points.new_tensor([width, height]) - 0.5
    inside = ((points >= -0.5) & (points <= edge)).all(dim=-1)
    known = points.nan_to_num().flatten(0, 1)[:, None]
    looked = sample_bicubic(frames.flatten(0, 1), known)
    looked = looked.reshape(*frames.shape[:3], *looked.shape[-2:])
    return looked.masked_fill(~inside[:, :, None], torch.nan)


def pixels_through(motions: torch.Tensor, size: tuple[int, int], finer: int = 1) -> torch.Tensor:
    """Return where motions take the pixels of a grid, ``(B, N, h, w, 2)``.

    Args:
        motions: ``(B, N, 2, 3)``.
        size: (height, width) of the grid.
        finer: How many times finer than the motions' pixels the grid is.
    """
    rows, columns = (torch.arange(length, dtype=torch.float32) for length in size)
    grid = torch.stack(torch.meshgrid(columns, rows, indexing="xy"), dim=-1)
    points = scale_points(grid, 1 / finer)
    turned: torch.Tensor = torch.einsum("bnij,hwj->bnhwi", motions[..., :2], points)
    return turned + motions[..., None, None, :, 2]


def _inverse(motions: torch.Tensor) -> torch.Tensor:
    """Return the way back; a frame that is not registered stays where it is."""
    still = torch.eye(2, 3).expand_as(motions)
    known = torch.where(motions.isfinite().all(dim=(-2, -1), keepdim=True), motions, still)
    turn = torch.linalg.inv(known[..., :2])
    return torch.cat([turn, -turn @ known[..., 2:]], dim=-1)


def _blur_matrix(length: int, stddev_px: float) -> torch.Tensor:
    """Return ``(length, length)``: a Gaussian, cut at four standard deviations; edges repeat."""
    reach = max(1, round(4 * stddev_px))
    steps = torch.arange(-reach, reach + 1)
    kernel = torch.exp(-0.5 * (steps / stddev_px) ** 2)
    rows = torch.arange(length)[:, None]
    columns = (rows + steps).clamp(0, length - 1)
    weights = (kernel / kernel.sum()).expand(length, -1)
    return torch.zeros(length, length).scatter_add(1, columns, weights)
