"""Which network turns a face into a position map? An encoder of faces and a small decoder.

As PRNet (Feng et al., ECCV 2018), but a hundredth of its size: the encoder is the embedder's
backbone, whose last convolution has weights of its own for each place of the face, and the decoder
draws how far each texel is from where it is on the mean face.
"""

from collections.abc import Sequence
from itertools import pairwise

import torch
from torch import nn

from lrsr.recognition.alignment import CROP_PX
from lrsr.training.backbone import Backbone
from lrsr.training.position_maps import resting_map

_START = 4
"""Rows and columns that the decoder begins with; each of its stages has twice as many."""


class MapNetwork(nn.Module):
    """From a crop of a face to its position map.

    Args:
        widths: Channels of the encoder's stages.
        blocks: Residual blocks of each of them.
        latent: Numbers between encoder and decoder.
        decoder: Channels of the decoder's stages, from 4 x 4 texels on.

    Example:
        >>> sum(p.numel() for p in MapNetwork().parameters())
        775363
    """

    def __init__(
        self,
        widths: Sequence[int] = (32, 64, 96),
        blocks: Sequence[int] = (1, 2, 2),
        latent: int = 160,
        decoder: Sequence[int] = (64, 48, 32, 24, 16),
    ) -> None:
        super().__init__()
        self.encoder = Backbone(widths, blocks, latent)
        self.start = nn.Sequential(
            nn.ReLU(inplace=True),
            nn.Linear(latent, decoder[0] * _START**2),
            nn.Unflatten(1, (decoder[0], _START, _START)),
            nn.ReLU(inplace=True),
        )
        stages = [
            nn.Sequential(
                nn.Upsample(scale_factor=2),
                nn.Conv2d(channels, width, 3, padding=1, bias=False),
                nn.BatchNorm2d(width),
                nn.ReLU(inplace=True),
            )
            for channels, width in pairwise(decoder)
        ]
        last = nn.Conv2d(decoder[-1], 3, 3, padding=1)
        for zero in last.parameters():  # so that learning begins at the mean face
            nn.init.zeros_(zero)
        self.decoder = nn.Sequential(*stages, last)
        self.rest = nn.Parameter(torch.from_numpy(resting_map()).float()[None] / CROP_PX)

    def forward(self, faces: torch.Tensor) -> torch.Tensor:
        """Map RGB ``(B, 3, 112, 112)``, (255 srgb - 127.5) / 127.5, to ``(B, 3, 64, 64)``.

        x, y and nearness, of which 1 is the side of the crop.
        """
        return self.rest + self.decoder(self.start(self.encoder(faces))).to(self.rest.dtype)
