"""Which lines has a life drawn into a face? Grooves and bags on a sheet of heights.

Groups and their order of appearance follow Lemperle et al. 2001 ("A classification of facial
wrinkles"): forehead, frown, crow's feet, under the eye, nose to mouth, upper lip, mouth to chin.
Depths of 0.1 mm are fine lines, of 0.8 mm deep wrinkles.
"""

import math
from functools import lru_cache
from itertools import pairwise
from typing import TypedDict

import cv2
import numpy as np
from numpy.random import Generator
from numpy.typing import ArrayLike, NDArray

from lrsr.identities.skin.canvas import SUBPIXEL_BITS, Canvas, FloatMap

_VALLEY_MM = 1.5
_TAPER_STEPS = 7
_WIDTHS_MM = (0.5, 0.8, 1.2, 1.8, 2.6)
"""Standard deviations of the profiles that grooves can have."""


class Lines(TypedDict):
    """Strength of each group, 0 (none) to about 1 (deep), and where the single lines run."""

    forehead: float
    glabella: float
    crows_feet: float
    under_eye: float
    nasolabial: float
    marionette: float
    forehead_count: int
    paths_seed: int
    eye_bags: float
    upper_lip: float
    cheeks: float
    chin: float
    lid_crease: float


def sample_lines(rng: Generator, *, age: float, masculinity: float) -> Lines:
    """Draw a person's lines; only the fold beside the nose is there from youth.

    Args:
        rng: Source of randomness.
        age: 0 (25 years) to 1 (old).
        masculinity: 0 (female) to 1 (male): a woman's skin is thinner, and folds deeper (Paes et
            al., Aesthetic Surg. J. 29, 2009: perioral lines).

    Returns:
        Plain numbers.
    """
    worn = (2.8 - 1.1 * masculinity) * max(0.0, age - 0.08) ** 1.1

    def depth(share: float) -> float:
        return float(min(1.7, share * worn * np.exp(rng.normal(0.0, 0.45))))

    return {
        "forehead": depth(1.0),
        "glabella": depth(0.9),
        "crows_feet": depth(1.1),
        "under_eye": depth(1.0),
        "nasolabial": float(min(1.5, 0.06 + rng.uniform(0.0, 0.15) + depth(0.8))),
        "marionette": depth(0.8),
        "forehead_count": int(rng.integers(2, 6)),
        "paths_seed": int(rng.integers(1 << 31)),
        "eye_bags": depth(0.9),
        "upper_lip": depth(0.9),
        "cheeks": float(max(0.0, age - 0.35) * min(2.0, np.exp(rng.normal(0.0, 0.5)))),
        "chin": float(rng.uniform(0.0, 0.25) + depth(0.4)),
        "lid_crease": float(rng.uniform(0.0, 0.45)),
    }


class _Engraving:
    """A sheet into which grooves are carved; their profile is a Gaussian and their ends run out.

    Grooves of one width are blurred together; where two of them cross, the later one counts.

    Args:
        canvas: The sheet's place.
    """

    def __init__(self, canvas: Canvas) -> None:
        self._canvas = canvas
        self._plates: dict[float, FloatMap] = {}

    def carve(self, path_mm: ArrayLike, depth_mm: float, width_mm: float) -> None:
        """Carve one groove, or with a negative depth a ridge.

        Args:
            path_mm: ``(K, 2)`` corner points, smoothed by a spline-like subdivision; K > 2.
            depth_mm: Greatest depth, mm; nothing happens between -0.01 and 0.01.
            width_mm: Standard deviation of the profile, mm; the nearest of ``_WIDTHS_MM`` is taken.
        """
        if abs(depth_mm) < 0.01:
            return
        width = min(_WIDTHS_MM, key=lambda known: abs(math.log(known / width_mm)))
        if width not in self._plates:
            self._plates[width] = np.zeros(self._canvas.shape, dtype=np.float32)
        path = np.asarray(path_mm, dtype=np.float64)
        rounding, runs = _rounding(len(path))
        corners = self._canvas.to_corners(rounding @ path)
        # A line one pixel wide loses sigma sqrt(2 pi) of its height to the blur.
        level = depth_mm * width / self._canvas.pixel_mm * np.sqrt(2 * np.pi)
        for run, taper in runs:
            line = float(-level * taper)
            cv2.polylines(
                self._plates[width], [corners[run]], False, line, 1, cv2.LINE_8, SUBPIXEL_BITS
            )

    def heights(self) -> FloatMap:
        """Return what has been carved: ``(H, W)`` float32, mm, grooves below 0."""
        sheet = np.zeros(self._canvas.shape, dtype=np.float32)
        for width, plate in sorted(self._plates.items()):
            if not plate.any():  # carved beside the sheet
                continue
            sigma = width / self._canvas.pixel_mm
            box = _reach(plate, 2 * math.ceil(4 * sigma + 1))
            sheet[box] += cv2.GaussianBlur(plate[box], (0, 0), sigma)
        return sheet


