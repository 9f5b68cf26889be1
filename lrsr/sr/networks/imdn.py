"""What is IMDN: blocks that keep a quarter of their features at each step and refine the rest.

Hui et al., "Lightweight Image Super-Resolution with Information Multi-distillation Network" (ACM
Multimedia 2019, arXiv:1909.11856): six blocks of 64 features, contrast-aware channel attention, all
blocks fused at the end, one sub-pixel convolution.
"""

from typing import Literal, get_args

import torch
from torch import nn
from torch.nn import functional as F

from lrsr.configuration import require
from lrsr.sr.networks.near_bicubic import let_colours_grow, let_colours_pass, quieten
from lrsr.sr.networks.network import Network, check_choice, check_whole

_LEAK = 0.05
_STEPS = 4
_REDUCTION = 16

_Initialisation = Literal["default", "near-bicubic"]


class IMDN(Network):
    """The network, from small srgb to large srgb.

    Borders are repeated where the paper pads with black: of a patch of 16 pixels, a quarter is
    border, and what it loses there would be most of what it learns from.

    Args:
        scale: 2, 3 or 4.
        blocks: Of distillation, 1 to 64; the paper's six.
        features: Between the blocks, a multiple of 16 so that a quarter and a sixteenth are whole;
            64 in the paper.
        initialisation: "default" is PyTorch's. "near-bicubic" starts within some 3 % of bicubic
            enlargement: a path through the skip enlarges, the rest is small.

    Raises:
        InputError: An argument is out of range.

    Example:
        >>> IMDN(scale=3, blocks=1, features=16)(torch.zeros(1, 3, 6, 5)).shape
        torch.Size([1, 3, 18, 15])
        >>> sum(p.numel() for p in IMDN(scale=4).parameters())
        715176
    """

    input = "rgb"
    reach_px = None
    """None: the contrast of the whole picture weighs the channels everywhere."""

    def __init__(
        self,
        *,
        scale: int = 2,
        blocks: int = 6,
        features: int = 64,
        initialisation: _Initialisation = "default",
    ) -> None:
        super().__init__()
        check_choice("initialisation", initialisation, get_args(_Initialisation))
        check_whole("scale", scale, 2, 4)
        check_whole("blocks", blocks, 1, 64)
        check_whole("features", features, _REDUCTION, 1024)
        require(
            features % _REDUCTION == 0, "module.arguments.features", features, "a multiple of 16"
        )
        self.scale = scale
        self.head = _conv(3, features)
        self.blocks = nn.ModuleList(_Block(features) for _ in range(blocks))
        self.fuse = nn.Conv2d(blocks * features, features, 1)
        self.after = _conv(features, features)
        self.enlarge = _conv(features, 3 * scale**2)
        if initialisation == "near-bicubic":
            quieten(self.after)
            let_colours_pass(self.head)
            let_colours_grow(self.enlarge, scale)

    def forward(self, srgb: torch.Tensor) -> torch.Tensor:
        """Enlarge (B, 3, H, W) srgb to (B, 3, scale * H, scale * W); not clipped."""
        first = features = self.head(srgb)
        found = []
        for block in self.blocks:
            features = block(features)
            found.append(features)
        fused = F.leaky_relu(self.fuse(torch.cat(found, 1)), _LEAK)
        return F.pixel_shuffle(self.enlarge(first + self.after(fused)), self.scale)


class _Block(nn.Module):
    """Four convolutions; each but the last keeps a quarter and hands three quarters on."""

    def __init__(self, features: int) -> None:
        super().__init__()
        self.kept = features // _STEPS
        rest = features - self.kept
        steps = [_conv(rest if step else features, features) for step in range(_STEPS - 1)]
        self.steps = nn.ModuleList([*steps, _conv(rest, self.kept)])
        self.attention = _Attention(features)
        self.fuse = nn.Conv2d(features, features, 1)

    def forward(self, features: torch.Tensor) -> torch.Tensor:
        kept, rest = [], features
        *steps, last = self.steps
        for step in steps:
            refined = F.leaky_relu(step(rest), _LEAK)
            kept.append(refined[:, : self.kept])
            rest = refined[:, self.kept :]
        found = torch.cat([*kept, last(rest)], 1)
        result: torch.Tensor = features + self.fuse(self.attention(found))
        return result


class _Attention(nn.Module):
    """Weighs each channel by its contrast: standard deviation plus mean over the picture."""

    def __init__(self, features: int) -> None:
        super().__init__()
        self.squeeze = nn.Conv2d(features, features // _REDUCTION, 1)
        self.widen = nn.Conv2d(features // _REDUCTION, features, 1)

    def forward(self, features: torch.Tensor) -> torch.Tensor:
        mean = features.mean((2, 3), keepdim=True)
        variance = (features - mean).square().mean((2, 3), keepdim=True)
        contrast = mean + (variance + 1e-12).sqrt()  # a flat channel has a gradient, too
        return features * torch.sigmoid(self.widen(F.relu(self.squeeze(contrast))))


def _conv(inputs: int, outputs: int) -> nn.Conv2d:
    return nn.Conv2d(inputs, outputs, 3, padding=1, padding_mode="replicate")
