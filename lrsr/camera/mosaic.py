"""How does a camera with one sensor see colours? Filters before it, interpolation behind it."""

import torch
from torch import nn

from lrsr.camera.bayer import PATTERNS, mosaic, shifted
from lrsr.camera.checks import check_choice
from lrsr.camera.demosaic import METHODS, demosaic


class Mosaic(nn.Module):
    """The filters before the photosites, and the interpolation behind them.

    Args:
        pattern: One of :data:`lrsr.camera.bayer.PATTERNS`, as the whole sensor's first
            pixel has it.
        method: "bilinear", "malvar" or "edge_aware" (:mod:`lrsr.camera.demosaic`).

    Raises:
        InputError: Unknown pattern or method.
    """

    def __init__(self, pattern: str = "RGGB", method: str = "malvar") -> None:
        super().__init__()
        self.pattern = check_choice("pattern", pattern, PATTERNS)
        self.method = check_choice("method", method, METHODS)

    def filter(self, light: torch.Tensor, origin_px: tuple[int, int] = (0, 0)) -> torch.Tensor:
        """Keep of ``light`` ``(B, 3, H, W)`` what each filter lets through: ``(B, 1, H, W)``.

        Raises:
            ImageContractError: ``light`` is no batch of three colours.
        """
        return mosaic(light, shifted(self.pattern, origin_px))

    def forward(self, raw: torch.Tensor, origin_px: tuple[int, int] = (0, 0)) -> torch.Tensor:
        """Interpolate a mosaic ``(B, 1, H, W)`` to ``(B, 3, H, W)``.

        Raises:
            ImageContractError: ``raw`` is no batch of mosaics, or smaller than 3 × 3.
        """
        return demosaic(raw, shifted(self.pattern, origin_px), self.method)

    def extra_repr(self) -> str:
        """Show the settings when the module is printed."""
        return f"pattern={self.pattern!r}, method={self.method!r}"
