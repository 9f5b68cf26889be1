"""Which lines has a life drawn into a face? Gaussian grooves on a sheet of heights."""

from typing import TypedDict

import cv2
import numpy as np
from numpy.random import Generator
from numpy.typing import ArrayLike, NDArray

from lrsr.identities.canvas import Canvas, FloatMap

ALBEDO_PER_MM = 0.42
"""Skin's albedo falls by exp(0.42 h) in a groove of height h (mm, negative): it shades itself."""

_SUBPIXEL_BITS = 4


class Lines(TypedDict):
    """Depth of each group of lines, 0 (none) to about 1 (deep), and where the single ones run."""

    forehead: float
    glabella: float
    crows_feet: float
    under_eye: float
    nasolabial: float
    marionette: float
    forehead_count: int
    paths_seed: int


def sample_lines(rng: Generator, *, age: float) -> Lines:
    """Draw a person's lines; only the fold beside the nose is there from youth.

    Args:
        rng: Source of randomness.
        age: 0 (25 years) to 1 (old).

    Returns:
        Plain numbers.
    """
    worn = max(0.0, age - 0.12) ** 1.15

    def depth(share: float) -> float:
        return float(min(1.2, share * worn * np.exp(rng.normal(0.0, 0.5))))

    return {
        "forehead": depth(0.75),
        "glabella": depth(0.65),
        "crows_feet": depth(0.8),
        "under_eye": depth(0.7),
        "nasolabial": float(min(1.2, 0.10 + rng.uniform(0.0, 0.15) + depth(0.75))),
        "marionette": depth(0.65),
        "forehead_count": int(rng.integers(2, 6)),
        "paths_seed": int(rng.integers(1 << 31)),
    }


def draw_lines(lines: Lines, canvas: Canvas) -> FloatMap:
    """Draw all grooves on a frontal sheet.

    Args:
        lines: As :func:`sample_lines` draws them.
        canvas: The sheet.

    Returns:
        ``(H, W)`` float32, height in mm, <= 0.
    """
    rng = np.random.default_rng(lines["paths_seed"])
    sheet = np.zeros(canvas.shape, dtype=np.float32)
    _draw_forehead(lines, rng, canvas, sheet)
    for side in (-1.0, 1.0):
        _draw_side(lines, rng, canvas, sheet, side)
    return sheet


def carve_groove(
    canvas: Canvas, sheet: FloatMap, path_mm: ArrayLike, depth_mm: float, width_mm: float
) -> None:
    """Carve one groove whose profile is a Gaussian and whose ends run out; only its box is touched.

    Args:
        canvas: The sheet's place.
        sheet: ``(H, W)`` float32, mm, lowered in place.
        path_mm: ``(K, 2)`` corner points, smoothed by a spline-like subdivision.
        depth_mm: Greatest depth, mm; nothing happens below 0.01.
        width_mm: Standard deviation of the profile, mm.
    """
    if depth_mm < 0.01:
        return
    path = _smooth(np.asarray(path_mm, dtype=np.float64))
    pixels = canvas.to_pixels(path)
    sigma = width_mm / canvas.pixel_mm
    margin = int(np.ceil(3.5 * sigma)) + 1
    low = np.floor(pixels.min(axis=0)).astype(int) - margin
    high = np.ceil(pixels.max(axis=0)).astype(int) + margin + 1
    low, high = np.maximum(low, 0), np.minimum(high, np.array(canvas.shape)[::-1])
    if (high <= low).any():
        return
    box = np.zeros((high[1] - low[1], high[0] - low[0]), dtype=np.float32)
    taper = np.sin(np.pi * (np.arange(len(path) - 1) + 0.5) / (len(path) - 1)) ** 0.7
    corners = np.round((pixels - low) * (1 << _SUBPIXEL_BITS)).astype(np.int32)
    for begin, end, share in zip(corners[:-1], corners[1:], taper, strict=True):
        cv2.line(box, begin.tolist(), end.tolist(), float(share), 1, cv2.LINE_8, _SUBPIXEL_BITS)
    box = cv2.GaussianBlur(box, (0, 0), sigma)
    # A line one pixel wide loses sigma sqrt(2 pi) of its height to the blur.
    sheet[low[1] : high[1], low[0] : high[0]] -= box * np.float32(
        depth_mm * sigma * np.sqrt(2 * np.pi)
    )


def _smooth(path: NDArray[np.float64]) -> NDArray[np.float64]:
    for _ in range(2):  # Chaikin's corner cutting, ends kept
        near = 0.75 * path[:-1] + 0.25 * path[1:]
        far = 0.25 * path[:-1] + 0.75 * path[1:]
        middle = np.stack([near, far], axis=1).reshape(-1, 2)
        path = np.concatenate([path[:1], middle, path[-1:]])
    return path


def _draw_forehead(lines: Lines, rng: Generator, canvas: Canvas, sheet: FloatMap) -> None:
    heights = np.linspace(36.0, 62.0, lines["forehead_count"]) + rng.normal(0, 1.5)
    for height in heights:
        reach = rng.uniform(22.0, 44.0, 2)
        x = np.linspace(-reach[0], reach[1], 7)
        y = height + 3.0 * np.cos(x / 22.0) - 0.002 * x**2 + rng.normal(0.0, 0.9, 7)
        depth = 0.7 * lines["forehead"] * rng.uniform(0.5, 1.1)
        carve_groove(canvas, sheet, np.stack([x, y], axis=-1), depth, rng.uniform(0.8, 1.3))


def _draw_side(lines: Lines, rng: Generator, canvas: Canvas, sheet: FloatMap, side: float) -> None:
    def carve(path: list[tuple[float, float]], depth: float, width: float) -> None:
        moved = (np.array(path) + rng.normal(0.0, 0.7, (len(path), 2))) * (side, 1.0)
        carve_groove(canvas, sheet, moved, depth * rng.uniform(0.75, 1.15), width)

    carve([(5.5, 10.0), (5.0, 18.0), (6.5, 29.0)], 0.55 * lines["glabella"], 1.0)
    for slope in (0.55, 0.2, -0.15, -0.5):
        end = (48.0 + 14.0, -2.0 + 14.0 * slope)
        middle = (55.0, -2.0 + 6.0 * slope)
        carve([(49.0, -2.0 + 3.0 * slope), middle, end], 0.40 * lines["crows_feet"], 0.8)
    carve(
        [(17.0, -8.0), (24.0, -13.5), (33.0, -14.5), (42.0, -10.0)], 0.35 * lines["under_eye"], 1.1
    )
    carve([(17.0, -10.0), (23.0, -17.5), (32.0, -20.0)], 0.25 * lines["under_eye"], 1.5)
    carve([(19.5, -42.0), (25.0, -51.0), (31.0, -63.0), (34.0, -76.0)], lines["nasolabial"], 1.9)
    carve([(29.5, -79.0), (31.0, -87.0), (31.5, -97.0)], 0.7 * lines["marionette"], 1.5)
