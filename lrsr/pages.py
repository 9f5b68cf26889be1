"""What are the pages of every report made of? Templates, figures and faces, in one HTML file."""

import base64
import io
import re
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.text import Text
from numpy.typing import ArrayLike
from PIL import Image

from lrsr.errors import ImageContractError
from lrsr.files import write_text
from lrsr.letters import write_any_script

_FILE = "report.html"
DPI = 200
COLOURS = ("#000000", "#56B4E9", "#0072B2", "#E69F00", "#D55E00", "#009E73", "#CC79A7", "#999999")
"""Okabe and Ito's palette, told apart with any kind of colour vision."""

_DASHES = ("-", (0, (1, 1)), "-", (0, (4, 1)), (0, (4, 1, 1, 1)), "-", (0, (2, 1)), (0, (6, 2)))
"""A second way to tell lines apart, for grey print."""

_FINEST_PT = 0.1
"""A fifth of a pixel of a figure as wide as the page."""

STYLE = {
    "font.family": "sans-serif",
    "font.size": 8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.6,
    "axes.titlesize": 8.5,
    "axes.titlelocation": "left",
    "grid.linewidth": 0.4,
    "grid.color": "#dddddd",
    "lines.linewidth": 1.3,
    "legend.frameon": False,
    "figure.facecolor": "white",
}


def line_style(number: int) -> dict[str, Any]:
    """Return colour and dashes of a plot's line, as matplotlib takes them.

    The lines 0 to 47 differ: after eight, each colour comes with its next dashes.

    Args:
        number: Of the line, >= 0.

    Example:
        >>> line_style(0) == line_style(8)
        False
    """
    again, place = divmod(number, len(COLOURS))
    kinds = tuple(dict.fromkeys(_DASHES))
    dashes = kinds[(kinds.index(_DASHES[place]) + again) % len(kinds)]
    return {"color": COLOURS[place], "linestyle": dashes}


def title_of(name: str) -> str:
    """Return the name of an experiment as a title; what the user named stays so.

    Example:
        >>> title_of("super_resolution"), title_of("VIS_at_8 px")
        ('Super resolution', 'VIS at 8 px')
    """
    words = name.replace("_", " ")
    return words[:1].upper() + words[1:]


def write_page(folder: Path, name: str, *, versions: Mapping[str, str], **content: Any) -> Path:
    """Write ``report.html``: one file with every picture inside; return its path.

    Args:
        folder: Of the run; made if need be.
        name: Of the template; it extends ``page.html.j2``, which says what every page needs.
        versions: Of the packages and assets, by name; "git" is the commit.
        content: What the template prints; escaped.

    Raises:
        InputError: The folder cannot be written.
    """
    path, template = folder / _FILE, _environment().get_template(f"{name}.html.j2")
    write_text(path, template.render(content, versions=versions))
    return path


@cache
def _environment() -> Environment:
    """Return the one that keeps the templates: compiling them takes longer than filling them."""
    return Environment(
        loader=FileSystemLoader(Path(__file__).resolve().parent / "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def encode_face(srgb: ArrayLike) -> str:
    """Encode one image as it is, pixel for pixel.

    Args:
        srgb: ``(3, H, W)`` srgb, [0, 1]; what lies outside is clipped, for the picture only.

    Returns:
        A WebP without loss as a data URI, smaller than a PNG.

    Raises:
        ImageContractError: Not ``(3, H, W)``, or a NaN.
    """
    image = np.asarray(srgb, dtype=np.float64)
    if image.ndim != 3 or image.shape[0] != 3 or image.size == 0:
        raise ImageContractError(f"got shape {image.shape}, wanted (3, H, W)")
    if np.isnan(image).any():
        raise ImageContractError("the image holds a NaN; wanted srgb in [0, 1]")
    levels = np.rint(np.clip(image, 0, 1) * 255).astype(np.uint8)
    buffer = io.BytesIO()
    # Without a search that takes sixteen times as long and gains a twelfth.
    Image.fromarray(levels.transpose(1, 2, 0)).save(buffer, "WEBP", lossless=True, method=0)
    return _data_uri("webp", buffer.getvalue())


def png_bytes(figure: Figure) -> bytes:
    """Return a figure as a PNG; the same figure gives the same bytes."""
    _take_names_literally(figure)
    buffer = io.BytesIO()
    FigureCanvasAgg(figure).print_png(buffer, metadata={"Software": None})
    return buffer.getvalue()


def png_uri(png: bytes) -> str:
    """Return a PNG as a data URI, to be put into a page."""
    return _data_uri("png", png)


def svg_uri(figure: Figure) -> str:
    """Return a figure as an SVG in a data URI, to be put into a page; its letters are outlines.

    Corners that nobody could see are left out: a curve of 500 people has thousands.

    The same figure gives the same bytes.
    """
    _take_names_literally(figure)
    buffer = io.BytesIO()
    with rc_context(
        {"svg.hashsalt": "lrsr", "svg.fonttype": "path", "path.simplify_threshold": 0.2}
    ):
        FigureCanvasSVG(figure).print_svg(buffer, metadata={"Date": None, "Creator": None})
    svg = re.sub(r">\s+<", "><", buffer.getvalue().decode())
    slim = re.sub(r'(?<= d=")[^"CQ]*(?=")', lambda outline: _thinned(outline[0]), svg)
    return _data_uri("svg+xml", slim.encode())


def _take_names_literally(figure: Figure) -> None:
    """Let any letter be shown and a $ be one: formulas label logarithmic axes alone."""
    write_any_script(figure)
    for text in figure.findobj(Text):
        text.set_parse_math(False)
    axes_of = [axis for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)]
    for axis in axes_of:
        for tick in [*axis.majorTicks, *axis.minorTicks] if axis.get_scale() == "log" else ():
            tick.label1.set_parse_math(True)


def _thinned(outline: str) -> str:
    """Return straight lines of an SVG without the corners that nobody could see.

    What goes lies less than :data:`_FINEST_PT` from the line that stays; what stays is rounded to
    it, and each point is given from the one before it.

    Args:
        outline: Of a path, without curves.

    Example:
        >>> _thinned("M 0 0 L 10.04 0.01 L 20 0.02 L 20 5 L 30.5 7 ")
        'M0 0h20v5l10.5 2'
    """
    parts = []
    for text in re.findall("M[^M]*", outline):
        corners = np.array(re.findall(r"[-.\de]+", text), dtype=np.float32).reshape(-1, 1, 2)
        end = "z" if "z" in text else ""
        if len(corners) > 2:  # a line has no others
            around = bool(end) or np.array_equal(corners[0], corners[-1])
            corners = cv2.approxPolyDP(corners, _FINEST_PT, around)
        places = np.rint(corners[:, 0] / _FINEST_PT).astype(int)
        start, steps = places[0], np.diff(places, axis=0)
        parts += [f"M{_short(start[0])} {_short(start[1])}", *(_step(*one) for one in steps), end]
    return "".join(parts)


def _step(x: int, y: int) -> str:
    if y == 0:
        return f"h{_short(x)}" if x else ""
    return f"l{_short(x)} {_short(y)}" if x else f"v{_short(y)}"


def _short(number: int) -> str:
    return f"{number * _FINEST_PT:.6g}"


def _data_uri(kind: str, image: bytes) -> str:
    return f"data:image/{kind};base64," + base64.b64encode(image).decode("ascii")
