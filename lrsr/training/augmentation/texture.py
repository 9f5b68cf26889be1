"""What may stand behind or before a face? A colour, with more or less of something on it."""

import numpy as np
import torch
from torch.nn import functional as F

_CELLS = (2, 4, 8, 16, 56)
"""Colours along a side, between which it blends: from a gradient to fine noise."""


def draw_textures(count: int, size_px: int, rng: np.random.Generator) -> torch.Tensor:
    """Draw squares of a random colour, with random variation about it of a random coarseness.

    Args:
        count: B.
        size_px: Side, px.
        rng: Source of every choice.

    Returns:
        ``(B, 3, size_px, size_px)`` float32, srgb, [0, 1].
    """
    textures = torch.empty(count, 3, size_px, size_px)
    for texture in textures:
        level, colourful, amplitude = rng.random(), rng.random() ** 2, rng.uniform(0, 0.3)
        colour = level + colourful * (rng.random((3, 1, 1)) - level)
        cells = int(rng.choice(_CELLS))
        alike = 1 - colourful  # of the channels: 1 is a pattern without colours of its own
        own, shared = rng.standard_normal((3, cells, cells)), rng.standard_normal((cells, cells))
        drawn = colour + amplitude * (alike * shared + (1 - alike) * own)
        coarse = torch.from_numpy(drawn.astype(np.float32))[None]
        texture.copy_(F.interpolate(coarse, size=(size_px, size_px), mode="bilinear")[0])
    return textures.clamp_(0, 1)
