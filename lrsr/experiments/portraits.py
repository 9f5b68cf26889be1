"""What do many people look like side by side? One PNG of portraits with a line under each."""

import io
from collections.abc import Sequence

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from lrsr.errors import ImageContractError

GAP_PX = 4
LINE_PX = 20
_DPI = 128  # a power of two: no pixel is lost on the way through inches and back


def draw_portraits(
    faces: Sequence[ArrayLike], captions: Sequence[str], *, columns: int, group: int = 1
) -> bytes:
    """Draw portraits pixel for pixel, row by row, on white.

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
    across = max(x for _, x in places) + width + GAP_PX
    down = max(y for y, _ in places) + height + LINE_PX
    sheet = np.ones((down, across, 3))
    for image, (y, x) in zip(images, places, strict=True):
        sheet[y : y + height, x : x + width] = image.clip(0, 1).transpose(1, 2, 0)
    figure = Figure(figsize=(across / _DPI, down / _DPI), dpi=_DPI)
    figure.figimage(np.rint(sheet * 255).astype(np.uint8), xo=0, yo=0, origin="upper")
    size = min(7.0, 7.0 * width / 160)  # points; 160 px hold "test-00000-female  f 41"
    for caption, (y, x) in zip(captions, places, strict=True):
        middle = 1 - (y + height + LINE_PX / 2) / down
        where = {"ha": "center", "va": "center", "fontsize": size}
        figure.text((x + width / 2) / across, middle, caption, **where)
    buffer = io.BytesIO()
    FigureCanvasAgg(figure).print_png(buffer, metadata={"Software": None})
    return buffer.getvalue()


def _place(number: int, columns: int, group: int, height: int, width: int) -> tuple[int, int]:
    """Return top and left of a portrait."""
    row, column = divmod(number, columns)
    wide = column // group * (4 * GAP_PX if group > 1 else 0)
    return GAP_PX + row * (height + LINE_PX + GAP_PX), GAP_PX + column * (width + GAP_PX) + wide
