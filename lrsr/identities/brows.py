"""What eyebrows does a person wear? Strands along an arch, over a blur of themselves."""

from typing import TypedDict

import cv2
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from lrsr.identities.canvas import Canvas

FloatArray = NDArray[np.float64]

CANVAS = Canvas(left_mm=-66.0, top_mm=48.0, width_mm=132.0, height_mm=52.0)
"""The part of the frontal sheet that brows may cover."""

BASE_HEIGHT_MM = 16.0
"""Height of the template's brow ridge over the pupils; ``height_mm`` is counted from here."""

_STRANDS = 420
_REFERENCE_THICKNESS_MM = 4.2
_STRAND_POINTS = 4
_BASE_BLUR_PX = 3.5


class Brows(TypedDict):
    """One person's eyebrows; lengths in mm on the template, the left brow a mirrored variation."""

    start_mm: float
    end_mm: float
    height_mm: float
    arch_mm: float
    peak: float
    slope_mm: float
    tail_mm: float
    thickness_mm: float
    taper: float
    density: float
    strand_mm: float
    bridge: float
    unevenness_mm: float


def sample_brows(rng: Generator, *, masculinity: float) -> Brows:
    """Draw a person's eyebrows.

    Args:
        rng: Source of randomness.
        masculinity: 0 (female) to 1 (male): men's brows are thicker, lower and flatter.

    Returns:
        Plain numbers.
    """
    m = float(masculinity)
    return {
        "start_mm": float(rng.uniform(7.0, 17.0 - 3.0 * m)),
        "end_mm": float(rng.uniform(44.0, 56.0)),
        "height_mm": float(np.clip(rng.normal(1.4 - 2.0 * m, 2.0), -4.5, 5.0)),
        "arch_mm": float(0.5 + 7.0 * rng.beta(1.3, 1.2 + 1.4 * m)),
        "peak": float(rng.uniform(0.45, 0.75)),
        "slope_mm": float(rng.normal(0.3 - 0.3 * m, 1.5)),
        "tail_mm": float(rng.uniform(0.0, 6.0)),
        "thickness_mm": float(1.8 + 6.7 * rng.beta(1.2 + 1.3 * m, 2.2 - 0.7 * m)),
        "taper": float(rng.uniform(0.35, 1.1)),
        "density": float(np.clip(np.exp(rng.normal(0.05, 0.4)), 0.35, 2.2)),
        "strand_mm": float(rng.uniform(4.5, 8.5)),
        "bridge": float(rng.uniform(0.2, 1.0)) if rng.random() < 0.02 + 0.06 * m else 0.0,
        "unevenness_mm": float(rng.normal(0.0, 0.8)),
    }


def brow_line(brows: Brows, along: FloatArray) -> FloatArray:
    """Centre line of the brow on the subject's left (x > 0).

    Args:
        brows: As :func:`sample_brows` draws them.
        along: ``(...)``, 0 at the nose, 1 at the temple.

    Returns:
        ``(..., 2)``, mm.
    """
    peak = brows["peak"]
    rise = np.clip(along / peak, 0, 1)
    fall = np.clip((along - peak) / (1 - peak), 0, 1)
    x = brows["start_mm"] + along * (brows["end_mm"] - brows["start_mm"])
    y = (
        BASE_HEIGHT_MM
        + brows["height_mm"]
        + brows["arch_mm"] * (np.sin(0.5 * np.pi * rise) - 0.85 * fall**1.7)
        + brows["slope_mm"] * (along - 0.4)
        - brows["tail_mm"] * fall**1.5
        - 0.35 * brows["arch_mm"]
    )
    return np.stack([x, y], axis=-1)


def brow_thickness(brows: Brows, along: FloatArray) -> FloatArray:
    """Vertical extent of the brow.

    Args:
        brows: As :func:`sample_brows` draws them.
        along: ``(...)``, 0 at the nose, 1 at the temple.

    Returns:
        ``(...)``, mm.
    """
    tip = np.clip((1 - along) / 0.75, 0, 1) ** brows["taper"]
    head = 0.72 + 0.28 * np.clip(along / 0.2, 0, 1)
    return np.asarray(brows["thickness_mm"] * np.maximum(tip * head, 0.10))


