"""Which lashes shade the eyes? Thin opaque hairs that curve away from the margins of the lids."""

from typing import TypedDict

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from lrsr.identities.face.eyes import Eyes

Points = NDArray[np.float64]

_COUNTS = (64, 40)
"""Hairs on an upper and on a lower lid."""
_PER_LASH = 5  # two corners at the root, two at the bend, the tip
_ROOT_MM = 0.25  # how far before the eyeball the skin carries them


class Lashes(TypedDict):
    """One person's lashes; lengths in mm."""

    length_mm: float
    width_mm: float
    curl: float
    lower: float


def sample_lashes(rng: Generator, *, masculinity: float) -> Lashes:
    """Draw a person's lashes: women's are longer and stronger, with mascara or without.

    Args:
        rng: Source of randomness.
        masculinity: 0 (female) to 1 (male).

    Returns:
        Plain numbers: length of the longest, mean width of what is seen of one (hairs stick
        together), how far they bend upwards, and the share of the length that lower ones have.
    """
    m = float(masculinity)
    return {
        "length_mm": float(np.clip(rng.normal(9.2 - 3.0 * m, 0.9), 4.0, 11.5)),
        "width_mm": float(np.clip(rng.normal(0.27 - 0.17 * m, 0.03), 0.06, 0.34)),
        "curl": float(rng.uniform(0.55, 1.0)),
        "lower": float(rng.uniform(0.35, 0.55)),
    }


def lash_faces() -> NDArray[np.int32]:
    """Return the triangles of all lashes: ``(F, 3)`` int32, the same for everyone."""
    first = _PER_LASH * np.arange(2 * sum(_COUNTS))[:, None, None]
    hair = np.array([[0, 1, 3], [0, 3, 2], [2, 3, 4]])
    return np.asarray((first + hair).reshape(-1, 3), dtype=np.int32)


def place_lashes(
    margins: Points, eyes: Eyes, lashes: Lashes, rng: Generator
) -> NDArray[np.float32]:
    """Set lashes on the lids.

    Args:
        margins: ``(2, 2, n, 3)``, mm, as :func:`lrsr.identities.face.lids.lid_margins` gives them.
        eyes: The eyes, in the same axes.
        lashes: As :func:`sample_lashes` draws them.
        rng: Source of randomness of the single hairs.

    Returns:
        ``(5 N, 3)`` float32, mm, in the order of :func:`lash_faces`.
    """
    corners = []
    for which in (0, 1):
        for lid, count in enumerate(_COUNTS):
            share = 1.0 if lid == 0 else lashes["lower"]
            hairs = _place_row(
                margins[which, lid], eyes.centres[which], count, 1 - 2 * lid, share, lashes, rng
            )
            corners.append(hairs.reshape(-1, 3))
    return np.concatenate(corners).astype(np.float32)


def _place_row(
    margin: Points,
    centre: Points,
    count: int,
    up: int,
    share: float,
    lashes: Lashes,
    rng: Generator,
) -> Points:
    """Set the hairs of one lid: ``(count, 5, 3)``."""
    along = np.linspace(0.10, 0.985, count) + rng.normal(0.0, 0.3 / count, count)
    place = np.clip(along, 0.0, 1.0) * (len(margin) - 1)
    knots = np.arange(len(margin))
    root = np.stack([np.interp(place, knots, margin[:, k]) for k in range(3)], axis=-1)
    outwards = _unit(root - centre)
    tangent = np.stack(
        [np.interp(place, knots, np.gradient(margin[:, k])) for k in range(3)], axis=-1
    )
    tangent = _unit(tangent)
    away = _unit(np.array([0.0, 1.0, 0.0]) - outwards[:, 1:2] * outwards) * up
    # Longest before the outer third; they fan out towards both corners.
    longest = 0.55 + 0.45 * np.sin(np.pi * np.clip((along + 0.1) / 1.35, 0, 1))
    length = (share * lashes["length_mm"] * longest * rng.uniform(0.7, 1.05, count))[:, None]
    fan = ((along - 0.38) * 1.1 + rng.normal(0.0, 0.10, count))[:, None]
    root = root + _ROOT_MM * outwards
    start = _unit(outwards + 0.25 * away + 0.5 * fan * tangent)
    end = _unit(0.7 * outwards + lashes["curl"] * away + fan * tangent)
    bend = root + 0.5 * length * start
    tip = bend + 0.5 * length * end
    half = 0.5 * lashes["width_mm"] * tangent
    return np.stack([root - half, root + half, bend - 0.7 * half, bend + 0.7 * half, tip], axis=1)


def _unit(vectors: Points) -> Points:
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.maximum(lengths, 1e-9))
