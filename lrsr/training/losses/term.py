"""What must a term say so that it can be added to the pixel loss? A weight, and a number."""

from abc import abstractmethod

import torch
from torch import nn

from lrsr.configuration import as_number, require


class Term(nn.Module):
    """Something that is added to the pixel loss of restored colours.

    What it learns is part of the checkpoint; what it only looks things up in, files of other
    networks, is not.

    Args:
        name: Its own, below ``module.losses``, for messages.
        weight: Of it in the sum, at least 0; the pixel loss has 1.

    Raises:
        InputError: The weight is out of range.
    """

    def __init__(self, name: str, weight: float) -> None:
        super().__init__()
        self.name, self.weight = name, as_number(weight, f"module.losses.{name}.weight")
        require(self.weight >= 0, f"module.losses.{name}.weight", weight, "at least 0")

    @abstractmethod
    def forward(
        self,
        restored: torch.Tensor,
        targets: torch.Tensor,
        landmarks_px: torch.Tensor | None = None,
    ) -> torch.Tensor:
        """Return a scalar, less is better, not weighted.

        Args:
            restored: ``(B, 3, H, W)`` float32, srgb, not clipped.
            targets: ``(B, 3, H, W)`` float32, srgb.
            landmarks_px: ``(B, 5, 2)`` in px of the targets, where the patches tell them.
        """
