"""What do people look like side by side? Sheets of faces as PNG files, pixels left square."""

import textwrap
from collections.abc import Mapping, Sequence

import numpy as np
import torch
import torch.nn.functional as F
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

from lrsr.errors import ImageContractError
from lrsr.pages import png_bytes

_TILE_PX = 128
_GAP_PX = 4
_HEADING_PX = 24  # of one line
_FURTHER_PX = 17  # of each line more
_LETTERS = 17  # that fit above a tile
_LINE_PX = 20
_DPI = 128  # a power of two: no pixel is lost on the way through inches and back


def draw_contact_sheet(pictures: Mapping[str, torch.Tensor], rows: Sequence[str] = ()) -> bytes:
    """Draw columns side by side, a row a person, each picture as large as the others.

    Args:
        pictures: By heading, each ``(n, 3, h, w)`` srgb, [0, 1], any size, the same n people.
        rows: What stands to the left of each row; empty: nothing.

    Returns:
        A PNG.

    Raises:
        ImageContractError: There is no column, or they show different numbers of people.
    """
    if len({len(column) for column in pictures.values()}) != 1:
        sizes = {heading: len(column) for heading, column in pictures.items()}
        raise ImageContractError(f"contact sheet: got {sizes}, wanted as many people in each")
    people, step = len(next(iter(pictures.values()))), _TILE_PX + _GAP_PX
    headings = [
        [line for part in heading.split("\n") for line in textwrap.wrap(part, _LETTERS)]
        for heading in pictures
    ]
    heading_px = _HEADING_PX + _FURTHER_PX * (max(1, *map(len, headings)) - 1)
    left, top = _GAP_PX + _TILE_PX * bool(rows), heading_px + _GAP_PX
    sheet = np.ones((top + people * step, left + len(pictures) * step, 3))
    words = [
        (*_fitting(textwrap.wrap(row, _LETTERS)), left / 2, top + k * step + _TILE_PX / 2)
        for k, row in enumerate(rows[:people])
    ]
    for number, (lines, column) in enumerate(zip(headings, pictures.values(), strict=True)):
        x = left + number * step
        words.append((*_fitting(lines), x + _TILE_PX / 2, heading_px / 2))
        for row, tile in enumerate(_tiles(column)):
            y = top + row * step
            sheet[y : y + _TILE_PX, x : x + _TILE_PX] = tile.permute(1, 2, 0)
    return _draw(sheet, words)


def draw_portraits(
    faces: Sequence[ArrayLike], captions: Sequence[str], *, columns: int, group: int = 1
) -> bytes:
    """Draw portraits pixel for pixel, row by row, on white, a line under each.

    Args:
        faces: Each ``(3, h, w)`` srgb, [0, 1], all of one size; at least one.
        captions: One under each.
        columns: Portraits in a row, a multiple of ``group``.
        group: Portraits that belong together; between groups the gap is wider.

    Returns:
        A PNG.

    Raises:
        ImageContractError: There is no face, the sizes differ, or there are not as many captions.
    """
    images = [np.asarray(face, dtype=np.float64) for face in faces]
    shapes = sorted({image.shape for image in images})
    if len(shapes) != 1 or len(shapes[0]) != 3 or shapes[0][0] != 3:
        raise ImageContractError(f"portraits: got shapes {shapes}, wanted one (3, h, w)")
    if len(captions) != len(images):
        raise ImageContractError(f"portraits: got {len(captions)} captions, {len(images)} faces")
    _, height, width = shapes[0]
    columns = min(columns, len(images))
    places = [_place(k, columns, group, height, width) for k in range(len(images))]
    across = max(x for _, x in places) + width + _GAP_PX
    down = max(y for y, _ in places) + height + _LINE_PX
    sheet = np.ones((down, across, 3))
    for image, (y, x) in zip(images, places, strict=True):
        sheet[y : y + height, x : x + width] = image.clip(0, 1).transpose(1, 2, 0)
    size = min(7.0, 7.0 * width / 160)  # points; 160 px hold "test-00000-female  f 41"
    lines = zip(captions, places, strict=True)
    return _draw(
        sheet, [(text, size, x + width / 2, y + height + _LINE_PX / 2) for text, (y, x) in lines]
    )


def _fitting(lines: Sequence[str]) -> tuple[str, float]:
    """Return lines as one text, and the size in points at which they are as wide as a tile."""
    return "\n".join(lines), min(7.8, 112 / max([1, *map(len, lines)]))


def _draw(sheet: NDArray[np.float64], words: Sequence[tuple[str, float, float, float]]) -> bytes:
    """Encode ``(H, W, 3)`` in [0, 1] with words: size in points, x and y of the middle in px."""
    height, width, _ = sheet.shape
    figure = Figure(figsize=(width / _DPI, height / _DPI), dpi=_DPI)
    figure.figimage(np.rint(sheet * 255).astype(np.uint8), xo=0, yo=0, origin="upper")
    for text, size, x, y in words:
        figure.text(x / width, 1 - y / height, text, ha="center", va="center", fontsize=size)
    return png_bytes(figure)


def _tiles(column: torch.Tensor) -> torch.Tensor:
    small = column.shape[-1] <= _TILE_PX
    mode = "nearest" if small else "bicubic"
    return F.interpolate(column, [_TILE_PX] * 2, mode=mode, antialias=not small).clamp(0, 1)


def _place(number: int, columns: int, group: int, height: int, width: int) -> tuple[int, int]:
    """Return top and left of a portrait."""
    row, column = divmod(number, columns)
    wide = column // group * (4 * _GAP_PX if group > 1 else 0)
    return _GAP_PX + row * (height + _LINE_PX + _GAP_PX), _GAP_PX + column * (
        width + _GAP_PX
    ) + wide
