"""What is SRCNN 9-1-5: three convolutions that sharpen a luminance image already enlarged.

Dong et al., "Image Super-Resolution Using Deep Convolutional Networks" (2014/2016), with the filter
sizes of the paper's Table 1: 64x1x9x9, 32x64x1x1, 1x32x5x5.
"""

from types import MappingProxyType
from typing import Literal, get_args

import torch
from torch import nn
from torch.nn import functional as F

from lrsr.sr.networks.network import Network, check_choice

#: Pixels that the three convolutions take from each side: 4 + 0 + 2.
_BORDER_PX = 6

_Padding = Literal["none", "replicate"]
_Initialisation = Literal["default", "near-identity"]


class SRCNN(Network):
    """The network, from enlarged luminance to restored luminance.

    Args:
        padding: "none" takes 6 pixels from each side, as in training (33 becomes 21); "replicate"
            repeats the edge 6 times first, so that the size is kept.
        initialisation: "default" is PyTorch's. "near-identity" starts as the picture it is given,
            up to 1 %: one path through the three layers copies the input, the others start at
            a tenth of PyTorch's last layer. It beats nothing, but loses nothing to bicubic either.

    Example:
        >>> SRCNN()(torch.zeros(1, 1, 33, 33)).shape
        torch.Size([1, 1, 21, 21])
        >>> sum(p.numel() for p in SRCNN().parameters())
        8129
    """

    input = "luminance"
    in_use = MappingProxyType({"padding": "replicate"})

    def __init__(
        self, *, padding: _Padding = "none", initialisation: _Initialisation = "default"
    ) -> None:
        super().__init__()
        check_choice("padding", padding, get_args(_Padding))
        check_choice("initialisation", initialisation, get_args(_Initialisation))
        self.padding: _Padding = padding
        self.extract = nn.Conv2d(1, 64, 9)
        self.map = nn.Conv2d(64, 32, 1)
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

    def forward(self, luminance: torch.Tensor) -> torch.Tensor:
        """Restore an enlarged luminance.

        Args:
            luminance: (B, 1, H, W), studio-range BT.601 / 255, bicubically enlarged; without
                padding H and W are at least 13.

        Returns:
            (B, 1, H, W), or (B, 1, H - 12, W - 12) without padding; not clipped.
        """
        if self.padding == "replicate":
            luminance = F.pad(luminance, (_BORDER_PX,) * 4, mode="replicate")
        features = F.relu(self.extract(luminance))
        restored: torch.Tensor = self.reconstruct(F.relu(self.map(features)))
        return restored
