"""Which colour are lips, and what is put on a face?"""

from typing import TypedDict

import numpy as np
from numpy.random import Generator

_LIPSTICKS = {
    "nude": (0.30, 0.115, 0.090),
    "rose": (0.34, 0.095, 0.095),
    "mauve": (0.26, 0.080, 0.088),
    "coral": (0.38, 0.110, 0.075),
    "brick": (0.24, 0.060, 0.045),
    "red": (0.33, 0.040, 0.045),
    "berry": (0.19, 0.035, 0.055),
    "plum": (0.14, 0.040, 0.055),
}
"""Colours on fair skin, linear sRGB; most people choose one near that of their lips."""

_LIPSTICK_SHARES = (0.22, 0.24, 0.16, 0.11, 0.13, 0.06, 0.05, 0.03)
_EYESHADOWS = ((0.09, 0.045, 0.03), (0.05, 0.045, 0.055), (0.16, 0.07, 0.075))


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
    blush: float


def sample_lips(rng: Generator, *, masculinity: float, melanin: float) -> Lips:
    """Draw a person's natural lips: redder than the skin, browner where that is dark.

    The contrast of lips and skin is larger in women (Russell, "A sex difference in facial contrast
    and its exaggeration by cosmetics", Perception 38, 2009).

    Args:
        rng: Source of randomness.
        masculinity: 0 (female) to 1 (male).
        melanin: Of the skin, a volume fraction.

    Returns:
        Plain numbers.
    """
    dark = float(np.clip(np.log(melanin / 0.03) / 2.0, 0.0, 1.0))
    least, most = 1.3 - 0.5 * masculinity, 2.1 - 0.7 * masculinity
    return {
        "blood": float(rng.uniform(least, most)) * (1 - 0.25 * dark),
        "melanin": float(rng.uniform(0.15, 0.5)) + dark * float(rng.uniform(-0.25, 0.35)),
    }


def sample_make_up(rng: Generator, *, masculinity: float, age: float) -> MakeUp:
    """Draw a person's make-up; from a masculinity of 0.5 on there is none.

    Args:
        rng: Source of randomness.
        masculinity: 0 (female) to 1 (male).
        age: 0 (25 years) to 1 (old): put on more sparingly.

    Returns:
        Plain numbers.
    """
    wears = (1 - masculinity) ** 2 if masculinity < 0.5 else 0.0
    shade = list(_LIPSTICKS.values())[rng.choice(len(_LIPSTICKS), p=_LIPSTICK_SHARES)]
    tint = np.exp(rng.normal(0.0, 0.12, 3))

    def opacity(share: float, low: float, high: float, fades: float) -> float:
        worn = rng.random() < share * wears
        return float(rng.uniform(low, high)) * (1 - fades * age) if worn else 0.0

    return {
        "lipstick": opacity(0.5, 0.2, 0.5, 0.15),
        "lipstick_colour": [float(channel) for channel in np.asarray(shade) * tint],
        "eyeliner": opacity(0.95, 0.45, 0.95, 0.35),
        "eyeshadow": opacity(0.40, 0.10, 0.35, 0.5),
        "eyeshadow_colour": list(_EYESHADOWS[rng.integers(len(_EYESHADOWS))]),
        "blush": opacity(0.40, 0.08, 0.24, 0.5),
    }
