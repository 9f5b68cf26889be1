"""What does a method make of several frames of a probe? One picture, or one row of numbers."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import torch
from numpy.typing import NDArray

from lrsr.configuration import as_mapping, as_word, once, require, whole_numbers, words
from lrsr.images import scale_points
from lrsr.pictures.picture import Picture, stack, stack_bursts
from lrsr.presets import build, node_of, value_of
from lrsr.sr.fusion import BurstUpscaler
from lrsr.sr.upscaler import Upscaler

if TYPE_CHECKING:
    from omegaconf import DictConfig

_Floats = NDArray[np.floating[Any]]
_Pooling = Literal["mean", "best"]
_POOLINGS = ("mean", "best")


@dataclass(frozen=True)
class Several(ABC):
    """A method that takes the first N frames of a burst.

    Attributes:
        frames: N, at least 1.
        upscaler: Enlarges single pictures.
        alone: Name of the method that is this one with one frame.
    """

    frames: int
    upscaler: Upscaler
    alone: str

    def __post_init__(self) -> None:
        require(self.frames >= 1, "frames", self.frames, "at least 1")

    @property
    @abstractmethod
    def label(self) -> str:
        """Its name in tables."""

    @property
    @abstractmethod
    def scale(self) -> int:
        """New size over old."""

    @property
    def needs_detector(self) -> bool:
        """Does it choose by what a face detector says?"""
        return False

    @property
    def learned(self) -> bool:
        """Did a part of it learn from pictures?"""
        return self.upscaler.learned

    @abstractmethod
    def see(
        self, srgb: torch.Tensor, landmarks_px: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor]:
        """Return what is to be embedded, M views of each burst, and landmarks not scaled yet.

        Args:
            srgb: ``(B, N, 3, H, W)``.
            landmarks_px: ``(B, N, 5, 2)``, true ones.

        Returns:
            ``(B, M, 3, scale * H, scale * W)`` and ``(B, M, 5, 2)``.
        """

    @abstractmethod
    def pool(self, rows: _Floats, scores: _Floats) -> _Floats:
        """Return one row ``(B, D)`` for the rows ``(B, M, D)`` of the views of each burst.

        Args:
            rows: Of a recogniser; NaN: no face was found.
            scores: ``(B, M)`` of the detector; NaN where it found none or did not look.
        """

    def describe(self) -> dict[str, object]:
        """Return what a report must say of it."""
        return {"label": self.label, "scale": self.scale, "frames": self.frames}


@dataclass(frozen=True)
class Fused(Several):
    """Frames become one picture, which may be enlarged further.

    Attributes:
        fusion: Makes the picture.
    """

    fusion: BurstUpscaler

    @property
    def label(self) -> str:
        """Its name in tables."""
        return _label(self.fusion.label, self)

    @property
    def scale(self) -> int:
        """New size over old."""
        return self.fusion.scale * self.upscaler.scale

    @property
    def learned(self) -> bool:
        """Did a part of it learn from pictures?"""
        return self.fusion.learned or self.upscaler.learned

    def see(
        self, srgb: torch.Tensor, landmarks_px: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor]:
        """Return the one picture, which shows the first frame; see :class:`Several`."""
        fused = self.fusion(srgb, landmarks_px)
        return self.upscaler(fused)[:, None], landmarks_px[:, :1]

    def pool(self, rows: _Floats, scores: _Floats) -> _Floats:
        """Return the row of the one picture."""
        return rows[:, 0]

    def describe(self) -> dict[str, object]:
        """Return what a report must say of it."""
        parts = {"fusion": self.fusion.describe(), "upscaler": self.upscaler.describe()}
        return super().describe() | parts


@dataclass(frozen=True)
class Pooled(Several):
    """Each frame is recognised by itself, and what was recognised is put together.

    Attributes:
        pooling: "mean": of the rows of all frames on which a face was found, as long as those are
            on average (1 for embeddings); "best": the row of the frame that the detector is surest
            of, the first where it found no face at all.
        name: In tables.
    """

    pooling: _Pooling
    name: str

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self.pooling in _POOLINGS, "pooling", self.pooling, "mean or best")

    @property
    def label(self) -> str:
        """Its name in tables."""
        return _label(self.name, self)

    @property
    def scale(self) -> int:
        """New size over old."""
        return self.upscaler.scale

    @property
    def needs_detector(self) -> bool:
        """Does it choose by what a face detector says?"""
        return self.pooling == "best" and self.frames > 1

    def see(
        self, srgb: torch.Tensor, landmarks_px: torch.Tensor
    ) -> tuple[torch.Tensor, torch.Tensor]:
        """Return every frame, enlarged by itself; see :class:`Several`."""
        larger = self.upscaler(srgb.flatten(0, 1))
        return larger.reshape(*srgb.shape[:2], *larger.shape[1:]), landmarks_px

    def pool(self, rows: _Floats, scores: _Floats) -> _Floats:
        """Put rows together; see :class:`Several`."""
        if self.pooling == "best":
            return rows[surest(scores)]
        found = np.isfinite(rows).all(axis=2, keepdims=True)
        known = np.where(found, rows, 0.0)
        total, count = known.sum(axis=1), found.sum(axis=1)
        lengths = np.linalg.norm(known, axis=2).sum(axis=1, keepdims=True)
        length = np.linalg.norm(total, axis=1, keepdims=True)
        nothing = np.full_like(total, np.nan)
        kept = (count > 0) & (length > 0)
        pooled: _Floats = np.divide(total * lengths, length * count, out=nothing, where=kept)
        return pooled

    def describe(self) -> dict[str, object]:
        """Return what a report must say of it."""
        parts = {"pooling": self.pooling, "upscaler": self.upscaler.describe()}
        return super().describe() | parts


def see(
    method: Upscaler | Several, pictures: Sequence[Picture]
) -> tuple[torch.Tensor, torch.Tensor]:
    """Return a method's views ``(B, M, 3, H, W)`` of pictures, and their landmarks in them.

    Args:
        method: Takes one picture, or bursts; then M may be more than 1.
        pictures: Of one size.

    Raises:
        InputError: A burst has too few frames.
    """
    if isinstance(method, Several):
        views, points = method.see(*stack_bursts(pictures, method.frames))
    else:
        images, points = stack(pictures)
        views, points = method(images)[:, None], points[:, None]
    return views, scale_points(points, method.scale)


def surest(scores: _Floats) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the index of the highest score of each row of ``(B, M)``; the first where all are NaN.

    Example:
        >>> surest(np.array([[0.1, np.nan, 0.7], [np.nan, np.nan, np.nan]]))[1].tolist()
        [2, 0]
    """
    best = np.where(np.isnan(scores), -np.inf, scores).argmax(axis=1)
    return np.arange(len(scores)), best


