"""Which colour does each photosite see? Bayer's mosaic of filters (US patent 3,971,065, 1976)."""

import torch

from lrsr.camera.checks import check_choice, check_light, check_origin

PATTERNS = ("RGGB", "BGGR", "GRBG", "GBRG")
"""Colours of the photosites (0, 0), (1, 0), (0, 1), (1, 1) of the whole sensor, (x, y)."""

SITES = ((0, 0), (0, 1), (1, 0), (1, 1))
"""(row, column) of the four, in the order of a pattern's letters."""


def shifted(pattern: str, origin_px: tuple[int, int]) -> str:
    """Return the pattern that a crop has whose first pixel is the sensor's ``(x, y)``.

    Raises:
        InputError: Unknown pattern, or the place is not two whole numbers >= 0.

    Example:
        >>> shifted("RGGB", (1, 0)), shifted("RGGB", (4, 7))
        ('GRBG', 'GBRG')
    """
    check_choice("pattern", pattern, PATTERNS)
    x, y = check_origin(origin_px)
    return "".join(pattern[2 * ((row + y) % 2) + (column + x) % 2] for row, column in SITES)


def colour_of_sites(
    pattern: str, size: tuple[int, int], device: torch.device | str = "cpu"
) -> torch.Tensor:
    """Return which colour each photosite sees.

    Args:
        pattern: One of :data:`PATTERNS`, at pixel (0, 0).
        size: (height, width).
        device: Where the result lies.

    Returns:
        ``(height, width)`` int64: 0 red, 1 green, 2 blue.

    Raises:
        InputError: Unknown pattern.

    Example:
        >>> colour_of_sites("RGGB", (2, 3)).tolist()
        [[0, 1, 0], [1, 2, 1]]
    """
    check_choice("pattern", pattern, PATTERNS)
    height, width = size
    letters = torch.tensor(["RGB".index(letter) for letter in pattern], device=device)
    return letters.reshape(2, 2).repeat(-(-height // 2), -(-width // 2))[:height, :width]


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
    seen = colour_of_sites(pattern, (light.shape[-2], light.shape[-1]), light.device)
    return light.gather(1, seen.expand(len(light), 1, *seen.shape))
