"""Which marks does skin carry? Moles, freckles, age spots; and small veins that have widened."""

from typing import TypedDict

import cv2
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from lrsr.identities.skin.canvas import Canvas

LOG_MELANIN_PER_LEVEL = 2.6 / 255
"""A sheet's grey level times this is added to the logarithm of melanin."""


class Marks(TypedDict):
    """How many marks of each kind and how dark; their places come from ``places_seed``."""

    moles: int
    freckles: int
    freckle_depth: float
    freckle_spread: float
    age_spots: int
    places_seed: int
    capillaries: int


def sample_marks(rng: Generator, *, melanin: float, age: float) -> Marks:
    """Draw a person's marks; freckles are frequent in fair skin, age spots in old.

    Args:
        rng: Source of randomness.
        melanin: Volume fraction of the skin.
        age: 0 (25 years) to 1 (old).

    Returns:
        Plain numbers.
    """
    freckled = rng.random() < (0.84 * 0.4 if melanin < 0.03 else 0.06 if melanin < 0.1 else 0.0)
    return {
        "moles": int(rng.poisson(2.2)),
        "freckles": round(float(np.exp(rng.uniform(np.log(60), np.log(500))))) if freckled else 0,
        "freckle_depth": float(rng.uniform(0.3, 1.0)),
        "freckle_spread": float(rng.uniform(0.7, 1.5)),
        "age_spots": int(rng.poisson(max(0.0, age - 0.35) * 38.0)) if melanin < 0.1 else 0,
        "places_seed": int(rng.integers(1 << 31)),
        "capillaries": int(rng.poisson(45.0 * age)) if rng.random() < 0.45 * age + 0.05 else 0,
    }


def draw_marks(marks: Marks, canvas: Canvas) -> NDArray[np.uint8]:
    """Draw the marks on a frontal sheet.

    Args:
        marks: As :func:`sample_marks` draws them.
        canvas: The sheet.

    Returns:
        ``(H, W)`` uint8; see ``LOG_MELANIN_PER_LEVEL``.
    """
    rng = np.random.default_rng(marks["places_seed"])
    sheet = canvas.blank()
    _draw_freckles(marks, rng, canvas, sheet)
    count = marks["age_spots"]
    places = np.stack([rng.normal(0, 45, count), rng.uniform(-60, 75, count)], axis=-1)
    levels = rng.integers(22, 75, count)
    canvas.draw_dots(sheet, places, 0.9 + rng.gamma(2.2, 0.75, count), levels)
    sheet = cv2.GaussianBlur(sheet, (0, 0), 0.45 / canvas.pixel_mm)
    count = marks["moles"]
    places = np.stack([rng.normal(0, 34, count), rng.uniform(-100, 70, count)], axis=-1)
    canvas.draw_dots(sheet, places, 0.4 + rng.gamma(2.0, 0.25, count), rng.integers(80, 230, count))
    return np.asarray(cv2.GaussianBlur(sheet, (3, 3), 0.6), dtype=np.uint8)


def draw_capillaries(marks: Marks, canvas: Canvas) -> NDArray[np.uint8]:
    """Draw widened small veins around the nose and on the cheeks.

    Args:
        marks: As :func:`sample_marks` draws them.
        canvas: The sheet.

    Returns:
        ``(H, W)`` uint8, 0..255: how much blood shows.
    """
    rng = np.random.default_rng([marks["places_seed"], 1])
    sheet, count = canvas.blank(), marks["capillaries"]
    beside = rng.random(count) < 0.4
    x = np.where(beside, rng.normal(14.0, 3.0, count), rng.normal(36.0, 9.0, count))
    y = np.where(beside, rng.normal(-42.0, 5.0, count), rng.normal(-34.0, 9.0, count))
    starts = np.stack([x * rng.choice((-1.0, 1.0), count), y], axis=-1)
    heading = rng.uniform(0, 2 * np.pi, (count, 1))
    heading = heading + np.cumsum(rng.normal(0.0, 0.5, (count, 10)), axis=1)
    length_mm = rng.uniform(0.3, 0.9, (count, 1, 1))
    steps = length_mm * np.stack([np.cos(heading), np.sin(heading)], axis=-1)
    paths = starts[:, None] + np.cumsum(steps, axis=1)
    canvas.draw_strands(sheet, paths, rng.integers(90, 255, 6))
    return np.asarray(cv2.GaussianBlur(sheet, (0, 0), 0.7), dtype=np.uint8)


def _draw_freckles(marks: Marks, rng: Generator, canvas: Canvas, sheet: NDArray[np.uint8]) -> None:
    """Most over nose and cheeks, some on the forehead."""
    count = marks["freckles"]
    spread = marks["freckle_spread"]
    places = np.stack(
        [rng.normal(0, 27 * spread, count), rng.normal(-24, 13 * spread, count)], axis=-1
    )
    places[: count // 5, 1] = rng.normal(45, 14, count // 5)
    levels = 100 * marks["freckle_depth"] * rng.uniform(0.5, 1.6, count)
    canvas.draw_dots(sheet, places, rng.gamma(5.0, 0.13, count) + 0.15, levels.astype(np.int64))
