"""What does each method make of the same few people? One PNG, a row a person, a column a method."""

from collections.abc import Mapping
from pathlib import Path

import torch
import torch.nn.functional as F
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from torchvision.transforms.v2 import InterpolationMode
from torchvision.transforms.v2.functional import resize

from lrsr.errors import ImageContractError
from lrsr.files import replacing

TILE_PX = 128
GAP_PX = 4
HEADING_PX = 24
_DPI = 128  # a power of two: no pixel is lost on the way through inches and back


def write_contact_sheet(path: Path, pictures: Mapping[str, torch.Tensor]) -> Path:
    """Write the columns side by side, each picture as large as the others, pixels left square.

    Args:
        path: Of the PNG.
        pictures: By heading, each ``(n, 3, h, w)`` srgb, [0, 1], any size, the same n people.

    Returns:
        ``path``.

    Raises:
        ImageContractError: There is no column, or they show different numbers of people.
        InputError: The file cannot be written.
    """
    if len({len(column) for column in pictures.values()}) != 1:
        sizes = {heading: len(column) for heading, column in pictures.items()}
        raise ImageContractError(f"contact sheet: got {sizes}, wanted as many people in each")
    tiles = torch.stack([_tile(column) for column in pictures.values()], dim=1)
    grid = _lay_out(tiles)
    height, width = grid.shape[1] + HEADING_PX, grid.shape[2]
    figure = Figure(figsize=(width / _DPI, height / _DPI), dpi=_DPI)
    levels = grid.mul(255).round().to(torch.uint8).permute(1, 2, 0).numpy()
    figure.figimage(levels, xo=0, yo=0, origin="upper")
    for number, heading in enumerate(pictures):
        middle = GAP_PX + number * (TILE_PX + GAP_PX) + TILE_PX / 2
        place = {"ha": "center", "va": "center", "fontsize": 7.8}
        figure.text(middle / width, 1 - HEADING_PX / 2 / height, heading, **place)
    with replacing(path) as beside:
        FigureCanvasAgg(figure)
        figure.savefig(beside, format="png", dpi=_DPI, metadata={"Software": None})
    return path


def _lay_out(tiles: torch.Tensor) -> torch.Tensor:
    """Put ``(rows, columns, 3, h, w)`` side by side with white gaps between and around them."""
    spaced = F.pad(tiles, (0, GAP_PX, 0, GAP_PX), value=1.0)
    grid = spaced.permute(2, 0, 3, 1, 4).flatten(3, 4).flatten(1, 2)
    return F.pad(grid, (GAP_PX, 0, GAP_PX, 0), value=1.0)


def _tile(column: torch.Tensor) -> torch.Tensor:
    small = column.shape[-1] <= TILE_PX
    how = InterpolationMode.NEAREST if small else InterpolationMode.BICUBIC
    tile: torch.Tensor = resize(column, [TILE_PX, TILE_PX], how, antialias=not small)
    return tile.clamp(0, 1)
