"""Which pigments does skin hold?"""

from typing import TypedDict

import numpy as np
from numpy.random import Generator
from numpy.typing import ArrayLike

MELANIN_LIMITS = (0.009, 0.32)
BLOOD_LIMITS = (0.013, 0.05)
"""Volume fractions that people's means are kept within."""

_MELANIN_MEANS = (0.22, 0.045, 0.022)
_BLOOD_MEAN = 0.022


class Complexion(TypedDict):
    """Pigments of the skin: means as volume fractions, the rest as changes of their logarithms."""

    melanin: float
    blood: float
    melanin_mottle: float
    blood_mottle: float
    cheeks: float
    nose: float
    ears: float
    lids: float
    chin: float
    forehead: float
    dark_circles: float
    tan: float
    lip_fading: float


def sample_complexion(rng: Generator, *, age: float, ancestry: ArrayLike) -> Complexion:
    """Draw the pigments of a person's skin.

    Args:
        rng: Source of randomness.
        age: 0 (25 years) to 1 (old): darker circles under the eyes, uneven pigment, paler lips.
        ancestry: ``(3,)`` shares of African, Asian and European ancestry, summing to 1.

    Returns:
        Plain numbers.
    """
    mean = np.asarray(ancestry, dtype=np.float64) @ np.log(_MELANIN_MEANS)
    melanin = np.exp(mean + rng.normal(0.0, 0.35))
    blood = _BLOOD_MEAN * np.exp(rng.normal(0.0, 0.35))
    flush = float(np.exp(rng.normal(0.0, 0.45)))
    return {
        "melanin": float(np.clip(melanin, *MELANIN_LIMITS)),
        "blood": float(np.clip(blood, *BLOOD_LIMITS)),
        "melanin_mottle": float(rng.uniform(0.5, 1.5) * (1 + 0.5 * age)),
        "blood_mottle": float(rng.uniform(0.5, 1.7)),
        "cheeks": float(0.42 * flush * rng.uniform(0.3, 1.5)),
        "nose": float(0.27 * flush * rng.uniform(0.3, 1.4)),
        "ears": float(rng.uniform(0.15, 0.6)),
        "lids": float(rng.uniform(0.1, 0.5)),
        "chin": float(rng.uniform(0.0, 0.35)),
        "forehead": float(rng.uniform(-0.25, 0.1)),
        "dark_circles": float(np.clip(rng.normal(0.15 + 0.2 * age, 0.17), 0.0, 0.55)),
        "tan": float(rng.uniform(-0.1, 0.25)),
        "lip_fading": float(age * rng.uniform(0.15, 0.6)),
    }
