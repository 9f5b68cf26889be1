"""What does SRCNN learn from? Small squares of luminance, cut on one grid from input and target.

Sizes of Dong et al. 2016 (arXiv:1501.00092, section 4): 33 in, 21 out (the network pads nothing
and loses 6 pixels on each side), stride 14.
"""

from collections.abc import Sequence

import torch
from torch.utils.data import Dataset

from lrsr.errors import ImageContractError
from lrsr.images import check_images, luminance, resize_bicubic

PATCH_PX = 33
LABEL_PX = 21
STRIDE_PX = 14


def luminance_pair(
    lr_srgb: torch.Tensor, hr_srgb: torch.Tensor
) -> tuple[torch.Tensor, torch.Tensor]:
    """Return the network's input and target: luminance of the enlarged LR and of the HR image.

    Args:
        lr_srgb: ``(B, 3, H, W)`` srgb, [0, 1].
        hr_srgb: ``(B, 3, s H, s W)`` srgb, [0, 1]: the same scene on a film s times finer.

    Returns:
        Both ``(B, 1, s H, s W)``, studio-range BT.601; the first may overshoot, not clipped.

    Raises:
        ImageContractError: ``hr_srgb`` is not a whole number of times larger.
    """
    check_images(lr_srgb, name="lr_srgb")
    check_images(hr_srgb, name="hr_srgb")
    height, width = lr_srgb.shape[-2:]
    scale = hr_srgb.shape[-1] // width
    if hr_srgb.shape[-2:] != (scale * height, scale * width) or len(lr_srgb) != len(hr_srgb):
        raise ImageContractError(
            f"got lr {tuple(lr_srgb.shape)} and hr {tuple(hr_srgb.shape)}: wanted one whole scale"
        )
    return resize_bicubic(luminance(lr_srgb), scale), luminance(hr_srgb)


def cut_patches(
    inputs: torch.Tensor,
    targets: torch.Tensor,
    *,
    patch_px: int = PATCH_PX,
    label_px: int = LABEL_PX,
    stride_px: int = STRIDE_PX,
) -> tuple[torch.Tensor, torch.Tensor]:
    """Cut every whole patch of the grid, and the centre of the same place of the target.

    Args:
        inputs: ``(B, 1, H, W)``.
        targets: ``(B, 1, H, W)``.
        patch_px: Side of an input patch.
        label_px: Side of a target patch; ``patch_px - label_px`` is even.
        stride_px: From patch to patch.

    Returns:
        ``(N, 1, patch_px, patch_px)`` and ``(N, 1, label_px, label_px)``, contiguous; N is
        ``B * ((H - patch_px) // stride_px + 1) * ((W - patch_px) // stride_px + 1)``, in the
        order of images, rows, columns.

    Raises:
        ImageContractError: The shapes differ, an image is smaller than a patch, or the label is
            not centred.

    Example:
        >>> grid = torch.zeros(2, 1, 64, 64)
        >>> [tuple(patches.shape) for patches in cut_patches(grid, grid)]
        [(18, 1, 33, 33), (18, 1, 21, 21)]
    """
    check_images(inputs, channels=1, name="inputs")
    check_images(targets, channels=1, name="targets")
    margin, odd = divmod(patch_px - label_px, 2)
    if odd or margin < 0:
        raise ImageContractError(f"a label of {label_px} is not centred in a patch of {patch_px}")
    if inputs.shape != targets.shape or min(inputs.shape[-2:]) < patch_px:
        raise ImageContractError(
            f"got inputs {tuple(inputs.shape)} and targets {tuple(targets.shape)}, wanted one"
            f" shape, at least {patch_px}x{patch_px}"
        )
    height, width = targets.shape[-2:]
    centres = targets[..., margin : height - margin, margin : width - margin]
    return _squares(inputs, patch_px, stride_px), _squares(centres, label_px, stride_px)


def _squares(images: torch.Tensor, side: int, stride: int) -> torch.Tensor:
    rows = images.unfold(2, side, stride).unfold(3, side, stride)
    return rows.reshape(-1, 1, side, side).clone(memory_format=torch.contiguous_format)


class PatchDataset(Dataset[tuple[torch.Tensor, torch.Tensor]]):
    """Patches in two contiguous tensors; asked for a list of numbers, it gives a whole batch.

    Args:
        inputs: ``(N, 1, patch, patch)``.
        targets: ``(N, 1, label, label)``.
    """

    def __init__(self, inputs: torch.Tensor, targets: torch.Tensor) -> None:
        self.inputs = inputs
        self.targets = targets

    def __len__(self) -> int:
        return len(self.inputs)

    def __getitem__(self, numbers: int | Sequence[int]) -> tuple[torch.Tensor, torch.Tensor]:
        """Return one pair of patches, or the batches of both for a sequence of numbers."""
        if isinstance(numbers, int):
            return self.inputs[numbers], self.targets[numbers]
        at = torch.as_tensor(numbers)
        return self.inputs.index_select(0, at), self.targets.index_select(0, at)


class PairDataset(Dataset[tuple[torch.Tensor, torch.Tensor]]):
    """Whole images, input and target ``(1, H, W)`` each; sizes may differ from pair to pair.

    Args:
        pairs: The images.
    """

    def __init__(self, pairs: Sequence[tuple[torch.Tensor, torch.Tensor]]) -> None:
        self.pairs = list(pairs)

    def __len__(self) -> int:
        return len(self.pairs)

    def __getitem__(self, number: int) -> tuple[torch.Tensor, torch.Tensor]:
        return self.pairs[number]