def read_several(config: "DictConfig") -> dict[str, Upscaler | Several]:
    """Read the methods of several frames: each of ``fusions`` with each of ``frames``.

    Raises:
        InputError: A value is wrong, or a setting would not be read.
    """
    from omegaconf import OmegaConf

    as_mapping(config.fusion, "fusion")
    changes: Any = OmegaConf.to_container(config.fusion, resolve=True)
    names = once(words(config, "fusions"), "fusions")
    frames = once(whole_numbers(config, "frames"), "frames")
    for name, settings in changes.items():
        as_mapping(settings, f"fusion.{name}")
        require(name in names, "fusions", names, f"{name} among them, as fusion.{name} is given")
    require(bool(names) or frames == [1], "frames", frames, "fusions=[...] besides, or 1 alone")
    require(bool(frames) or not names, "frames", frames, "at least one number, such as [1,4]")
    return {
        f"{name}_{count}": _read(name, count, dict(changes.get(name, {})))
        for name in names
        for count in frames
    }


def _read(name: str, frames: int, changes: dict[str, Any]) -> Several:
    like = as_word(changes.pop("like", name), f"fusion.{name}.like")
    node = node_of("fusion", like, changes)
    upscaler = value_of("sr", node.pop("upscaler"))
    more = {"frames": frames, "upscaler": upscaler, "alone": f"{name}_1"}
    method: Several = build(node, f"fusion.{name}", **more)
    return method


def _label(name: str, method: Several) -> str:
    after = "" if method.upscaler.scale == 1 else f" + {method.upscaler.label}"
    return f"{name} of {method.frames}{after}"
