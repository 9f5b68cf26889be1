"""Which network turns a face into a position map? An encoder, and a basis that spans the maps.

The idea is PRNet's (Feng et al., ECCV 2018), which decodes by transposed convolutions. Maps of
faces lie near a space of few dimensions, whatever the pose, so here one linear layer draws them. On
380 pictures it was after 250 steps where a decoder of five convolutions was after 650, in a trial
of each. The encoder is the embedder's backbone, narrower, whose last convolution has weights of its
own for each place of the face.
"""

import torch
from torch import nn

from lrsr.recognition.alignment import CROP_PX
from lrsr.training.backbone import Backbone
from lrsr.training.position_maps import MAP_SIZE, resting_map

_WIDTHS, _BLOCKS = (32, 64, 96), (1, 2, 2)
"""Of the encoder."""
_DIRECTIONS = 40
"""Of the space of maps."""


class MapNetwork(nn.Module):
    """From a crop of a face to its position map.

    Example:
        >>> sum(p.numel() for p in MapNetwork().parameters())
        1018544
    """

    def __init__(self) -> None:
        super().__init__()
        self.encoder = Backbone(_WIDTHS, _BLOCKS, _DIRECTIONS)
        self.basis = nn.Linear(_DIRECTIONS, 3 * MAP_SIZE**2)
        nn.init.zeros_(self.basis.weight)  # so that learning begins at the mean face
        with torch.no_grad():
            self.basis.bias.copy_(torch.from_numpy(resting_map()).ravel() / CROP_PX)

    def forward(self, faces: torch.Tensor) -> torch.Tensor:
        """Map RGB ``(B, 3, 112, 112)``, (255 srgb - 127.5) / 127.5, to ``(B, 3, 64, 64)``.

        x, y and nearness, of which 1 is the side of the crop.
        """
        maps: torch.Tensor = self.basis(self.encoder(faces))
        return maps.reshape(-1, 3, MAP_SIZE, MAP_SIZE)
