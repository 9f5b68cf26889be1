"""How does a picture of any size, depth and number of channels go through an upscaler?

Tile by tile, each rounded to whole numbers at once, so that memory follows from the tile and the
file, not from what the network makes of it. Grey is shown as three equal channels, and their mean
is kept.
"""

from collections.abc import Callable
from itertools import product

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from lrsr.sr.tiles import spans
from lrsr.sr.upscaler import Upscaler

_AROUND_PX = 32
"""What a tile sees around it where the network's reach is unknown."""


def enlarge(
    upscaler: Upscaler,
    pixels: NDArray[np.uint8 | np.uint16],
    *,
    tile_px: int | None = None,
    around_px: int | None = None,
    done: Callable[[int], object] = lambda _: None,
) -> NDArray[np.uint8 | np.uint16]:
    """Enlarge whole numbers to whole numbers of the same range.

    Where ``around_px`` is at least the upscaler's reach, tiles change nothing but the rounding of
    float32.

    Args:
        upscaler: Of whatever kind.
        pixels: ``(H, W, 1)`` or ``(H, W, 3)``, srgb.
        tile_px: Sides of a tile; None: the whole picture.
        around_px: What a tile sees around it; None: the upscaler's reach, 32 where
            that is unknown.
        done: Told how many pixels of the small picture are finished, tile by tile.

    Returns:
        ``(scale * H, scale * W, C)``.

    Raises:
        ImageContractError: The upscaler enlarges by another factor than it says.
        InputError: A network returned a NaN or an infinity.

    Example:
        >>> from lrsr.sr import Bicubic
        >>> enlarge(Bicubic(2), np.full((3, 5, 1), 200, np.uint8), tile_px=4).shape
        (6, 10, 1)
    """
    if around_px is None:
        around_px = _AROUND_PX if upscaler.reach_px is None else upscaler.reach_px
    (height, width, channels), scale, many = pixels.shape, upscaler.scale, upscaler.multiple_of
    large = np.empty((scale * height, scale * width, channels), pixels.dtype)
    levels = int(np.iinfo(pixels.dtype).max)
    rows, columns = (list(spans(n, tile_px or n, around_px, many)) for n in (height, width))
    for y, x in product(rows, columns):
        part = pixels[y.seen, x.seen].transpose(2, 0, 1).astype(np.float32) / levels
        srgb = torch.from_numpy(part).expand(3, -1, -1)[None].contiguous()
        kept = upscaler(srgb)[0, :, y.inner(scale), x.inner(scale)]
        kept = kept if channels == 3 else kept.mean(0, keepdim=True)
        whole = kept.double().mul(levels).round().cpu().numpy().transpose(1, 2, 0)
        large[y.target(scale), x.target(scale)] = whole.astype(pixels.dtype)
        done((y.kept.stop - y.kept.start) * (x.kept.stop - x.kept.start))
    return large


def spread_colours(
    pixels: NDArray[np.uint8 | np.uint16], opacity: NDArray[np.uint8 | np.uint16]
) -> NDArray[np.uint8 | np.uint16]:
    """Give what is wholly transparent the colour of the nearest pixel that is not.

    Programs leave black, or anything, where nobody sees it; enlarging would mix that into the edge
    of what is seen. Premultiplied colours would do for bicubic, but a network has learned none.

    Args:
        pixels: ``(H, W, C)``.
        opacity: ``(H, W, 1)``, 0 = transparent.

    Example:
        >>> red_and_black = np.array([[[200, 0, 0], [0, 0, 0]]], np.uint8)
        >>> spread_colours(red_and_black, np.array([[[9], [0]]], np.uint8))[0, 1].tolist()
        [200, 0, 0]
    """
    hidden = opacity[..., 0] == 0
    if hidden.all() or not hidden.any():
        return pixels
    rows, columns = distance_transform_edt(hidden, return_distances=False, return_indices=True)
    spread: NDArray[np.uint8 | np.uint16] = pixels[rows, columns]
    return spread
