"""What eyebrows does a person wear? Hairs along an arch, each of which lets some skin through."""

from typing import TypedDict

import cv2
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from lrsr.identities.skin.canvas import (
    STRAND_POINTS,
    SUBPIXEL_BITS,
    Canvas,
    bend_strands,
    draw_corners,
)

_FloatArray = NDArray[np.float64]

CANVAS = Canvas(left_mm=-66.0, top_mm=48.0, width_mm=132.0, height_mm=52.0)
"""The part of the frontal sheet that brows may cover."""

_BASE_HEIGHT_MM = 14.9
"""Height of people's brows over the pupils, on the template; ``height_mm`` is counted from here."""

_STRANDS = 420
_REFERENCE_THICKNESS_MM = 4.2
_LAYERS = 8  # hairs of different layers cover each other in part
_HAIR_LEVELS = (84, 108, 132, 156)  # opacity of a hair drawn one pixel (0.2 mm) wide, of 255
_SHADE_BLUR_MM = 1.1
_SHADE = 0.55


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
    sparse_tail: float
    unevenness_mm: float


def sample_brows(rng: Generator, *, masculinity: float, age: float) -> Brows:
    """Draw a person's eyebrows.

    Args:
        rng: Source of randomness.
        masculinity: 0 (female) to 1 (male): men's brows are thicker, lower and flatter.
        age: 0 (25 years) to 1 (old): women's thin out (Porcheron et al., "Aspects of facial
            contrast decrease with age and are cues for age perception", PLoS ONE 8, 2013).

    Returns:
        Plain numbers.
    """
    m = float(masculinity)
    thickness = float(np.clip(rng.normal(3.55 + 3.65 * m, 0.85 + 0.35 * m), 2.6, 10.0))
    return {
        "start_mm": float(np.clip(rng.normal(17.5 - 1.5 * m, 2.4), 9.0, 22.0)),
        "end_mm": float(np.clip(rng.normal(51.0, 3.8), 42.0, 60.0)),
        "height_mm": float(np.clip(rng.normal(1.9 - 2.7 * m, 0.9), -1.8, 4.0)),
        "arch_mm": float(0.3 + 5.0 * rng.beta(2.0 - 0.7 * m, 1.8 + 1.8 * m)),
        "peak": float(rng.uniform(0.44, 0.82)),
        "slope_mm": float(np.clip(rng.normal(-0.4 - 0.4 * m, 1.3), -3.0, 1.4)),
        "tail_mm": float(rng.uniform(0.8, 5.5)),
        "thickness_mm": thickness,
        "taper": float(rng.uniform(0.4, 1.1)),
        "density": float(
            np.clip(np.exp(rng.normal(0.15 + 0.35 * m - 0.4 * age * (1 - m), 0.45)), 0.6, 4.0)
        ),
        "strand_mm": float(rng.uniform(4.5, 8.0)),
        "bridge": float(rng.uniform(0.15, 0.7)) if rng.random() < 0.005 + 0.03 * m else 0.0,
        "unevenness_mm": float(rng.normal(0.0, 0.45)),
        "sparse_tail": float(rng.beta(1.2, 2.0)),
    }


def _brow_line(brows: Brows, along: _FloatArray) -> _FloatArray:
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
        _BASE_HEIGHT_MM
        + brows["height_mm"]
        + brows["arch_mm"] * (np.sin(0.5 * np.pi * rise) - 0.85 * fall**1.7)
        + brows["slope_mm"] * (along - 0.4)
        - brows["tail_mm"] * fall**1.5
        - 0.35 * brows["arch_mm"]
    )
    return np.stack([x, y], axis=-1)


def _brow_thickness(brows: Brows, along: _FloatArray) -> _FloatArray:
    """Vertical extent of the brow.

    Args:
        brows: As :func:`sample_brows` draws them.
        along: ``(...)``, 0 at the nose, 1 at the temple.

    Returns:
        ``(...)``, mm.
    """
    tip = np.clip((1 - along) / 0.7, 0, 1) ** brows["taper"]
    head = 0.70 + 0.30 * np.clip(along / 0.25, 0, 1)
    return np.asarray(brows["thickness_mm"] * np.maximum(tip * head, 0.10))


