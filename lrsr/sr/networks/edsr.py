"""What is EDSR, baseline size? Residual blocks without batch norm, and enlarging at the end.

Lim et al., "Enhanced Deep Residual Networks for Single Image Super-Resolution" (CVPR workshops
2017, arXiv:1707.02921): 16 blocks of 64 features, residual scaling 1, a skip around all of them,
sub-pixel convolutions (two of 2x for 4x), and the mean colour of DIV2K taken away and given back.
"""

from typing import Literal, get_args

import torch
from torch import nn
from torch.nn import functional as F

from lrsr.configuration import require
from lrsr.errors import InputError
from lrsr.sr.networks.near_bicubic import let_colours_grow, let_colours_pass, quieten
from lrsr.sr.networks.network import Network, check_choice

_MEAN_SRGB = (0.4488, 0.4371, 0.4040)

_Initialisation = Literal["default", "near-bicubic"]


class EDSR(Network):
    """The network, from small srgb to large srgb.

    Args:
        scale: 2 or 4.
        blocks: Residual blocks, 1 to 256.
        features: Channels between the convolutions, at least 3.
        initialisation: "default" is PyTorch's. "near-bicubic" starts within some 2 % of bicubic
            enlargement, but for the border: a path through the skip enlarges, the rest is small.

    Raises:
        InputError: An argument is out of range.

    Example:
        >>> EDSR(scale=2, blocks=1, features=8)(torch.zeros(1, 3, 6, 5)).shape
        torch.Size([1, 3, 12, 10])
        >>> sum(p.numel() for p in EDSR(scale=2).parameters())
        1369859
    """

    input = "rgb"

    def __init__(
        self,
        *,
        scale: int = 2,
        blocks: int = 16,
        features: int = 64,
        initialisation: _Initialisation = "default",
    ) -> None:
        super().__init__()
        check_choice("initialisation", initialisation, get_args(_Initialisation))
        numbers = {"scale": scale, "blocks": blocks, "features": features}
        for name, value in numbers.items():
            require(type(value) is int, f"module.arguments.{name}", value, "a whole number")
        if scale not in (2, 4) or not 1 <= blocks <= 256 or features < 3:
            got = f"EDSR: scale={scale}, blocks={blocks}, features={features}"
            raise InputError(f"{got}: wanted scale 2 or 4, 1 to 256 blocks, 3 features or more")
        self.register_buffer("mean", torch.tensor(_MEAN_SRGB).view(3, 1, 1))
        self.head = _conv(3, features)
        self.body = nn.Sequential(*(_Block(features) for _ in range(blocks)))
        self.after = _conv(features, features)
        steps = [_conv(features, 4 * features) for _ in range(scale // 2)]
        self.enlarge = nn.ModuleList(steps)
        self.tail = _conv(features, 3)
        if initialisation == "near-bicubic":
            self._begin_near_bicubic()

    def forward(self, srgb: torch.Tensor) -> torch.Tensor:
        """Enlarge (B, 3, H, W) srgb to (B, 3, scale * H, scale * W); not clipped."""
        mean = self.get_buffer("mean")
        features = self.head(srgb - mean)
        features = features + self.after(self.body(features))
        for step in self.enlarge:
            features = F.pixel_shuffle(step(features), 2)
        larger: torch.Tensor = self.tail(features) + mean
        return larger

    def _begin_near_bicubic(self) -> None:
        """Let features 0 to 2 be red, green and blue all the way through the skip."""
        quieten(self.after)
        let_colours_pass(self.head)
        for step in self.enlarge:
            let_colours_grow(step, 2)
        let_colours_pass(self.tail)


class _Block(nn.Module):
    """Two convolutions, a rectifier between them, around which the input passes."""

    def __init__(self, features: int) -> None:
        super().__init__()
        self.first = _conv(features, features)
        self.second = _conv(features, features)

    def forward(self, features: torch.Tensor) -> torch.Tensor:
        result: torch.Tensor = features + self.second(F.relu(self.first(features)))
        return result


def _conv(inputs: int, outputs: int) -> nn.Conv2d:
    return nn.Conv2d(inputs, outputs, 3, padding=1)