def _reach(plate: FloatMap, margin: int) -> tuple[slice, slice]:
    """Return the box of what is not zero on a plate, larger by a margin on all sides, pixels."""
    rows, columns = (np.flatnonzero(plate.any(axis=axis)) for axis in (1, 0))
    top, left = max(rows[0] - margin, 0), max(columns[0] - margin, 0)
    return slice(top, rows[-1] + margin + 1), slice(left, columns[-1] + margin + 1)


def draw_lines(lines: Lines, canvas: Canvas) -> FloatMap:
    """Draw all grooves and bags on a frontal sheet.

    Args:
        lines: As :func:`sample_lines` draws them.
        canvas: The sheet.

    Returns:
        ``(H, W)`` float32, height in mm; grooves below, bags above 0.
    """
    rng = np.random.default_rng(lines["paths_seed"])
    cuts = _Engraving(canvas)
    _draw_forehead(lines, rng, cuts)
    for side in (-1.0, 1.0):
        _draw_side(lines, rng, cuts, side)
    _draw_mouth(lines, rng, cuts)
    sheet = cuts.heights()
    # A fold is a sharp cut in a shallow valley.
    valley = cv2.GaussianBlur(sheet, (0, 0), _VALLEY_MM / canvas.pixel_mm)
    cv2.addWeighted(sheet, 0.75, valley, 0.6, 0.0, sheet)
    if lines["eye_bags"] > 0:
        bags = _Engraving(canvas)
        for side in (-1.0, 1.0):
            path = np.array([(20.0, -14.0), (27.0, -17.5), (34.0, -17.5), (41.0, -13.0)])
            bags.carve(path * (side, 1), -0.9 * lines["eye_bags"] * rng.uniform(0.9, 1.1), 2.6)
        sheet += bags.heights()
    return sheet


@lru_cache(maxsize=16)
def _rounding(points: int) -> tuple[NDArray[np.float64], list[tuple[slice, float]]]:
    """Return the matrix that rounds the corners of a path twice (Chaikin), its ends kept.

    Also the runs that the rounded path is drawn in, each with its share of the depth.
    """
    path = np.eye(points)
    for _ in range(2):
        near = 0.75 * path[:-1] + 0.25 * path[1:]
        far = 0.25 * path[:-1] + 0.75 * path[1:]
        middle = np.stack([near, far], axis=1).reshape(-1, points)
        path = np.concatenate([path[:1], middle, path[-1:]])
    last = len(path) - 1
    cuts = np.unique(np.linspace(0, last, _TAPER_STEPS + 1).astype(int))
    tapers = np.sin(np.pi * (cuts[:-1] + cuts[1:]) / 2 / last) ** 0.7
    runs = [slice(begin, end + 1) for begin, end in pairwise(cuts.tolist())]
    return path, list(zip(runs, tapers.tolist(), strict=True))


def _draw_forehead(lines: Lines, rng: Generator, cuts: _Engraving) -> None:
    heights = np.linspace(34.0, 62.0, lines["forehead_count"]) + rng.normal(0, 1.5)
    for height in heights:
        reach = rng.uniform(22.0, 46.0, 2)
        sag = rng.uniform(1.5, 4.5)
        breaks = np.sort(rng.uniform(-reach[0], reach[1], rng.integers(0, 3)))
        ends = np.concatenate([[-reach[0] - 4], breaks, [reach[1] + 4]])
        for begin, end in pairwise(ends):
            x = np.linspace(begin - 2, end + 2, 6)
            y = height + sag * np.cos(x / 18.0) - 0.002 * x**2 + rng.normal(0.0, 0.7, 6)
            depth = 0.6 * lines["forehead"] * rng.uniform(0.5, 1.1)
            path = np.stack([x, y + rng.normal(0.0, 0.8)], axis=-1)
            cuts.carve(path, depth, rng.uniform(0.55, 0.9))