def _brow_strands(brows: Brows, rng: Generator) -> _FloatArray:
    """Lay the hairs of one brow, on the subject's left.

    At the nose they stand up, towards the temple they lie along the line; the upper ones lean
    down and the lower ones up, so that they meet in the middle.

    Args:
        brows: As :func:`sample_brows` draws them.
        rng: Source of randomness.

    Returns:
        ``(N, 4, 2)``, mm; N = 420 x density x thickness / 4.2 mm.
    """
    usual = _STRANDS * brows["density"] * brows["thickness_mm"] / _REFERENCE_THICKNESS_MM
    count = max(20, round(usual))
    along = rng.beta(1.5, 1.25, count)
    # The first hairs stand singly before the others, and tails thin out.
    along -= np.clip(rng.exponential(0.03, count), 0, 0.09) * np.clip(1 - along / 0.2, 0, 1)
    gone = brows["sparse_tail"] * np.clip((along - 0.5) / 0.5, 0, 1)
    along = np.where(rng.random(count) < gone, 0.85 * rng.random(count), along)
    # Hairs gather in tufts.
    across = np.clip(rng.normal(0.0, 0.3, count), -0.6, 0.6)
    along += 0.006 * np.sin(along * (55.0 + 7.0 * np.sin(9.0 * across)) + 4.0 * across)
    thickness = _brow_thickness(brows, along)
    root = _brow_line(brows, along)
    root[:, 1] += across * thickness
    ahead = _brow_line(brows, along + 0.01) - _brow_line(brows, along)
    direction = np.arctan2(ahead[:, 1], ahead[:, 0])
    upright = np.clip(1 - along / 0.30, 0, 1) ** 0.8
    lean = -0.70 * across / 0.6 + rng.normal(0.0, 0.18, count)
    stand = 1.25 + rng.normal(0.0, 0.15, count)
    start = direction + upright * stand + (1 - upright) * (0.30 + lean)
    end = direction + upright * 0.75 + (1 - upright) * (0.5 * lean - 0.05)
    limit = np.clip(0.45 * thickness / brows["thickness_mm"] + 0.55, 0.5, 1.0)
    length = brows["strand_mm"] * rng.uniform(0.55, 1.1, count) * limit
    length = np.minimum(length, 2.2 + 1.3 * thickness)
    path = bend_strands(length, start, end - start)
    backwards = (1 - upright)[:, None] * 0.45 * path[:, -1]
    return np.asarray(root[:, None] - backwards[:, None] + path)


def lay_brows(brows: Brows, rng: Generator) -> _FloatArray:
    """Lay the hairs of both brows, in random order.

    Args:
        brows: As :func:`sample_brows` draws them.
        rng: Source of randomness.

    Returns:
        ``(N, 4, 2)``, mm.
    """
    right = brows.copy()
    right["height_mm"] += brows["unevenness_mm"]
    right["arch_mm"] = max(0.0, brows["arch_mm"] + 0.6 * brows["unevenness_mm"])
    strands = [_brow_strands(brows, rng), _brow_strands(right, rng) * (-1.0, 1.0)]
    if brows["bridge"] > 0:
        strands.append(_bridge_strands(brows, rng))
    hairs = np.concatenate(strands)
    order = np.arange(len(hairs))
    rng.shuffle(order)
    return hairs[order]


def cover_brows(hairs: _FloatArray) -> NDArray[np.uint8]:
    """Draw hairs over each other, with the shade that they throw between them.

    Args:
        hairs: ``(N, 4, 2)``, mm.

    Returns:
        Opacity on ``CANVAS``, ``(H, W)`` uint8, 0..255.
    """
    clear = np.full(CANVAS.shape, 255, dtype=np.uint8)
    corners = CANVAS.to_corners(hairs)
    low, high = np.clip((corners[..., 1].min(), corners[..., 1].max()), 0, None) >> SUBPIXEL_BITS
    band = slice(max(int(low) - 2, 0), int(high) + 3)
    faint = [int(0.6 * level) for level in _HAIR_LEVELS]
    for layer in range(_LAYERS):
        sheet = CANVAS.blank()
        part = corners[layer::_LAYERS]
        draw_corners(sheet, part, faint)
        draw_corners(sheet, part[:, :3], _HAIR_LEVELS)  # towards their tips they are finer
        clear[band] = cv2.multiply(clear[band], cv2.bitwise_not(sheet[band]), scale=1 / 255)
    opacity = cv2.bitwise_not(clear)
    sigma = _SHADE_BLUR_MM / CANVAS.pixel_mm
    shade = cv2.convertScaleAbs(cv2.GaussianBlur(opacity, (0, 0), sigma), alpha=_SHADE)
    clear = cv2.multiply(clear, cv2.bitwise_not(shade), scale=1 / 255)
    return np.asarray(cv2.bitwise_not(clear), dtype=np.uint8)


def _bridge_strands(brows: Brows, rng: Generator) -> _FloatArray:
    count = max(1, round(60 * brows["bridge"]))
    x = rng.uniform(-brows["start_mm"], brows["start_mm"], count)
    y = _BASE_HEIGHT_MM + brows["height_mm"] - 1.5 + rng.normal(0.0, 1.6, count)
    angle = 0.5 * np.pi - 0.9 * x / brows["start_mm"] + rng.normal(0.0, 0.2, count)
    length = rng.uniform(2.0, 4.5, count)
    steps = np.linspace(0.0, 1.0, STRAND_POINTS)
    move = np.stack([np.cos(angle), np.sin(angle)], axis=-1) * length[:, None]
    return np.asarray(np.stack([x, y], axis=-1)[:, None] + steps[:, None] * move[:, None])
