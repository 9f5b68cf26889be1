"""How does a network that takes one size only see a picture of any size? In tiles that overlap."""

from collections.abc import Callable, Iterator
from itertools import product

import torch
from torch.nn import functional as F


def run_in_tiles(
    images: torch.Tensor,
    run: Callable[[torch.Tensor], torch.Tensor],
    *,
    tile_px: tuple[int, int],
    factor: int,
) -> torch.Tensor:
    """Let ``run`` see tiles only, and put together what it makes of them.

    A quarter of a tile on each side only serves as surroundings, but at the picture's own border.
    A picture smaller than a tile is filled up by its last row and column.

    Args:
        images: (B, C, H, W).
        run: Makes (B, C, factor * h, factor * w) of (B, C, h, w).
        tile_px: h and w.
        factor: New size over old.

    Returns:
        (B, C, factor * H, factor * W).

    Example:
        >>> picture = torch.rand(1, 1, 9, 4)
        >>> torch.equal(run_in_tiles(picture, lambda t: t, tile_px=(4, 6), factor=1), picture)
        True
    """
    height, width = images.shape[-2:]
    h, w = tile_px
    padded = F.pad(images, (0, max(0, w - width), 0, max(0, h - height)), mode="replicate")
    full = [factor * size for size in padded.shape[-2:]]
    result = images.new_empty(*images.shape[:2], *full)
    rows, columns = _places(padded.shape[-2], h), _places(padded.shape[-1], w)
    for (y, top), (x, left) in product(list(rows), list(columns)):
        tile = run(padded[..., y : y + h, x : x + w])
        kept = tile[..., factor * top :, factor * left :]
        result[
            ..., factor * (y + top) : factor * (y + h), factor * (x + left) : factor * (x + w)
        ] = kept
    return result[..., : factor * height, : factor * width]


def _places(size: int, tile: int) -> Iterator[tuple[int, int]]:
    """Yield where tiles begin, and from where on each overwrites the one before it."""
    overlap = tile // 4
    for start in [*range(0, size - tile, tile - 2 * overlap), size - tile]:
        yield start, overlap if start else 0
