"""What is the fusion network? Frames laid over the first, weighed place by place, then restored.

Each frame is encoded by the same network, and the features are averaged by weights that are learned
from them and from those of the first frame: Zaheer et al., "Deep Sets" (NeurIPS 2017,
arXiv:1703.06114), with the attention of Bhat et al., "Deep Burst Super-Resolution" (CVPR 2021,
arXiv:2101.10997, section 3.3). So any number of frames may come, and later ones in any order.
"""

import torch
from torch import nn
from torch.nn import functional as F

from lrsr.sr.networks.near_bicubic import quieten
from lrsr.sr.networks.network import Network, check_whole

_CHANNELS = 4
"""Red, green, blue, and how near a pixel's centre lies; 0: the frame does not reach there."""

_COLOURS = 3


class Fusion(Network):
    """The network, from frames laid over the first to one large picture.

    What it returns is the mean of the frames, where they reach, and what it adds to that. It works
    on the small grid, where the ``scale²`` places of each pixel are channels: nothing is lost, and
    a convolution costs ``scale²`` times less.

    Args:
        scale: 2, 3 or 4.
        features: Of each frame, and of what is put together.
        blocks: Residual ones, for each frame and as many for all.

    Raises:
        InputError: An argument is out of range.

    Example:
        >>> Fusion(scale=2, features=8)(torch.ones(1, 5, 4 * 4, 6, 7)).shape
        torch.Size([1, 3, 12, 14])
        >>> sum(p.numel() for p in Fusion(scale=4).parameters())
        73488
    """

    input = "burst"

    def __init__(self, *, scale: int = 2, features: int = 32, blocks: int = 1) -> None:
        super().__init__()
        check_whole("scale", scale, 2, 4)
        check_whole("features", features, 1, 1024)
        check_whole("blocks", blocks, 1, 64)
        self.scale = scale
        self.head = _conv(_CHANNELS * scale**2, features)
        self.each = nn.Sequential(*(_Block(features) for _ in range(blocks)))
        self.weigh = nn.Conv2d(2 * features, features, 1)
        self.join = nn.Conv2d(2 * features, features, 1)
        self.all = nn.Sequential(*(_Block(features) for _ in range(blocks)))
        self.enlarge = _conv(features, _COLOURS * scale**2)
        quieten(self.enlarge)
        quieten(self.weigh)

    def takes(self, height: int, width: int) -> tuple[int, ...]:
        """Return the shape of two frames of that size, laid over each other."""
        return (1, 2, _CHANNELS * self.scale**2, height, width)

    def forward(self, laid: torch.Tensor) -> torch.Tensor:
        """Fuse ``(B, N, 4 * scale², H, W)`` to ``(B, 3, scale * H, scale * W)``, unclipped.

        Args:
            laid: Of :func:`lrsr.sr.fusion.laid_over`; the first frame reaches everywhere.
        """
        places = self.scale**2
        colours, near = torch.split(laid, [_COLOURS * places, places], dim=2)
        reaches = (near > 0).to(laid.dtype)
        by_colour = reaches.repeat(1, 1, _COLOURS, 1, 1)
        mean = (colours * by_colour).sum(1) / by_colour.sum(1)

        differing = torch.cat([(colours - mean[:, None]) * by_colour, near], dim=2)
        found = self.each(F.relu(self.head(differing.flatten(0, 1))))
        found = found.unflatten(0, laid.shape[:2])
        first = found[:, :1].expand_as(found)
        weights = self.weigh(torch.cat([first, found], dim=2).flatten(0, 1)).exp()
        weights = weights.unflatten(0, laid.shape[:2]) * reaches.mean(2, keepdim=True)
        pooled = (weights * found).sum(1) / weights.sum(1)

        joined = F.relu(self.join(torch.cat([found[:, 0], pooled], dim=1)))
        return F.pixel_shuffle(mean + self.enlarge(self.all(joined)), self.scale)


class _Block(nn.Module):
    """Two convolutions, added to what comes in."""

    def __init__(self, features: int) -> None:
        super().__init__()
        self.first, self.second = _conv(features, features), _conv(features, features)

    def forward(self, features: torch.Tensor) -> torch.Tensor:
        result: torch.Tensor = features + self.second(F.relu(self.first(features)))
        return result


def _conv(inputs: int, outputs: int) -> nn.Conv2d:
    return nn.Conv2d(inputs, outputs, 3, padding=1, padding_mode="replicate")
