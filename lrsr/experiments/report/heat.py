"""How does one number change over two things at once? Heat maps with the numbers."""

from collections.abc import Mapping

import numpy as np
from matplotlib import colormaps, rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lrsr.pages import STYLE, svg_uri

_LOW, _HIGH = 0.5, 1.0
"""Guessing and certainty; what lies outside has the colour of the end."""
_ACROSS = 3
_WIDTH = 7.2  # inches, as of all figures of a page
_COLOURS = "cividis"  # rising in lightness, for any kind of colour vision and for grey print


def draw_heat_maps(
    blocks: Mapping[str, Mapping[str, Mapping[str, float | None]]], title: str
) -> str:
    """Draw areas as colours from 0.5 to 1 with their numbers.

    Args:
        blocks: By title of a map, then by row and by column; None: not measured.
        title: Of the whole.

    Returns:
        An SVG as a data URI.
    """
    table = next(iter(blocks.values()))
    rows, columns = len(table), len(next(iter(table.values())))
    across = min(_ACROSS, len(blocks))
    down = -(-len(blocks) // across)
    wide = max(_WIDTH, across * (0.6 * columns + 0.4) + 1.4)
    size = (wide, down * (0.3 * rows + 0.8) + 0.3)
    with rc_context(STYLE):
        figure = Figure(figsize=size, layout="constrained")
        grid = figure.subplots(down, across, squeeze=False, sharex=True, sharey=True)
        for axes, (name, table) in zip(grid.flat, blocks.items(), strict=False):
            _draw_map(axes, table)
            axes.set(title=name)
        for axes in list(grid.flat)[len(blocks) :]:
            axes.set_visible(False)
        figure.suptitle(title, fontsize=8.5, x=0.01, ha="left")
        return svg_uri(figure)


def _draw_map(axes: Axes, table: Mapping[str, Mapping[str, float | None]]) -> None:
    names, columns = [*table], [*next(iter(table.values()))]
    values = np.array(
        [[table[row].get(column) for column in columns] for row in names], dtype=float
    )
    colours = colormaps[_COLOURS].with_extremes(bad="#bbbbbb")
    axes.imshow(values, cmap=colours, vmin=_LOW, vmax=_HIGH, aspect="auto")
    for (down, across), value in np.ndenumerate(values):
        text = "–" if np.isnan(value) else f"{value:.3f}"
        ink = "white" if value < (_LOW + _HIGH) / 2 else "black"
        axes.text(across, down, text, ha="center", va="center", color=ink, fontsize=6.5)
    axes.set_xticks(range(len(columns)), columns, rotation=30, ha="right")
    axes.set_yticks(range(len(names)), names)
    axes.tick_params(length=0)
    for spine in axes.spines.values():
        spine.set_visible(False)
