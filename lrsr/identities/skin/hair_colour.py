"""Which colour is hair? Two melanins colour it, age takes them away.

The ratio of the channels follows the absorption of eumelanin and pheomelanin in hair (Chiang et
al., "A practical and controllable hair and fur model for production path tracing", 2016, with
the coefficients of d'Eon et al. 2011); the strength is set for strands drawn as flat colour, which
hold the light that real, overlapping fibres scatter back.
"""

from typing import TypedDict

import numpy as np
from numpy.random import Generator
from numpy.typing import ArrayLike, NDArray

_EUMELANIN_ABSORPTION = np.array([0.419, 0.697, 1.37])
_PHEOMELANIN_ABSORPTION = np.array([0.187, 0.4, 1.05])
_DEPTH = np.array([3.2, 3.45, 3.65])
_SURFACE = 0.009
_DYED = 0.12
_GREY_DYED = 0.25  # of women whose hair turns grey
_WHITE = np.array([0.47, 0.46, 0.44])


class HairColour(TypedDict):
    """Pigments of one person's hair and how much of it has gone white."""

    eumelanin: float
    pheomelanin: float
    grey: float


def sample_hair_colour(
    rng: Generator, *, age: float, ancestry: ArrayLike, masculinity: float = 1.0
) -> HairColour:
    """Draw a person's hair pigments.

    Args:
        rng: Source of randomness.
        age: 0 (25 years) to 1 (old): hair turns grey.
        ancestry: ``(3,)`` shares of African, Asian and European ancestry, summing to 1.
        masculinity: 0 (female) to 1 (male): below 0.5 some dye what would be grey.

    Returns:
        Plain numbers; eumelanin 0.2 is fair, 1.3 brown, 7 black.
    """
    african, asian, european = np.asarray(ancestry, dtype=np.float64)
    mean = african * np.log(7.0) + asian * np.log(6.0) + european * np.log(0.95)
    spread = 0.3 + 0.75 * european
    eumelanin = np.exp(rng.normal(mean, spread))
    pheomelanin = 0.15 * np.exp(rng.normal(0.0, 0.7))
    if rng.random() < 0.1 * european**2:
        eumelanin, pheomelanin = rng.uniform(0.08, 0.5), rng.uniform(0.7, 1.6)
    elif rng.random() < 0.2 * european**2:
        eumelanin = np.exp(rng.uniform(np.log(0.1), np.log(0.5)))
    elif rng.random() < _DYED * (1.0 - african):
        eumelanin, pheomelanin = _dye(rng, eumelanin)
    onset = 0.60 - 0.08 * european
    grey = np.clip(rng.normal(2.1 * (age - onset), 0.2), 0.0, 1.0) if age > 0.15 else 0.0
    if grey > 0.1 and masculinity < 0.5 and rng.random() < _GREY_DYED:
        grey, (eumelanin, pheomelanin) = 0.08 * grey, _dye(rng, min(eumelanin, 3.0))
    return {
        "eumelanin": float(np.clip(eumelanin, 0.05, 9.0)),
        "pheomelanin": float(np.clip(pheomelanin, 0.02, 1.8)),
        "grey": float(grey),
    }


def _dye(rng: Generator, eumelanin: float) -> tuple[float, float]:
    """Colour hair a few shades lighter or darker, from honey to dark auburn."""
    lighter = eumelanin * np.exp(rng.uniform(-1.6, 0.2))
    return max(lighter, 0.35), float(rng.uniform(0.1, 0.7))


def hair_rgb(colour: HairColour, *, darker: float = 1.0, grey: float = 1.0) -> NDArray[np.float32]:
    """Colour of the hair.

    Args:
        colour: As :func:`sample_hair_colour` draws it.
        darker: Multiplies the pigments; brows and beards are darker than the hair of the head.
        grey: Multiplies the share of white hairs; brows turn grey later.

    Returns:
        ``(3,)`` float32, linear sRGB.

    Example:
        >>> hair_rgb({"eumelanin": 1.3, "pheomelanin": 0.1, "grey": 0.0}).round(2)
        array([0.1 , 0.04, 0.02], dtype=float32)
    """
    absorption = darker * (
        colour["eumelanin"] * _EUMELANIN_ABSORPTION
        + colour["pheomelanin"] * _PHEOMELANIN_ABSORPTION
    )
    pigmented = _SURFACE + np.exp(-_DEPTH * np.sqrt(absorption))
    share = min(1.0, grey * colour["grey"])
    return np.asarray(pigmented + share * (_WHITE - pigmented), dtype=np.float32)
