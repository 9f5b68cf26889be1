"""Which way do edges run, and which colours lie along them? Interpolation of a mosaic by direction.

D. Menon, S. Andriani, G. Calvagno, "Demosaicing with directional filtering and a posteriori
decision", IEEE Transactions on Image Processing 16 (2007) 132-141, doi:10.1109/TIP.2006.884928.
Green is interpolated along the row and along the column; the direction in which the difference
between colours then changes less is the edge's. Red and blue follow green along it, and at last all
are refined with averages along it. Grey edges along rows or columns come back exactly.

Each step mirrors its planes about the outermost photosites. As no step tells left from right, that
is the same as to mirror the mosaic itself.
"""

from collections.abc import Callable
from dataclasses import dataclass

import torch
from torch.nn import functional as F

from lrsr.camera.bayer import colour_of_sites

_ROW, _COLUMN = -1, -2  # dimensions: along a row x changes, along a column y


@dataclass(frozen=True)
class _Guide:
    """What is seen where, and which way the edges run."""

    at_green: torch.Tensor  # (H, W); elsewhere red is seen in rows of red, blue in the others
    red_row: torch.Tensor  # (H, 1)
    along_row: torch.Tensor  # (B, 1, H, W); holds where green is not seen


def interpolate_along_edges(raw: torch.Tensor, pattern: str) -> torch.Tensor:
    """Interpolate the two colours that each photosite lacks.

    Args:
        raw: ``(B, 1, H, W)``, H and W >= 3.
        pattern: One of :data:`lrsr.camera.bayer.PATTERNS`, at pixel (0, 0).

    Returns:
        ``(B, 3, H, W)``; what a photosite has seen is kept. Directions are chosen by comparison;
        the gradient is that of the values along the chosen ones.

    Raises:
        InputError: Unknown pattern.

    Example:
        >>> edge = torch.tensor([1.0, 1, 1, 9, 9, 9]).expand(1, 1, 6, 6)
        >>> interpolate_along_edges(edge, "RGGB")[0, :, 2].tolist() == [[1, 1, 1, 9, 9, 9]] * 3
        True
    """
    seen = colour_of_sites(pattern, (raw.shape[-2], raw.shape[-1]), raw.device)
    in_row, in_column = _green_along(raw, _ROW), _green_along(raw, _COLUMN)
    along_row = _roughness(raw - in_row, _ROW) <= _roughness(raw - in_column, _COLUMN)
    guide = _Guide(seen == 1, (seen == 0).any(1, keepdim=True), along_row)
    green = torch.where(guide.at_green, raw, torch.where(along_row, in_row, in_column))
    at_green = _follow(raw, green, guide)
    lead = _along(guide, _mean_of_two, at_green[0] - at_green[1])
    red, blue = _fill(raw, at_green, lead, guide)
    return torch.cat(_refine(raw, red, green, blue, guide), 1)


def _green_along(raw: torch.Tensor, axis: int) -> torch.Tensor:
    """Return green where it is not seen: its neighbours' mean and the seen colour's curvature."""
    before, after = _neighbours(raw, axis, 2)
    return _mean_of_two(raw, axis) + (2 * raw - before - after) / 4


def _roughness(difference: torch.Tensor, axis: int) -> torch.Tensor:
    """Add up over 5 x 5 photosites how much the colours' difference changes along ``axis``.

    The changes in the line itself count three times. Those of its neighbours at a distance of one
    are the other colour's.
    """
    across = _ROW + _COLUMN - axis
    before, after = _neighbours(difference.detach(), axis, 1)
    change = (before - after).abs()
    line = 2 * _mean_of_two(change, axis)
    return 3 * line + torch.stack(
        [*_neighbours(line, across, 2), *_neighbours(change, across, 1)]
    ).sum(0)


def _follow(
    raw: torch.Tensor, green: torch.Tensor, guide: _Guide
) -> tuple[torch.Tensor, torch.Tensor]:
    """Return red and blue where green is seen: as far from green as on both sides."""
    in_row, in_column = (raw + _mean_of_two(raw - green, axis) for axis in (_ROW, _COLUMN))
    red = torch.where(guide.red_row, in_row, in_column)
    return red, torch.where(guide.red_row, in_column, in_row)


def _fill(
    raw: torch.Tensor,
    at_green: tuple[torch.Tensor, torch.Tensor],
    lead: torch.Tensor,
    guide: _Guide,
) -> tuple[torch.Tensor, torch.Tensor]:
    """Return red and blue everywhere, from those where green is seen and red's lead over blue."""
    red = torch.where(guide.red_row, raw, raw + lead)
    blue = torch.where(guide.red_row, raw - lead, raw)
    red = torch.where(guide.at_green, at_green[0], red)
    return red, torch.where(guide.at_green, at_green[1], blue)


def _refine(
    raw: torch.Tensor, red: torch.Tensor, green: torch.Tensor, blue: torch.Tensor, guide: _Guide
) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """Replace the differences between colours by averages along the edge: green, then the rest."""
    red_lead, blue_lead = (_along(guide, _mean_of_three, c - green) for c in (red, blue))
    seen_lead = torch.where(guide.red_row, red_lead, blue_lead)
    green = torch.where(guide.at_green, raw, raw - seen_lead)
    at_green = _follow(raw, green, guide)
    lead = torch.where(guide.at_green, at_green[0] - at_green[1], red - blue)
    red, blue = _fill(raw, at_green, _along(guide, _mean_of_three, lead), guide)
    return red, green, blue


def _along(
    guide: _Guide, mean: Callable[[torch.Tensor, int], torch.Tensor], plane: torch.Tensor
) -> torch.Tensor:
    return torch.where(guide.along_row, mean(plane, _ROW), mean(plane, _COLUMN))


def _mean_of_two(plane: torch.Tensor, axis: int) -> torch.Tensor:
    before, after = _neighbours(plane, axis, 1)
    return (before + after) / 2


def _mean_of_three(plane: torch.Tensor, axis: int) -> torch.Tensor:
    before, after = _neighbours(plane, axis, 1)
    return (before + plane + after) / 3


def _neighbours(plane: torch.Tensor, axis: int, distance: int) -> tuple[torch.Tensor, torch.Tensor]:
    """Return the values ``distance`` before and behind each place along ``axis``."""
    ends = (distance, distance, 0, 0) if axis == _ROW else (0, 0, distance, distance)
    padded, length = F.pad(plane, ends, mode="reflect"), plane.shape[axis]
    return padded.narrow(axis, 0, length), padded.narrow(axis, 2 * distance, length)
