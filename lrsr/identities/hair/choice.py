"""Which hair does a person wear? A style drawn by sex, age and ancestry, and its colour."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lrsr.identities.hair.styles import STYLES, style_parameters
from lrsr.identities.ramp import smoothstep
from lrsr.identities.skin.hair_colour import HairColour, hair_rgb

# Weights of the styles: (men, women). Ancestry and age change them in _style_weights.
_WEIGHTS: dict[str, tuple[float, float]] = {
    "shaved": (0.9, 0.0),
    "buzz": (1.5, 0.03),
    "crop": (2.0, 0.05),
    "side_parting": (1.8, 0.06),
    "receding": (0.9, 0.0),
    "horseshoe": (0.5, 0.0),
    "quiff": (1.4, 0.02),
    "slicked_back": (0.9, 0.05),
    "curly": (1.1, 0.06),
    "long_curly": (0.04, 0.45),
    "afro": (0.25, 0.2),
    "pixie": (0.25, 0.2),
    "curtain": (0.35, 0.2),
    "bob": (0.03, 1.6),
    "long_straight": (0.12, 1.9),
    "long_wavy": (0.12, 2.2),
    "fringe": (0.02, 1.0),
    "tucked": (0.15, 0.8),
    "pulled_back": (0.12, 0.25),
}

_HAIRLINE_DEG = (-1.5, 1.5)
"""What the hairline of women and of men lies above the middle of the styles' ranges, degrees."""


def sample_hair(
    rng: np.random.Generator,
    masculinity: float,
    age: float,
    ancestry: Mapping[str, float],
    colour: HairColour,
) -> dict[str, Any]:
    """Draw the hair of one person.

    Args:
        rng: The only source of chance.
        masculinity: 0 (female) to 1 (male).
        age: 0 (25 years) to 1 (old).
        ancestry: Shares of "african", "asian" and "caucasian", summing to 1.
        colour: The person's hair pigments.

    Returns:
        Plain numbers, strings and lists: ``style``, ``hair_colour`` (pigmented strands, linear RGB,
        0..1), ``grey`` (share of grey strands, 0..1) and the numbers of the style.
    """
    total = sum(ancestry.values())  # rounding may have left a little more or less than 1
    african, asian = ancestry["african"] / total, ancestry["asian"] / total
    weights = _style_weights(masculinity, age, african, asian)
    style = STYLES[int(rng.choice(len(STYLES), p=weights))]
    parameters = style_parameters(style, rng)
    male = _sex(masculinity)
    parameters["hairline_deg"] *= 0.7
    parameters["hairline_deg"] += (1.0 - male) * _HAIRLINE_DEG[0] + male * _HAIRLINE_DEG[1]
    parameters["recession_deg"] *= 0.4 + 0.6 * male
    ageing = max(age - 0.25, 0.0) * (0.2 + 0.8 * male)
    if style not in ("receding", "horseshoe"):
        parameters["hairline_deg"] += 7.0 * ageing * float(rng.uniform(0.2, 1.0))
        parameters["recession_deg"] += 14.0 * ageing * float(rng.uniform(0.0, 1.0)) + 2.0 * male
    if style not in ("shaved", "afro"):
        for key, gain in (("curl_mm", 2.5), ("clump_mm", 0.8), ("wave_mm", 1.5)):
            parameters[key] += gain * african * float(rng.uniform(0.4, 1.0))
    return parameters | colour_parameters(colour)


def colour_parameters(colour: HairColour) -> dict[str, Any]:
    """Return ``hair_colour`` (pigmented strands, linear RGB, 0..1) and ``grey`` (0..1)."""
    return {
        "hair_colour": [float(c) for c in hair_rgb(colour, grey=0.0)],
        "grey": float(colour["grey"]),
    }


def _sex(masculinity: float) -> float:
    """0 for women and 1 for men, whatever the degree; in between at 0.3 to 0.7."""
    return float(smoothstep(0.3, 0.7, np.asarray(masculinity)))


def _style_weights(
    masculinity: float, age: float, african: float, asian: float
) -> NDArray[np.float64]:
    male = _sex(masculinity)
    weights = {s: male * men + (1.0 - male) * women for s, (men, women) in _WEIGHTS.items()}
    weights["afro"] *= 0.03 + (6.0 + 3.0 * male) * african**2
    for style in ("curly", "long_curly"):
        weights[style] *= 0.5 + 2.2 * african + 0.3 * (1.0 - asian)
    weights["long_straight"] *= 1.0 + 2.0 * african * (1.0 - male)  # straightened, or extensions
    factors = (
        (1.0 + 0.8 * african, ("buzz", "shaved")),
        (1.0 - 0.65 * african, ("side_parting", "quiff", "curtain", "bob", "tucked")),
        (1.0 - 0.65 * african, ("long_straight", "fringe")),
        (1.0 + 0.5 * asian, ("fringe", "long_straight")),
        (0.1 + 2.4 * age, ("receding", "horseshoe")),
        (1.0 + 1.2 * age, ("pixie", "bob")),
        (1.0 + 0.8 * age, ("pulled_back", "curly")),
        (1.3 - 1.15 * age, ("fringe", "long_straight")),
        (1.2 - 0.7 * age, ("long_wavy", "tucked")),
        (1.3 - age, ("quiff", "curtain", "afro", "long_wavy")),
    )
    for factor, styles in factors:
        for style in styles:
            weights[style] *= factor
    values: NDArray[np.float64] = np.array([weights[s] for s in STYLES])
    return np.asarray(values / values.sum())