def brow_strands(brows: Brows, rng: Generator) -> FloatArray:
    """Lay the hairs of one brow, on the subject's left.

    At the nose they stand up, towards the temple they lie along the line; the upper ones lean
    down and the lower ones up, so that they meet in the middle.

    Args:
        brows: As :func:`sample_brows` draws them.
        rng: Source of randomness.

    Returns:
        ``(N, 4, 2)``, mm; N = 420 x density x thickness / 4.2 mm.
    """
    count = max(
        20, round(_STRANDS * brows["density"] * brows["thickness_mm"] / _REFERENCE_THICKNESS_MM)
    )
    along = rng.beta(1.12, 1.22, count)
    across = np.clip(rng.normal(0.0, 0.30, count), -0.62, 0.62)
    thickness = brow_thickness(brows, along)
    root = brow_line(brows, along)
    root[:, 1] += across * thickness
    ahead = brow_line(brows, along + 0.01) - brow_line(brows, along)
    direction = np.arctan2(ahead[:, 1], ahead[:, 0])
    upright = np.clip(1 - along / 0.22, 0, 1)
    lean = -0.75 * across / 0.6 + rng.normal(0.0, 0.16, count)
    start = direction + upright * 1.05 + (1 - upright) * (0.30 + lean)
    end = direction + upright * 0.55 + (1 - upright) * (0.5 * lean - 0.05)
    limit = np.clip(0.45 * thickness / brows["thickness_mm"] + 0.55, 0.5, 1.0)
    length = brows["strand_mm"] * rng.uniform(0.55, 1.1, count) * limit
    length = np.minimum(length, 2.2 + 1.3 * thickness)
    steps = (np.arange(_STRAND_POINTS - 1) + 0.5) / (_STRAND_POINTS - 1)
    angle = start[:, None] + (end - start)[:, None] * steps
    step = (length / (_STRAND_POINTS - 1))[:, None]
    moves = np.stack([step * np.cos(angle), step * np.sin(angle)], axis=-1)
    backwards = (1 - upright)[:, None] * 0.45 * moves.sum(axis=1)
    path = np.concatenate([np.zeros((count, 1, 2)), np.cumsum(moves, axis=1)], axis=1)
    return np.asarray(root[:, None] - backwards[:, None] + path)


def draw_brows(brows: Brows, rng: Generator) -> NDArray[np.uint8]:
    """Draw both eyebrows.

    Args:
        brows: As :func:`sample_brows` draws them.
        rng: Source of randomness.

    Returns:
        The opacity of hair over skin on ``CANVAS``, ``(H, W)`` uint8, 0..255.
    """
    right = brows.copy()
    right["height_mm"] += brows["unevenness_mm"]
    right["arch_mm"] = max(0.0, brows["arch_mm"] + 0.6 * brows["unevenness_mm"])
    strands = [brow_strands(brows, rng), brow_strands(right, rng) * (-1.0, 1.0)]
    if brows["bridge"] > 0:
        strands.append(_bridge_strands(brows, rng))
    hairs = np.concatenate(strands)
    rng.shuffle(hairs)
    sheet = CANVAS.blank()
    CANVAS.draw_strands(sheet, hairs, (150, 195, 225, 250))
    blurred = cv2.GaussianBlur(sheet, (0, 0), _BASE_BLUR_PX)
    shade = min(0.95, 0.62 + 0.22 * brows["density"])
    merged = cv2.max(sheet, cv2.convertScaleAbs(blurred, alpha=1.25 * shade))
    return np.asarray(merged, dtype=np.uint8)


def _bridge_strands(brows: Brows, rng: Generator) -> FloatArray:
    count = max(1, round(90 * brows["bridge"]))
    x = rng.uniform(-brows["start_mm"], brows["start_mm"], count)
    y = BASE_HEIGHT_MM + brows["height_mm"] - 1.5 + rng.normal(0.0, 1.6, count)
    angle = 0.5 * np.pi - 0.9 * x / brows["start_mm"] + rng.normal(0.0, 0.2, count)
    length = rng.uniform(2.0, 4.5, count)
    steps = np.linspace(0.0, 1.0, _STRAND_POINTS)
    move = np.stack([np.cos(angle), np.sin(angle)], axis=-1) * length[:, None]
    return np.asarray(np.stack([x, y], axis=-1)[:, None] + steps[:, None] * move[:, None])
