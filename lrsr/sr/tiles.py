"""How does a network that takes one size only see a picture of any size? In tiles that overlap."""

from collections.abc import Callable, Iterator
from itertools import product

import torch
from torch.nn import functional as F

from lrsr.errors import ImageContractError


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

    Raises:
        ImageContractError: ``run`` enlarges by another factor.

    Example:
        >>> picture = torch.rand(1, 1, 9, 4)
        >>> torch.equal(run_in_tiles(picture, lambda t: t, tile_px=(4, 6), factor=1), picture)
        True
    """
    (height, width), (h, w) = images.shape[-2:], tile_px
    padded = F.pad(images, (0, max(0, w - width), 0, max(0, h - height)), mode="replicate")
    full = [factor * size for size in padded.shape[-2:]]
    result = images.new_empty(*images.shape[:2], *full)
    rows, columns = list(_places(full[0] // factor, h)), list(_places(full[1] // factor, w))
    for (y, top), (x, left) in product(rows, columns):
        given = padded[..., y : y + h, x : x + w]
        tile = run(given)
        check_size(tile, given, factor, "a tile")
        target = result[..., factor * y : factor * (y + h), factor * x : factor * (x + w)]
        target[..., factor * top :, factor * left :] = tile[..., factor * top :, factor * left :]
    return result[..., : factor * height, : factor * width]


def check_size(larger: torch.Tensor, given: torch.Tensor, factor: int, name: str) -> None:
    """Refuse what is not ``factor`` times as high and wide.

    Raises:
        ImageContractError: It is not.
    """
    got, of = tuple(larger.shape[-2:]), tuple(given.shape[-2:])
    wanted = (factor * of[0], factor * of[1])
    if got != wanted:
        raise ImageContractError(
            f"{name}: got {got} pixels of {of}, wanted {wanted}; the network has another scale"
        )


def _places(size: int, tile: int) -> Iterator[tuple[int, int]]:
    """Yield where tiles begin, and from where on each overwrites the one before it."""
    overlap = tile // 4
    for start in [*range(0, size - tile, tile - 2 * overlap), size - tile]:
        yield start, overlap if start else 0
