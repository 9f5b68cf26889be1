"""What restores a face, and looks where it matters? Units that weigh each place by an hourglass.

After Chen et al., "Learning Spatial Attention for Face Super-Resolution" (IEEE Transactions on
Image Processing 2020, arXiv:2012.01211): in a face attention unit a residual is multiplied by a map
that an hourglass, which sees most of the face, draws of it. Theirs is far larger, has batch norm
and works on the enlarged picture; this one has half a million parameters, no batch norm, and works
on the small picture but for the last unit.
"""

from typing import Literal, get_args

import torch
from torch import nn
from torch.nn import functional as F

from lrsr.sr.networks.near_bicubic import let_colours_grow, let_colours_pass, quieten
from lrsr.sr.networks.network import Network, check_choice, check_whole

_LEAK = 0.2

_Initialisation = Literal["default", "near-bicubic"]


class SPARNet(Network):
    """The network, from small srgb to large srgb; borders are repeated.

    Args:
        scale: 2, 3 or 4.
        blocks: Face attention units on the small picture, 1 to 64.
        features: Their channels, at least 4; half as many look for where to attend.
        large_features: Channels of the one unit on the large picture, at least 4.
        depth: How often an hourglass halves the picture, 1 to 4.
        initialisation: "default" is PyTorch's. "near-bicubic" starts within some 3 % of bicubic
            enlargement: a path around the units enlarges, they add little.

    Raises:
        InputError: An argument is out of range.

    Example:
        >>> SPARNet(scale=2, blocks=1, features=8)(torch.zeros(1, 3, 7, 5)).shape
        torch.Size([1, 3, 14, 10])
    """

    input = "rgb"
    reach_px = None
    """None: an hourglass sees most of a face, on a grid that begins at the picture's corner."""

    def __init__(
        self,
        *,
        scale: int = 2,
        blocks: int = 6,
        features: int = 40,
        large_features: int = 16,
        depth: int = 3,
        initialisation: _Initialisation = "default",
    ) -> None:
        super().__init__()
        check_choice("initialisation", initialisation, get_args(_Initialisation))
        check_whole("scale", scale, 2, 4)
        check_whole("blocks", blocks, 1, 64)
        check_whole("features", features, 4, 1024)
        check_whole("large_features", large_features, 4, 1024)
        check_whole("depth", depth, 1, 4)
        self.scale = scale
        self.head = _conv(3, features)
        self.blocks = nn.Sequential(*(_Unit(features, depth) for _ in range(blocks)))
        self.after = _conv(features, features)
        self.enlarge = _conv(features, large_features * scale**2)
        self.large_unit = _Unit(large_features, depth)
        self.tail = _conv(large_features, 3)
        if initialisation == "near-bicubic":
            quieten(self.after)
            quieten(self.large_unit.second)
            let_colours_pass(self.head)
            let_colours_grow(self.enlarge, scale)
            let_colours_pass(self.tail)

    def forward(self, srgb: torch.Tensor) -> torch.Tensor:
        """Enlarge (B, 3, H, W) srgb to (B, 3, scale * H, scale * W); not clipped."""
        features = self.head(srgb)
        features = features + self.after(self.blocks(features))
        large = F.pixel_shuffle(self.enlarge(features), self.scale)
        larger: torch.Tensor = self.tail(self.large_unit(large))
        return larger


class _Unit(nn.Module):
    """A residual of two convolutions, and a map of its own, 0 to 1, that says where it counts."""

    def __init__(self, features: int, depth: int) -> None:
        super().__init__()
        self.first = _conv(features, features)
        self.second = _conv(features, features)
        seen = features // 2
        self.narrow = _conv(features, seen)
        self.hourglass = _Hourglass(seen, depth)
        self.attend = _conv(seen, 1)

    def forward(self, features: torch.Tensor) -> torch.Tensor:
        residual = self.second(_rectify(self.first(_rectify(features))))
        seen = self.hourglass(_rectify(self.narrow(residual)))
        result: torch.Tensor = features + residual * torch.sigmoid(self.attend(seen))
        return result


class _Hourglass(nn.Module):
    """Halves the picture ``depth`` times and comes back, adding what each size has seen."""

    def __init__(self, features: int, depth: int) -> None:
        super().__init__()
        self.down = _conv(features, features, stride=2)
        self.inner = _Hourglass(features, depth - 1) if depth > 1 else nn.Identity()
        self.up = _conv(features, features)

    def forward(self, features: torch.Tensor) -> torch.Tensor:
        height, width = features.shape[-2:]
        half = _rectify(self.up(self.inner(_rectify(self.down(features)))))
        full = F.interpolate(half, scale_factor=2.0, mode="nearest")
        return features + full[..., :height, :width]  # an odd side is halved up


def _rectify(features: torch.Tensor) -> torch.Tensor:
    return F.leaky_relu(features, _LEAK)


def _conv(inputs: int, outputs: int, stride: int = 1) -> nn.Conv2d:
    return nn.Conv2d(inputs, outputs, 3, stride, padding=1, padding_mode="replicate")
