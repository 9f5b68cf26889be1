"""What is SRCNN: three convolutions that sharpen a luminance image already enlarged.

Dong et al., "Image Super-Resolution Using Deep Convolutional Networks" (2014/2016), with the filter
sizes of the paper's Table 1: 64x1x9x9, 32x64x1x1, 1x32x5x5 (9-1-5); and 9-3-5 and 9-5-5 of its
section 4.3.2, whose middle layer sees 3x3 and 5x5 pixels.
"""

from types import MappingProxyType
from typing import Literal, get_args

import torch
from torch import nn
from torch.nn import functional as F

from lrsr.configuration import require
from lrsr.sr.networks.network import Network, check_choice

_Padding = Literal["none", "replicate"]
_Initialisation = Literal["default", "near-identity"]


class SRCNN(Network):
    """The network, from enlarged luminance to restored luminance.

    Args:
        mapping_px: Side of the middle layer's kernel, 1, 3 or 5.
        padding: "none" takes 6 pixels from each side, as in training (33 becomes 21), 7 and 8 with
            a middle layer of 3 and 5; "replicate" repeats the edge as often first, so that the size
            is kept.
        initialisation: "default" is PyTorch's. "near-identity" starts as the picture it is given,
            up to 1 %: one path through the three layers copies the input, the others start at
            a tenth of PyTorch's last layer. It beats nothing, but loses nothing to bicubic either.

    Example:
        >>> SRCNN()(torch.zeros(1, 1, 33, 33)).shape
        torch.Size([1, 1, 21, 21])
        >>> sum(p.numel() for p in SRCNN().parameters())
        8129

    Raises:
        InputError: An argument is out of range.
    """

    input = "luminance"
    enlarges = False
    in_use = MappingProxyType({"padding": "replicate"})

    def __init__(
        self,
        *,
        mapping_px: int = 1,
        padding: _Padding = "none",
        initialisation: _Initialisation = "default",
    ) -> None:
        super().__init__()
        known = type(mapping_px) is int and mapping_px in (1, 3, 5)
        require(known, "module.arguments.mapping_px", mapping_px, "1, 3 or 5")
        check_choice("padding", padding, get_args(_Padding))
        check_choice("initialisation", initialisation, get_args(_Initialisation))
        self.padding: _Padding = padding
        self.extract = nn.Conv2d(1, 64, 9)
        self.map = nn.Conv2d(64, 32, mapping_px)
        self.reconstruct = nn.Conv2d(32, 1, 5)
        if initialisation == "near-identity":
            self._begin_near_identity()

    @torch.no_grad()
    def _begin_near_identity(self) -> None:
        """Let filter 0 of each layer copy its input; luminance > 0, so ReLU lets it pass."""
        self.reconstruct.weight.mul_(0.1)
        for layer in (self.extract, self.map, self.reconstruct):
            layer.weight[0, 0 if layer is self.reconstruct else slice(None)] = 0.0
            centre = layer.kernel_size[0] // 2
            layer.weight[0, 0, centre, centre] = 1.0
            if layer.bias is not None:
                layer.bias[0] = 0.0

    @property
    def border_px(self) -> int:
        """Pixels that the three convolutions take from each side: 4 + 0 + 2, for 9-1-5."""
        layers = (self.extract, self.map, self.reconstruct)
        return sum(layer.kernel_size[0] // 2 for layer in layers)

    def forward(self, luminance: torch.Tensor) -> torch.Tensor:
        """Restore an enlarged luminance.

        Args:
            luminance: (B, 1, H, W), studio-range BT.601 / 255, bicubically enlarged; without
                padding H and W are larger than twice the border.

        Returns:
            (B, 1, H, W), or without padding less by the border on each side; not clipped.
        """
        if self.padding == "replicate":
            luminance = F.pad(luminance, (self.border_px,) * 4, mode="replicate")
        features = F.relu(self.extract(luminance), inplace=True)
        restored: torch.Tensor = self.reconstruct(F.relu(self.map(features), inplace=True))
        return restored
