"""What does a network see of a pair? Small squares, cut on one grid from both pictures, or faces.

Sizes of Dong et al. 2016 (arXiv:1501.00092, section 4): 33 in, 21 out (the network pads nothing
and loses 6 pixels on each side), stride 14.
"""

from dataclasses import dataclass
from typing import Protocol

import torch

from lrsr.configuration import require, settle
from lrsr.errors import ImageContractError, InputError
from lrsr.images import check_images, luminance, resize_bicubic, scale_points

Pair = tuple[torch.Tensor, torch.Tensor]


class Patches(Protocol):
    """Cuts what a network takes, and what it should return, from a pair of pictures."""

    def least_px(self, scale: int) -> int:
        """Return how wide the small picture is at least."""

    def cut(
        self,
        lr_srgb: torch.Tensor,
        hr_srgb: torch.Tensor,
        landmarks_px: torch.Tensor | None = None,
    ) -> tuple[torch.Tensor, ...]:
        """Return inputs and targets, and what else a loss may ask for, as many of each.

        Args:
            lr_srgb: ``(B, 3, H, W)`` srgb, [0, 1].
            hr_srgb: ``(B, 3, s H, s W)`` srgb, [0, 1]: the same scene on a film s times finer.
            landmarks_px: ``(B, 5, 2)``, (x, y) in px of ``hr_srgb``; NaN: not known.

        Raises:
            ImageContractError: ``hr_srgb`` is not a whole number of times larger, or a picture is
                smaller than a patch.
        """


