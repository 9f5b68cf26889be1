"""How does one sensor see three colours? A filter on each photosite, and interpolation.

Every photosite of Bayer's mosaic (US patent 3,971,065, 1976) sees red, green or blue; the two
colours it lacks come from its neighbours. "bilinear" averages the nearest of that colour;
"malvar" adds a part of the second difference of the colour that is there, because edges are the
same in all three (H. S. Malvar, L. He, R. Cutler, ICASSP 2004, doi:10.1109/ICASSP.2004.1326587,
fig. 2). Both are linear, so their gradient is exact. At the border the mosaic is
mirrored about the outermost photosites, which keeps the colours in their places.
"""

import torch
from torch import nn
from torch.nn import functional as F

from lrsr.camera.contract import check_light, check_origin, check_setting
from lrsr.errors import ImageContractError

PATTERNS = ("RGGB", "BGGR", "GRBG", "GBRG")
"""Colours of the photosites (0, 0), (1, 0), (0, 1), (1, 1) of the whole sensor, (x, y)."""

METHODS = ("bilinear", "malvar")

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


class Mosaic(nn.Module):
    """The filters before the photosites, and the interpolation behind them.

    Args:
        pattern: One of :data:`PATTERNS`, as the first pixel of the whole sensor has it.
        method: "bilinear" or "malvar".

    Raises:
        InputError: Unknown pattern or method.
    """

    def __init__(self, pattern: str = "RGGB", method: str = "malvar") -> None:
        super().__init__()
        check_setting("pattern", pattern, pattern in PATTERNS, f"one of {', '.join(PATTERNS)}")
        check_setting("method", method, method in METHODS, f"one of {', '.join(METHODS)}")
        self.pattern, self.method = pattern, method

    def filter(self, light: torch.Tensor, origin_px: tuple[int, int] = (0, 0)) -> torch.Tensor:
        """Keep of ``light`` ``(B, 3, H, W)`` what each filter lets through; see :func:`mosaic`.

        Raises:
            ImageContractError: ``light`` is no batch of three colours.
        """
        return mosaic(light, shifted(self.pattern, origin_px))

    def forward(self, raw: torch.Tensor, origin_px: tuple[int, int] = (0, 0)) -> torch.Tensor:
        """Interpolate a mosaic ``(B, 1, H, W)``; see :func:`demosaic`.

        Raises:
            ImageContractError: ``raw`` is no batch of mosaics, or smaller than 3 × 3.
        """
        return demosaic(raw, shifted(self.pattern, origin_px), self.method)

    def extra_repr(self) -> str:
        """Show the settings when the module is printed."""
        return f"pattern={self.pattern!r}, method={self.method!r}"


def shifted(pattern: str, origin_px: tuple[int, int]) -> str:
    """Return the pattern that a crop has whose first pixel is the sensor's ``(x, y)``.

    Raises:
        InputError: Unknown pattern, or the place is not two whole numbers >= 0.

    Example:
        >>> shifted("RGGB", (1, 0)), shifted("RGGB", (4, 7))
        ('GRBG', 'GBRG')
    """
    check_setting("pattern", pattern, pattern in PATTERNS, f"one of {', '.join(PATTERNS)}")
    x, y = check_origin(origin_px)
    return "".join(pattern[2 * ((row + y) % 2) + (column + x) % 2] for row, column in _SITES)


_SITES = ((0, 0), (0, 1), (1, 0), (1, 1))  # (row, column), in the order of a pattern's letters


def mosaic(light: torch.Tensor, pattern: str = "RGGB") -> torch.Tensor:
    """Keep one colour at each photosite.

    Args:
        light: ``(B, 3, H, W)``, any unit.
        pattern: One of :data:`PATTERNS`, at pixel (0, 0).

    Returns:
        ``(B, 1, H, W)``.

    Raises:
        ImageContractError: ``light`` is no batch of three colours.
        InputError: Unknown pattern.

    Example:
        >>> light = torch.tensor([1.0, 2.0, 3.0])[None, :, None, None].expand(1, 3, 2, 2)
        >>> mosaic(light, "GBRG")[0, 0].tolist()
        [[2.0, 3.0], [1.0, 2.0]]
    """
    check_light(light, name="light")
    check_setting("pattern", pattern, pattern in PATTERNS, f"one of {', '.join(PATTERNS)}")
    height, width = light.shape[-2:]
    chosen = torch.tensor(["RGB".index(letter) for letter in pattern], device=light.device)
    planes = chosen.reshape(2, 2).repeat(-(-height // 2), -(-width // 2))[:height, :width]
    return light.gather(1, planes.expand(len(light), 1, height, width))


def demosaic(raw: torch.Tensor, pattern: str = "RGGB", method: str = "malvar") -> torch.Tensor:
    """Interpolate the two colours that each photosite lacks.

    Args:
        raw: ``(B, 1, H, W)``, H and W >= 3, with the black level taken off.
        pattern: One of :data:`PATTERNS`, at pixel (0, 0).
        method: One of :data:`METHODS`.

    Returns:
        ``(B, 3, H, W)``; what a photosite has seen is kept as it is. "malvar" may overshoot.

    Raises:
        ImageContractError: ``raw`` is no batch of mosaics, or smaller than 3 × 3.
        InputError: Unknown pattern or method.

    Example:
        >>> raw = torch.tensor([[[[8.0, 0, 0], [0, 4, 0], [0, 0, 0]]]])  # red 8, then blue 4
        >>> demosaic(raw, "RGGB", "bilinear")[0, :, 1, 1].tolist()
        [2.0, 0.0, 4.0]
    """
    check_light(raw, channels=(1,), name="raw")
    check_setting("pattern", pattern, pattern in PATTERNS, f"one of {', '.join(PATTERNS)}")
    check_setting("method", method, method in METHODS, f"one of {', '.join(METHODS)}")
    height, width = raw.shape[-2:]
    if min(height, width) < 3:
        raise ImageContractError(f"raw: got {height} x {width} photosites, wanted 3 x 3 or more")
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
    for (row, column), seen in zip(_SITES, pattern, strict=True):
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
