"""Which pigments does skin hold?"""

from typing import TypedDict

import numpy as np
from numpy.random import Generator
from numpy.typing import ArrayLike

MELANIN_LIMITS = (0.003, 0.33)
_BLOOD_LIMITS = (0.008, 0.062)
"""Volume fractions that people's means are kept within."""

_MELANIN_MEANS = (0.21, 0.030, 0.0080)
"""Of African, Asian and European ancestry, set so that the typology angles of cheeks have medians
of about -20, 28 and 41 degrees (faces are some 10 degrees darker than arms are)."""
_SEX = 0.15  # of the logarithm: 2 to 4 percent of reflectance between the sexes
_BLOOD_MEAN = 0.022
_MOST_FLUSH = 0.6  # a cheek of more is a clown's


class Complexion(TypedDict):
    """Pigments of the skin: means as volume fractions, the rest as changes of their logarithms.

    ``carotene`` is the optical depth of yellow pigment for blue light: what makes an undertone
    golden or olive. ``perioral``, ``orbits`` and ``sides`` are what the skin around the mouth, in
    the sockets of the eyes and from the temples to the jaw is darker by.
    """

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
    carotene: float
    perioral: float
    orbits: float
    sides: float


def sample_complexion(
    rng: Generator, *, masculinity: float, age: float, ancestry: ArrayLike
) -> Complexion:
    """Draw the pigments of a person's skin.

    Women are lighter than men everywhere (Jablonski and Chaplin, "The evolution of human skin
    coloration", J. Hum. Evol. 39, 2000).

    Args:
        rng: Source of randomness.
        masculinity: 0 (female) to 1 (male).
        age: 0 (25 years) to 1 (old): darker circles under the eyes, uneven pigment, paler lips.
        ancestry: ``(3,)`` shares of African, Asian and European ancestry, summing to 1.

    Returns:
        Plain numbers.
    """
    shares = np.asarray(ancestry, dtype=np.float64)
    mean = shares @ np.log(_MELANIN_MEANS)
    melanin = np.exp(mean + _SEX * (2.0 * masculinity - 1.0) + rng.normal(0.0, 0.58))
    blood = _BLOOD_MEAN * np.exp(rng.normal(0.0, 0.65))
    flush = float(np.exp(rng.normal(0.0, 0.6)))
    return {
        "melanin": float(np.clip(melanin, *MELANIN_LIMITS)),
        "blood": float(np.clip(blood, *_BLOOD_LIMITS)),
        "melanin_mottle": float(rng.uniform(0.5, 2.0) * (1 + 0.8 * age)),
        "blood_mottle": float(rng.uniform(0.5, 2.3)),
        "cheeks": _soften(0.36 * flush * rng.uniform(0.3, 1.5)),
        "nose": _soften(0.33 * flush * rng.uniform(0.3, 1.4)),
        "ears": float(rng.uniform(0.15, 0.6)),
        "lids": float(rng.uniform(0.1, 0.5)),
        "chin": float(rng.uniform(-0.1, 0.45)),
        "forehead": float(rng.uniform(-0.35, 0.2)),
        "dark_circles": float(np.clip(rng.normal(0.06 + 0.36 * age, 0.22), 0.0, 0.8)),
        "tan": float(rng.uniform(-0.1, 0.25)),
        "lip_fading": float(age * rng.uniform(0.3, 0.8)),
        "carotene": float(np.clip(rng.normal(0.04 + 0.06 * shares[1], 0.09), -0.10, 0.24)),
        "perioral": float(np.clip(rng.normal(0.08, 0.25), -0.4, 0.6)),
        "orbits": float(np.clip(rng.normal(0.06 + 0.18 * age, 0.28), -0.4, 0.7)),
        "sides": float(rng.normal(0.08, 0.24)),
    }


def _soften(flush: float) -> float:
    """Let large values approach ``_MOST_FLUSH``."""
    return float(_MOST_FLUSH * np.tanh(flush / _MOST_FLUSH))