@dataclass(frozen=True)
class LuminancePatches:
    """Luminance of the enlarged small picture, and of the true one a smaller square amid it.

    Attributes:
        patch_px: Side of an input patch, px of the large picture.
        label_px: Side of a target patch; ``patch_px - label_px`` is even.
        stride_px: From patch to patch.

    Raises:
        InputError: A number is none, or the label is not centred.

    Example:
        >>> small, true = torch.zeros(2, 3, 32, 32), torch.zeros(2, 3, 64, 64)
        >>> [tuple(patches.shape) for patches in LuminancePatches().cut(small, true)]
        [(18, 1, 33, 33), (18, 1, 21, 21)]
    """

    patch_px: int = 33
    label_px: int = 21
    stride_px: int = 14

    def __post_init__(self) -> None:
        settle(self, "data.patches")
        require(self.stride_px > 0, "data.patches.stride_px", self.stride_px, "at least 1")
        if (self.patch_px - self.label_px) % 2 or self.patch_px < self.label_px:
            raise ImageContractError(
                f"data.patches.label_px={self.label_px}: not centred in a patch of {self.patch_px}"
                " px; give an odd number for an odd one, and no more"
            )

    def least_px(self, scale: int) -> int:
        """Return how wide the small picture is at least."""
        return -(-self.patch_px // scale)

    def cut(
        self,
        lr_srgb: torch.Tensor,
        hr_srgb: torch.Tensor,
        landmarks_px: torch.Tensor | None = None,
    ) -> Pair:
        """Return ``(N, 1, patch_px, patch_px)`` and ``(N, 1, label_px, label_px)``."""
        scale = _scale_of(lr_srgb, hr_srgb)
        inputs, targets = resize_bicubic(luminance(lr_srgb), scale), luminance(hr_srgb)
        margin = (self.patch_px - self.label_px) // 2
        height, width = targets.shape[-2:]
        centres = targets[..., margin : height - margin, margin : width - margin]
        return (
            _squares(inputs, self.patch_px, self.stride_px),
            _squares(centres, self.label_px, self.stride_px),
        )


@dataclass(frozen=True)
class RgbPatches:
    """The small picture as it is, and the same square of the true one.

    Attributes:
        patch_px: Side of an input patch, px of the small picture.
        stride_px: From patch to patch.

    Raises:
        InputError: A number is none.

    Example:
        >>> small, true = torch.zeros(2, 3, 32, 32), torch.zeros(2, 3, 64, 64)
        >>> [tuple(patches.shape) for patches in RgbPatches(16, 8).cut(small, true)]
        [(18, 3, 16, 16), (18, 3, 32, 32)]
    """

    patch_px: int = 16
    stride_px: int = 8

    def __post_init__(self) -> None:
        settle(self, "data.patches")
        require(self.stride_px > 0, "data.patches.stride_px", self.stride_px, "at least 1")

    def least_px(self, scale: int) -> int:
        """Return how wide the small picture is at least."""
        return self.patch_px

    def cut(
        self,
        lr_srgb: torch.Tensor,
        hr_srgb: torch.Tensor,
        landmarks_px: torch.Tensor | None = None,
    ) -> Pair:
        """Return ``(N, 3, patch_px, patch_px)`` and ``scale`` times that; see the base."""
        scale = _scale_of(lr_srgb, hr_srgb)
        return (
            _squares(lr_srgb, self.patch_px, self.stride_px),
            _squares(hr_srgb, scale * self.patch_px, scale * self.stride_px),
        )


class SmallLuminancePatches(RgbPatches):
    """The same squares of the luminance, for networks that enlarge it themselves, as FSRCNN.

    Example:
        >>> small, true = torch.zeros(2, 3, 32, 32), torch.zeros(2, 3, 64, 64)
        >>> [tuple(patches.shape) for patches in SmallLuminancePatches(16, 8).cut(small, true)]
        [(18, 1, 16, 16), (18, 1, 32, 32)]
    """

    def cut(
        self,
        lr_srgb: torch.Tensor,
        hr_srgb: torch.Tensor,
        landmarks_px: torch.Tensor | None = None,
    ) -> Pair:
        """Return ``(N, 1, patch_px, patch_px)`` and ``scale`` times that; see the base."""
        inputs, targets = super().cut(lr_srgb, hr_srgb)
        return luminance(inputs), luminance(targets)


@dataclass(frozen=True)
class FacePatches:
    """One square about each face, and where its landmarks are: for whoever asks who it is.

    Attributes:
        patch_px: Side of an input, px of the small picture; four distances of the eyes hold a head.

    Raises:
        InputError: The number is none, or too small.

    Example:
        >>> small, true = torch.zeros(1, 3, 44, 44), torch.zeros(1, 3, 88, 88)
        >>> cut = FacePatches(32).cut(small, true, torch.full((1, 5, 2), 43.5))
        >>> [tuple(part.shape) for part in cut]
        [(1, 3, 32, 32), (1, 3, 64, 64), (1, 5, 2)]
    """

    patch_px: int = 32

    def __post_init__(self) -> None:
        settle(self, "data.patches")
        require(self.patch_px > 0, "data.patches.patch_px", self.patch_px, "at least 1")

    def least_px(self, scale: int) -> int:
        """Return how wide the small picture is at least."""
        return self.patch_px

    def cut(
        self,
        lr_srgb: torch.Tensor,
        hr_srgb: torch.Tensor,
        landmarks_px: torch.Tensor | None = None,
    ) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        """Return ``(B, 3, patch_px, patch_px)``, ``scale`` times that, and landmarks in the latter.

        Raises:
            InputError: The landmarks of a face are not known.
        """
        scale, side = _scale_of(lr_srgb, hr_srgb), self.patch_px
        if landmarks_px is None or not bool(torch.isfinite(landmarks_px).all()):
            raise InputError(
                "data.patches: FacePatches cuts about landmarks, and a picture has none;"
                " give patches=rgb, or pictures with landmarks"
            )
        _check_size(lr_srgb, side)
        farthest = torch.tensor(lr_srgb.shape[:1:-1]) - side
        middles = scale_points(landmarks_px.mean(1), 1 / scale)
        corners = (middles - (side - 1) / 2).round().long().clamp(min=0).minimum(farthest)
        inputs, targets = (
            torch.stack(
                [
                    image[:, y * by : (y + side) * by, x * by : (x + side) * by]
                    for image, (x, y) in zip(images, corners.tolist(), strict=True)
                ]
            )
            for images, by in ((lr_srgb, 1), (hr_srgb, scale))
        )
        return inputs, targets, landmarks_px - scale * corners[:, None]


def _scale_of(lr_srgb: torch.Tensor, hr_srgb: torch.Tensor) -> int:
    check_images(lr_srgb, name="lr_srgb")
    check_images(hr_srgb, name="hr_srgb")
    height, width = lr_srgb.shape[-2:]
    scale = hr_srgb.shape[-1] // width
    if hr_srgb.shape[-2:] != (scale * height, scale * width) or len(lr_srgb) != len(hr_srgb):
        raise ImageContractError(
            f"got lr {tuple(lr_srgb.shape)} and hr {tuple(hr_srgb.shape)}: wanted one whole scale"
        )
    return scale


def _check_size(images: torch.Tensor, side: int) -> None:
    if min(images.shape[-2:]) < side:
        raise ImageContractError(
            f"got images {tuple(images.shape)}, wanted at least {side}x{side} pixels"
        )


def _squares(images: torch.Tensor, side: int, stride: int) -> torch.Tensor:
    _check_size(images, side)
    rows = images.unfold(2, side, stride).unfold(3, side, stride).permute(0, 2, 3, 1, 4, 5)
    return rows.reshape(-1, images.shape[1], side, side).clone(
        memory_format=torch.contiguous_format
    )
