"""Which part of the face is a texel on? Soft masks in the template's millimetres, made once.

Template coordinates: x to the subject's left, y up, z out of the face, origin between the pupils.
Positions were read off the template head (mean of the shape space).
"""

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from lrsr.identities.ramp import smoothstep
from lrsr.identities.skin.canvas import SUBPIXEL_BITS, Canvas, FloatMap

FACE = Canvas(left_mm=-84.0, top_mm=100.0, width_mm=168.0, height_mm=230.0, pixel_mm=0.4)
"""Frontal sheet for everything coarser than a hair."""

_UPPER_LIP = (
    (0.0, -63.4), (2.5, -63.0), (5.3, -62.4), (8.5, -62.7), (11.5, -63.4), (14.9, -64.6),
    (17.9, -66.3), (20.8, -68.0), (23.2, -70.1), (25.0, -71.9), (26.0, -73.4), (26.5, -74.8),
)  # fmt: skip
_LOWER_LIP = (
    (26.2, -75.8), (25.6, -76.5), (24.6, -77.4), (22.6, -79.0), (18.7, -81.9), (13.6, -84.1),
    (6.6, -85.6), (0.0, -86.1),
)  # fmt: skip
_LID_RIM = (
    (-20.8, -3.2), (-21.1, -2.3), (-22.0, -0.3), (-23.8, 1.1), (-27.3, 2.3), (-31.7, 2.9),
    (-35.4, 2.9), (-38.9, 2.3), (-41.4, 1.8), (-43.0, 0.9), (-44.4, -1.1), (-44.5, -2.0),
    (-43.5, -3.2), (-41.2, -4.4), (-39.0, -5.0), (-35.9, -5.6), (-31.5, -5.7), (-28.3, -5.6),
    (-24.8, -5.0), (-22.5, -4.7),
)  # fmt: skip


def _lip_outline() -> NDArray[np.float64]:
    """The vermilion border of the template: the edge loop of its mesh around the mouth.

    Returns:
        ``(38, 2)``, mm, closed, from the cupid's bow over the subject's left corner.
    """
    half = np.array(_UPPER_LIP + _LOWER_LIP)
    return np.concatenate([half, half[-2:0:-1] * (-1.0, 1.0)])


def _lid_rim(side: int) -> NDArray[np.float64]:
    """The edge of the lids of one eye of the template.

    Args:
        side: -1 for the eye at negative x (image left), 1 for the other.

    Returns:
        ``(20, 2)``, mm, closed; the first 12 points run along the upper lid.
    """
    return np.array(_LID_RIM) * (-float(side), 1.0)


def blob(
    position: NDArray[Any], centre: tuple[float, float, float], size: tuple[float, float, float]
) -> FloatMap:
    """A Gaussian around a point and its mirror image.

    Args:
        position: ``(..., 3)``, template points, mm.
        centre: x >= 0, y, z, mm.
        size: Standard deviations, mm.

    Returns:
        ``(...)`` float32, [0, 1].
    """
    offset = np.abs(position[..., 0]) - centre[0]
    squares = (offset / size[0]) ** 2
    squares += ((position[..., 1] - centre[1]) / size[1]) ** 2
    squares += ((position[..., 2] - centre[2]) / size[2]) ** 2
    return np.asarray(np.exp(-0.5 * squares), dtype=np.float32)


def front(position: NDArray[Any]) -> FloatMap:
    """Whether a template point is seen from in front: 1 on the face, 0 behind the temples."""
    facing = smoothstep(-62.0, -40.0, position[..., 2])
    return np.asarray(facing, dtype=np.float32)


def lip_mask(position: NDArray[Any], pixels: FloatMap) -> FloatMap:
    """Vermilion of both lips, its border softened over about 1.5 mm, and the mouth's inside.

    Args:
        position: ``(..., 3)``, template points, mm.
        pixels: ``(..., 2)``, the same on ``FACE``.

    Returns:
        ``(...)`` float32, [0, 1].
    """
    sheet = FACE.blank()
    FACE.fill_polygon(sheet, _lip_outline())
    sheet = cv2.GaussianBlur(sheet, (0, 0), 0.7 / FACE.pixel_mm)
    lips = FACE.sample(sheet, pixels).astype(np.float32) / 255
    return np.asarray(lips * smoothstep(-45.0, -30.0, position[..., 2]), dtype=np.float32)


