"""Which network turns an aligned face into a vector? A residual one of the size of a MobileFaceNet.

MobileFaceNet (Chen et al. 2018, arXiv:1804.07573) saves multiplications by depthwise convolutions,
which CPUs train slowly: its 1.0 M parameters reach 23 faces/s forwards and backwards on two cores,
where this network of 0.95 M, all dense 3×3, reaches 190 in float32 and 390 in bfloat16 with AMX. A
stride of 4 in the first layer loses little: the faces of interest are themselves enlarged 2 to 5
times. From MobileFaceNet come the width of the late layers and the global depthwise convolution
that replaces pooling, so that each place in the aligned face has weights of its own.
"""

from collections.abc import Sequence

import torch
from torch import nn

from lrsr.recognition.alignment import CROP_PX

_WIDTHS = (32, 96, 128)
"""Channels at 28×28, 14×14 and 7×7."""

_BLOCKS = (1, 2, 2)
"""Residual blocks at each of them."""

DIMENSION = 128
"""Of the embedding."""


class Backbone(nn.Module):
    """From an aligned face to its (not yet normalised) embedding.

    Args:
        widths: Channels of each stage; each stage after the first halves the resolution.
        blocks: Residual blocks of each stage.
        dimension: Of the embedding.

    Example:
        >>> sum(p.numel() for p in Backbone().parameters())
        949728
    """

    def __init__(
        self,
        widths: Sequence[int] = _WIDTHS,
        blocks: Sequence[int] = _BLOCKS,
        dimension: int = DIMENSION,
    ) -> None:
        super().__init__()
        layers: list[nn.Module] = [_convolution(3, widths[0], 7, stride=4), nn.ReLU(inplace=True)]
        channels = widths[0]
        for stage, (width, count) in enumerate(zip(widths, blocks, strict=True)):
            for block in range(count):
                layers.append(_Residual(channels, width, stride=2 if stage and not block else 1))
                channels = width
        side = CROP_PX // 4 // 2 ** (len(widths) - 1)
        self.features = nn.Sequential(*layers)
        self.embedding = nn.Sequential(
            _convolution(channels, 256, 1),
            nn.ReLU(inplace=True),
            nn.Conv2d(256, 256, side, groups=256, bias=False),
            nn.BatchNorm2d(256),
            nn.Flatten(),
            nn.Linear(256, dimension, bias=False),
            nn.BatchNorm1d(dimension),
        )

    def forward(self, faces: torch.Tensor) -> torch.Tensor:
        """Embed RGB ``(B, 3, 112, 112)``, (255 srgb - 127.5) / 127.5, as ``(B, dimension)``."""
        embeddings: torch.Tensor = self.embedding(self.features(faces))
        return embeddings


class _Residual(nn.Module):
    """Two 3×3 convolutions beside a shortcut (He et al. 2016)."""

    def __init__(self, channels: int, width: int, *, stride: int) -> None:
        super().__init__()
        self.body = nn.Sequential(
            _convolution(channels, width, 3, stride=stride),
            nn.ReLU(inplace=True),
            _convolution(width, width, 3),
        )
        same = stride == 1 and channels == width
        self.shortcut = nn.Identity() if same else _convolution(channels, width, 1, stride=stride)
        self.activation = nn.ReLU(inplace=True)

    def forward(self, features: torch.Tensor) -> torch.Tensor:
        """Map ``(B, channels, H, W)`` to ``(B, width, H / stride, W / stride)``."""
        result: torch.Tensor = self.activation(self.body(features) + self.shortcut(features))
        return result


def _convolution(channels: int, width: int, kernel: int, *, stride: int = 1) -> nn.Sequential:
    return nn.Sequential(
        nn.Conv2d(channels, width, kernel, stride, kernel // 2, bias=False), nn.BatchNorm2d(width)
    )
