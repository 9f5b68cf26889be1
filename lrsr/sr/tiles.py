"""How is a picture seen part by part? In tiles that overlap.

By a network that takes one size only (:func:`run_in_tiles`), or since the whole picture would not
fit into memory (:func:`spans`).
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
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


@dataclass(frozen=True)
class Span:
    """Rows or columns of one tile: what is seen, and what is kept of that."""

    seen: slice
    kept: slice

    def target(self, factor: int) -> slice:
        """Where what is kept lies in the enlarged picture."""
        return slice(factor * self.kept.start, factor * self.kept.stop)

    def inner(self, factor: int) -> slice:
        """Where what is kept lies in the enlarged tile."""
        start, stop = self.kept.start - self.seen.start, self.kept.stop - self.seen.start
        return slice(factor * start, factor * stop)


def spans(size_px: int, tile_px: int, around_px: int, multiple_of: int = 1) -> Iterator[Span]:
    """Yield the tiles along one side of a picture; each pixel is kept once.

    Args:
        size_px: Of the side.
        tile_px: What is kept of a tile; the last may have fewer.
        around_px: What it sees on each side of that, as far as there is a picture.
        multiple_of: Where what is seen begins and ends, for networks that group pixels.

    Example:
        >>> [(each.seen, each.kept.start) for each in spans(10, 5, 1, multiple_of=4)]
        [(slice(0, 8, None), 0), (slice(4, 10, None), 5)]
    """
    for start in range(0, size_px, tile_px):
        stop = min(start + tile_px, size_px)
        first = max(0, start - around_px) // multiple_of * multiple_of
        last = -(-(stop + around_px) // multiple_of) * multiple_of
        yield Span(slice(first, min(last, size_px)), slice(start, stop))


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