def _draw_side(lines: Lines, rng: Generator, cuts: _Engraving, side: float) -> None:
    def carve(path: list[tuple[float, float]], depth: float, width: float, jitter: float) -> None:
        moved = (np.array(path) + rng.normal(0.0, jitter, (len(path), 2))) * (side, 1.0)
        cuts.carve(moved, depth * rng.uniform(0.7, 1.2), width)

    carve([(5.5, 10.0), (5.0, 18.0), (6.5, 29.0)], 0.55 * lines["glabella"], 0.9, 0.7)
    carve([(9.5, 12.0), (9.0, 18.0), (10.5, 25.0)], 0.25 * lines["glabella"], 0.7, 0.7)
    for slope in np.linspace(0.75, -0.7, 5) + rng.normal(0.0, 0.06, 5):
        begin, length = rng.uniform(48.0, 50.5), rng.uniform(9.0, 17.0)
        start = (begin, -2.0 + 4.0 * slope)
        middle = (begin + length / 2, start[1] + 0.40 * length * slope + 0.6)
        end = (begin + length, start[1] + length * slope)
        carve([start, middle, end], 0.42 * lines["crows_feet"], rng.uniform(0.45, 0.65), 0.4)
    under = 0.36 * lines["under_eye"]
    carve([(17.0, -8.0), (24.0, -12.5), (33.0, -13.5), (43.0, -8.5)], under, 0.7, 0.6)
    carve([(19.0, -9.0), (25.0, -10.0), (33.0, -10.5), (40.0, -8.0)], 0.6 * under, 0.45, 0.5)
    carve([(17.0, -10.0), (23.0, -17.5), (31.0, -21.5), (39.0, -21.0)], 0.8 * under, 1.1, 0.7)
    crease = [(19.0, -0.5), (24.0, 5.0), (32.0, 7.3), (40.0, 5.5), (47.0, 0.0)]
    carve(crease, lines["lid_crease"], 0.7, 0.3)
    fold = [(19.5, -42.0), (25.0, -51.0), (31.0, -63.0), (34.0, -76.0)]
    carve(fold, 0.65 * lines["nasolabial"], 1.1, 0.8)
    carve(fold, 0.45 * lines["nasolabial"], 2.6, 0.8)
    carve([(29.0, -78.0), (30.5, -86.0), (30.5, -96.0)], 0.7 * lines["marionette"], 1.2, 0.8)
    for _ in range(5):
        x, y, length = rng.uniform(38.0, 54.0), rng.uniform(-70.0, -35.0), rng.uniform(10.0, 22.0)
        path = [(x, y), (x + 1.5, y - length / 2), (x + rng.normal(0, 3), y - length)]
        carve(path, 0.22 * lines["cheeks"], 0.8, 0.6)


def _draw_mouth(lines: Lines, rng: Generator, cuts: _Engraving) -> None:
    """Short lines that run into the upper lip, and the furrow between lip and chin."""
    if lines["upper_lip"] > 0:
        for x in np.arange(-21.0, 22.0, 4.2) + rng.normal(0.0, 0.9, 11):
            top, bottom = rng.uniform(-58.0, -54.5), -63.0 - 0.012 * x * x
            path = [(1.05 * x, top), (1.02 * x, (top + bottom) / 2), (x, bottom)]
            depth = 0.26 * lines["upper_lip"] * rng.uniform(0.2, 1.1)
            cuts.carve(path, depth, rng.uniform(0.4, 0.6))
    path = [(-15.0, -93.5), (-7.0, -91.0), (7.0, -91.0), (15.0, -93.5)]
    jitter = rng.normal(0.0, 0.6, (4, 2))
    cuts.carve(np.array(path) + jitter, 0.7 * lines["chin"], 1.8)
