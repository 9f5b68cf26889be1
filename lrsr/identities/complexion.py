"""Which pigments do skin and lips hold, and what is put on them?"""

from typing import TypedDict

import numpy as np
from numpy.random import Generator
from numpy.typing import ArrayLike

MELANIN_LIMITS = (0.009, 0.32)
BLOOD_LIMITS = (0.013, 0.05)
"""Volume fractions that people's means are kept within."""

_MELANIN_MEANS = (0.22, 0.045, 0.022)
_BLOOD_MEAN = 0.022

_BERRY, _RED, _ROSE = np.array([[0.20, 0.03, 0.06], [0.36, 0.035, 0.045], [0.48, 0.16, 0.16]])
_EYESHADOWS = ((0.10, 0.05, 0.035), (0.06, 0.06, 0.08), (0.22, 0.09, 0.10))


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


class Lips(TypedDict):
    """Natural lips by their pigments, as changes of the logarithms of the skin's."""

    blood: float
    melanin: float


class MakeUp(TypedDict):
    """Opacities, [0, 1], and colours (three numbers, linear sRGB) of what is put on the skin."""

    lipstick: float
    lipstick_colour: list[float]
    eyeliner: float
    eyeshadow: float
    eyeshadow_colour: list[float]


def sample_complexion(rng: Generator, *, age: float, ancestry: ArrayLike) -> Complexion:
    """Draw the pigments of a person's skin.

    Args:
        rng: Source of randomness.
        age: 0 (25 years) to 1 (old): darker circles under the eyes.
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
        "melanin_mottle": float(rng.uniform(0.6, 1.5)),
        "blood_mottle": float(rng.uniform(0.6, 1.5)),
        "cheeks": float(0.42 * flush * rng.uniform(0.3, 1.5)),
        "nose": float(0.38 * flush * rng.uniform(0.3, 1.4)),
        "ears": float(rng.uniform(0.15, 0.6)),
        "lids": float(rng.uniform(0.1, 0.5)),
        "chin": float(rng.uniform(0.0, 0.35)),
        "forehead": float(rng.uniform(-0.25, 0.1)),
        "dark_circles": float(np.clip(rng.normal(0.15 + 0.2 * age, 0.17), 0.0, 0.55)),
        "tan": float(rng.uniform(-0.1, 0.25)),
    }


def sample_lips(rng: Generator) -> Lips:
    """Draw a person's natural lips: a little or much redder than the skin.

    Args:
        rng: Source of randomness.

    Returns:
        Plain numbers.
    """
    return {"blood": float(rng.uniform(0.6, 1.7)), "melanin": float(rng.uniform(0.0, 0.35))}


def sample_make_up(rng: Generator, *, masculinity: float) -> MakeUp:
    """Draw a person's make-up; from a masculinity of 0.5 on there is none.

    Args:
        rng: Source of randomness.
        masculinity: 0 (female) to 1 (male).

    Returns:
        Plain numbers.
    """
    wears = (1 - masculinity) ** 2 if masculinity < 0.5 else 0.0
    low, high = (_RED, _ROSE) if rng.random() < 0.7 else (_BERRY, _RED)
    lipstick = low + (high - low) * rng.random()
    return {
        "lipstick": float(rng.uniform(0.45, 0.9)) if rng.random() < 0.42 * wears else 0.0,
        "lipstick_colour": [float(channel) for channel in lipstick],
        "eyeliner": float(rng.uniform(0.3, 0.95)) if rng.random() < 0.45 * wears else 0.0,
        "eyeshadow": float(rng.uniform(0.2, 0.6)) if rng.random() < 0.25 * wears else 0.0,
        "eyeshadow_colour": list(_EYESHADOWS[rng.integers(len(_EYESHADOWS))]),
    }
