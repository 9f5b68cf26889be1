"""What is FSRCNN: an hourglass of convolutions on the small luminance, enlarged by the last layer.

Dong et al., "Accelerating the Super-Resolution Convolutional Neural Network" (ECCV 2016,
arXiv:1608.00367): Conv(5, 56, 1) - Conv(1, 12, 56) - 4 Conv(3, 12, 12) - Conv(1, 56, 12) -
DeConv(9, 1, 56), PReLU between. Some forty times fewer multiplications than SRCNN 9-5-5.
"""

from math import ceil
from typing import Literal, get_args

import torch
from torch import nn
from torch.nn import functional as F

from lrsr.sr.networks.near_bicubic import keys, quieten
from lrsr.sr.networks.network import Network, check_choice, check_whole

_KERNEL_PX = 9
#: Small pixels on either side that a large one is made of.
_REACH_PX = 2

_Initialisation = Literal["default", "near-bicubic"]


class FSRCNN(Network):
    """The network, from small luminance to large luminance.

    Borders are repeated where the paper pads with black.

    Args:
        scale: 2, 3 or 4.
        features: d of the paper, what is seen in each place.
        shrunken: s, what is left of it between shrinking and expanding.
        maps: m, the layers between.
        initialisation: "default" is PyTorch's. "near-bicubic" starts near bicubic enlargement: one
            path copies the picture, and the last layer holds as much of the cubic as its nine
            pixels can (all of it for 2x).

    Raises:
        InputError: An argument is out of range.

    Example:
        >>> FSRCNN(scale=3)(torch.zeros(1, 1, 6, 5)).shape
        torch.Size([1, 1, 18, 15])
        >>> sum(p.numel() for p in FSRCNN().parameters() if p.ndim == 4)
        12464
    """

    input = "luminance"

    def __init__(
        self,
        *,
        scale: int = 2,
        features: int = 56,
        shrunken: int = 12,
        maps: int = 4,
        initialisation: _Initialisation = "default",
    ) -> None:
        super().__init__()
        check_choice("initialisation", initialisation, get_args(_Initialisation))
        check_whole("scale", scale, 2, 4)
        for name, value in (("features", features), ("shrunken", shrunken), ("maps", maps)):
            check_whole(name, value, 1, 1024)
        layers = [_conv(1, features, 5), _conv(features, shrunken, 1)]
        layers += [_conv(shrunken, shrunken, 3) for _ in range(maps)]
        layers += [_conv(shrunken, features, 1)]
        self.layers = nn.ModuleList(layers)
        self.rectifiers = nn.ModuleList(nn.PReLU(layer.out_channels) for layer in layers)
        cut = ceil((_KERNEL_PX - scale) / 2)  # centres the kernel on what a pixel comes from
        self.reconstruct = nn.ConvTranspose2d(
            features,
            1,
            _KERNEL_PX,
            scale,
            padding=cut + _REACH_PX * scale,
            output_padding=2 * cut - _KERNEL_PX + scale,
        )
        if initialisation == "near-bicubic":
            self._begin_near_bicubic(scale, cut)

    def forward(self, luminance: torch.Tensor) -> torch.Tensor:
        """Enlarge (B, 1, H, W) to (B, 1, scale * H, scale * W); not clipped.

        Luminance is studio-range BT.601 / 255 at both ends.
        """
        features = luminance
        for layer, rectify in zip(self.layers, self.rectifiers, strict=True):
            features = rectify(layer(features))
        padded = F.pad(features, (_REACH_PX,) * 4, mode="replicate")
        larger: torch.Tensor = self.reconstruct(padded)
        return larger

    @torch.no_grad()
    def _begin_near_bicubic(self, scale: int, cut: int) -> None:
        """Let feature 0 of each layer copy feature 0; luminance > 0, so PReLU lets it pass."""
        for layer in self.layers:
            weight, bias = layer.get_parameter("weight"), layer.get_parameter("bias")
            centre = weight.shape[-1] // 2
            weight[0], bias[0] = 0.0, 0.0
            weight[0, 0, centre, centre] = 1.0
        quieten(self.reconstruct)
        taps = keys((torch.arange(_KERNEL_PX) - (cut - 0.5 + scale / 2)) / scale)
        for phase in range(scale):
            taps[phase::scale] /= taps[phase::scale].sum()
        self.reconstruct.weight[0, 0] = torch.outer(taps, taps)


def _conv(inputs: int, outputs: int, kernel_px: int) -> nn.Conv2d:
    return nn.Conv2d(inputs, outputs, kernel_px, padding=kernel_px // 2, padding_mode="replicate")
