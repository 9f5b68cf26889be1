"""How does one sensor see three colours? The two that each photosite lacks are interpolated.

"bilinear" averages the nearest photosites of that colour. "malvar" adds a part of the second
difference of the colour that is there, because edges are the same in all three (H. S. Malvar, L.
He, R. Cutler, ICASSP 2004, doi:10.1109/ICASSP.2004.1326587, fig. 2). Both are linear and look
alike at every photosite, so that edges get zippers. "edge_aware" looks along edges
(:mod:`lrsr.camera.edge_aware`). At the border the mosaic is mirrored about the outermost
photosites, which keeps the colours in their places.
"""

import torch
from torch.nn import functional as F

from lrsr.camera.bayer import PATTERNS, SITES
from lrsr.camera.checks import check_choice, check_light
from lrsr.camera.edge_aware import interpolate_along_edges
from lrsr.errors import ImageContractError

METHODS = ("bilinear", "malvar", "edge_aware")

# 5x5 weights by (dx, dy): what one photosite takes from its neighbours. In the order of `_recipe`.
_CROSS = ((1, 0), (-1, 0), (0, 1), (0, -1))
_BILINEAR: tuple[dict[tuple[int, int], float], ...] = (
    {(0, 0): 1.0},
    dict.fromkeys(_CROSS, 1 / 4),  # green where another colour is
    {(1, 0): 1 / 2, (-1, 0): 1 / 2},  # a colour of the same row, where green is
    {(0, 1): 1 / 2, (0, -1): 1 / 2},  # a colour of the same column, where green is
    {(1, 1): 1 / 4, (-1, 1): 1 / 4, (1, -1): 1 / 4, (-1, -1): 1 / 4},  # red where blue is
)
_FAR = ((2, 0), (-2, 0), (0, 2), (0, -2))
_DIAGONAL = tuple(_BILINEAR[4])
_IN_ROW = {
    (0, 0): 5 / 8,
    (1, 0): 4 / 8,
    (-1, 0): 4 / 8,
    (2, 0): -1 / 8,
    (-2, 0): -1 / 8,
    (0, 2): 1 / 16,
    (0, -2): 1 / 16,
    **dict.fromkeys(_DIAGONAL, -1 / 8),
}
_MALVAR: tuple[dict[tuple[int, int], float], ...] = (
    {(0, 0): 1.0},
    {(0, 0): 4 / 8, **dict.fromkeys(_CROSS, 2 / 8), **dict.fromkeys(_FAR, -1 / 8)},
    _IN_ROW,
    {(dy, dx): weight for (dx, dy), weight in _IN_ROW.items()},
    {(0, 0): 6 / 8, **dict.fromkeys(_DIAGONAL, 2 / 8), **dict.fromkeys(_FAR, -3 / 16)},
)
_KERNELS = {"bilinear": _BILINEAR, "malvar": _MALVAR}


def demosaic(raw: torch.Tensor, pattern: str = "RGGB", method: str = "malvar") -> torch.Tensor:
    """Interpolate the two colours that each photosite lacks.

    Args:
        raw: ``(B, 1, H, W)``, H and W >= 3, with the black level taken off.
        pattern: One of :data:`lrsr.camera.bayer.PATTERNS`, at pixel (0, 0).
        method: One of :data:`METHODS`.

    Returns:
        ``(B, 3, H, W)``; what a photosite has seen is kept as it is. All but "bilinear" may
        overshoot. The gradient is exact; where "edge_aware" finds rows and columns equally smooth
        it is that of rows.

    Raises:
        ImageContractError: ``raw`` is no batch of mosaics, or smaller than 3 × 3.
        InputError: Unknown pattern or method.

    Example:
        >>> raw = torch.tensor([[[[8.0, 0, 0], [0, 4, 0], [0, 0, 0]]]])  # red 8, then blue 4
        >>> demosaic(raw, "RGGB", "bilinear")[0, :, 1, 1].tolist()
        [2.0, 0.0, 4.0]
    """
    check_light(raw, channels=(1,), name="raw")
    check_choice("pattern", pattern, PATTERNS)
    check_choice("method", method, METHODS)
    height, width = raw.shape[-2:]
    if min(height, width) < 3:
        raise ImageContractError(f"raw: got {height} x {width} photosites, wanted 3 x 3 or more")
    if method == "edge_aware":
        return interpolate_along_edges(raw, pattern)
    padded = F.pad(raw, (2, 2, 2, 2), mode="reflect")[:, 0]
    guesses = [_weighted(padded, kernel) for kernel in _KERNELS[method]]
    return torch.stack([_plane(guesses, letter, pattern) for letter in "RGB"], 1)


def _weighted(padded: torch.Tensor, kernel: dict[tuple[int, int], float]) -> torch.Tensor:
    """Sum by hand: a convolution's algorithm, and its last bits, change with the batch's size."""
    height, width = padded.shape[-2] - 4, padded.shape[-1] - 4
    total = torch.zeros_like(padded[:, 2:-2, 2:-2])
    for (dx, dy), weight in kernel.items():
        total = total + weight * padded[:, 2 + dy : 2 + dy + height, 2 + dx : 2 + dx + width]
    return total


def _plane(guesses: list[torch.Tensor], letter: str, pattern: str) -> torch.Tensor:
    plane = torch.empty_like(guesses[0])
    for (row, column), seen in zip(SITES, pattern, strict=True):
        guess = guesses[_recipe(letter, row, column, pattern, seen)]
        plane[:, row::2, column::2] = guess[:, row::2, column::2]
    return plane


def _recipe(letter: str, row: int, column: int, pattern: str, seen: str) -> int:
    """Return which kernel makes ``letter`` at a photosite that has ``seen``."""
    if letter == seen:
        return 0
    if letter == "G":
        return 1
    if seen != "G":
        return 4
    return 2 if pattern[2 * row + 1 - column] == letter else 3
