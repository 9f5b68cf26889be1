"""Which colour are lips, and what is put on a face?"""

from typing import TypedDict

import numpy as np
from numpy.random import Generator

_BERRY, _RED, _ROSE = np.array([[0.20, 0.03, 0.06], [0.36, 0.035, 0.045], [0.48, 0.16, 0.16]])
_EYESHADOWS = ((0.10, 0.05, 0.035), (0.06, 0.06, 0.08), (0.22, 0.09, 0.10))


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