def lip_contact(position: NDArray[Any]) -> FloatMap:
    """Closeness to the line on which the lips meet, [0, 1]."""
    x, y = np.abs(position[..., 0]), position[..., 1]
    line = -73.4 - 0.9 * np.clip(x / 25.0, 0, 1) ** 2
    near = np.exp(-0.5 * ((y - line) / 0.9) ** 2) * smoothstep(28.5, 24.0, x)
    return np.asarray(near * smoothstep(-40.0, -20.0, position[..., 2]), dtype=np.float32)


def lid_margin(pixels: FloatMap, width_mm: float, *, upper: bool = False) -> FloatMap:
    """Closeness to the edges of the lids.

    Args:
        pixels: ``(H, W, 2)``, texels on ``FACE``.
        width_mm: Width of the band, mm.
        upper: Only the upper lids.

    Returns:
        ``(H, W)`` float32, [0, 1].
    """
    sheet = FACE.blank()
    for side in (-1, 1):
        rim = _lid_rim(side)
        points = [FACE.to_corners(rim[:12] if upper else rim)]
        thickness = max(1, round(width_mm / FACE.pixel_mm))
        cv2.polylines(sheet, points, not upper, 255, thickness, cv2.LINE_AA, SUBPIXEL_BITS)
    sheet = cv2.GaussianBlur(sheet, (0, 0), 0.3 * width_mm / FACE.pixel_mm)
    return np.asarray(FACE.sample(sheet, pixels) / np.float32(255), dtype=np.float32)


def pigment_regions(position: NDArray[Any]) -> dict[str, FloatMap]:
    """Where skin may be redder or bluer, darker or lighter than the average, whatever its tone.

    Args:
        position: ``(H, W, 3)``, template points, mm.

    Returns:
        Name to ``(H, W)`` float32, [0, 1]: cheeks, nose, ears, lids, chin, forehead, circles,
        perioral, orbits and sides.
    """
    return {
        "cheeks": _cheeks(position),
        "nose": blob(position, (3.0, -41.0, 18.0), (11.0, 12.0, 18.0)),
        "ears": smoothstep(72.0, 79.0, np.abs(position[..., 0]))
        * blob(position, (80.0, -18.0, -95.0), (30.0, 26.0, 26.0)),
        "lids": lids(position),
        "chin": blob(position, (0.0, -102.0, 5.0), (15.0, 10.0, 25.0)),
        "forehead": blob(position, (0.0, 52.0, 10.0), (38.0, 18.0, 40.0)),
        "circles": blob(position, (26.0, -11.5, -3.0), (10.5, 4.5, 15.0))
        + np.float32(0.6) * blob(position, (17.5, -1.0, -3.0), (4.0, 7.0, 15.0)),
        "perioral": blob(position, (13.0, -75.0, 5.0), (15.0, 13.0, 30.0)),
        "orbits": blob(position, (31.0, 1.0, -3.0), (15.0, 10.0, 25.0)),
        "sides": blob(position, (64.0, -15.0, -40.0), (17.0, 55.0, 40.0)),
    }


def _cheeks(position: NDArray[Any]) -> FloatMap:
    """A flush without an outline: broad, stronger on the apples, fading towards jaw and temples."""
    broad = blob(position, (40.0, -34.0, -10.0), (21.0, 19.0, 45.0))
    apples = blob(position, (31.0, -31.0, 0.0), (11.0, 10.0, 30.0))
    return np.asarray(np.float32(0.6) * broad + np.float32(0.35) * apples, dtype=np.float32)


def lids(position: NDArray[Any]) -> FloatMap:
    """The upper lids up to the brows, [0, 1]."""
    return blob(position, (31.0, 4.0, 0.0), (12.0, 4.5, 20.0))
