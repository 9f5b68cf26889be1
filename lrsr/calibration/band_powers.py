"""How much goes on in a picture at each fineness, where it is quiet and where it is busy?

Noise is everywhere, people's features are in some places. Blocks of 8 × 8 pixels, each moved by two
pixels against the last, are taken apart into their cosines (the DCT of N. Ahmed, T. Natarajan,
K. R. Rao, IEEE Trans. Computers C-23(1), 1974, doi:10.1109/T-C.1974.223784). The half of the blocks
that is quieter in a band tells its noise, the other half its features; the darker and the brighter
half of the picture apart, as shot noise grows with the light. What a codec leaves of weak cosines
it leaves here too, where a single high-pass filter would see none.
"""

from collections.abc import Sequence
from functools import cache
from itertools import pairwise

import numpy as np
import torch
from torch.nn import functional as F

from lrsr.camera.jpeg_tables import BLOCK_PX
from lrsr.camera.soft_jpeg import cosine_transform

_MOVED_PX = 2
HALVES = ("dark_quiet", "dark_busy", "bright_quiet", "bright_busy")
"""Which blocks: darker or brighter than the middle one, with less or more in the band than it."""

Edges = Sequence[float]
_Floats = torch.Tensor


def band_powers(plane: _Floats, brightness: _Floats, edges: Edges, floor: float) -> _Floats:
    """Return the log mean square of a plane's cosines in bands of frequency.

    Args:
        plane: ``(B, H, W)``, H and W >= 10.
        brightness: ``(B, H, W)``, which blocks are dark by.
        edges: Of the bands, half cycles a block from the origin (0 is the mean, 7 the finest along
            a side); b + 1 rising numbers, > 0.
        floor: Added to each mean square, so that the log of nothing is finite.

    Returns:
        ``(B, 4 b)``: band by band the four :data:`HALVES`. White noise has its variance as the
        mean of the quiet and the busy half's.
    """
    order = _block_means(brightness).argsort(dim=1, stable=True)
    power = _cosines(plane).square() @ _averages(tuple(edges))
    bands = power.gather(1, order[..., None].expand_as(power)).transpose(1, 2)
    columns = []
    for blocks in bands.tensor_split(2, dim=2):
        columns += [half.mean(2) for half in in_order(blocks).tensor_split(2, dim=2)]
    return torch.stack(columns, 2).flatten(1).add(floor).log()


def in_order(values: _Floats) -> _Floats:
    """Sort along the last dimension; NumPy does so in a sixth of PyTorch's time."""
    return torch.from_numpy(np.sort(values.numpy(), axis=-1))


def _cosines(plane: _Floats) -> _Floats:
    """Return the DCT ``(B, blocks, 64)`` of overlapping blocks, row by row."""
    blocks = plane.unfold(1, BLOCK_PX, _MOVED_PX).unfold(2, BLOCK_PX, _MOVED_PX)
    return blocks.reshape(len(plane), -1, BLOCK_PX**2) @ _BOTH_WAYS


def _block_means(plane: _Floats) -> _Floats:
    """Return the means ``(B, blocks)`` of the same blocks."""
    return F.avg_pool2d(plane[:, None], BLOCK_PX, stride=_MOVED_PX).flatten(1)


@cache
def _averages(edges: tuple[float, ...]) -> _Floats:
    """Return what takes the mean of 64 cosines in each band, ``(64, b)``."""
    inside = [_RADIUS.ge(low) & _RADIUS.lt(high) for low, high in pairwise(edges)]
    return torch.stack([band.double() / band.sum() for band in inside], 1)


_BOTH_WAYS = torch.kron(cosine_transform(), cosine_transform()).T.contiguous()
_RADIUS = torch.hypot(torch.arange(8.0)[:, None], torch.arange(8.0)).flatten()
