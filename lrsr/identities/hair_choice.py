"""Which hair does a person wear? A style drawn by sex, age and ancestry, and its colour."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lrsr.errors import InputError
from lrsr.identities.hair_colour import HairColour, hair_rgb, sample_hair_colour
from lrsr.identities.hair_styles import STYLES, style_parameters

ANCESTRIES = ("african", "asian", "caucasian")

# Weights of the styles: (men, women). Ancestry and age change them in _style_weights.
_WEIGHTS: dict[str, tuple[float, float]] = {
    "shaved": (1.0, 0.02),
    "buzz": (1.3, 0.08),
    "crop": (1.8, 0.25),
    "side_parting": (1.6, 0.2),
    "receding": (0.9, 0.0),
    "horseshoe": (0.5, 0.0),
    "quiff": (1.2, 0.1),
    "slicked_back": (0.8, 0.3),
    "curly": (0.9, 0.5),
    "afro": (0.15, 0.3),
    "pixie": (0.3, 0.9),
    "curtain": (0.6, 0.4),
    "bob": (0.1, 1.2),
    "long_straight": (0.2, 1.5),
    "long_wavy": (0.2, 1.6),
    "fringe": (0.05, 1.3),
    "tucked": (0.3, 1.1),
    "pulled_back": (0.2, 1.4),
}


def sample_hair(
    rng: np.random.Generator,
    masculinity: float,
    age: float,
    ancestry: Mapping[str, float],
    colour: HairColour | None = None,
) -> dict[str, Any]:
    """Draw the hair of one person.

    Args:
        rng: The only source of chance.
        masculinity: 0 (female) to 1 (male).
        age: 0 (25 years) to 1 (old).
        ancestry: Shares of "african", "asian" and "caucasian", any positive sum.
        colour: The person's hair pigments; drawn here when not given.

    Returns:
        Plain numbers, strings and lists: ``style``, ``hair_colour`` (pigmented strands, linear RGB,
        0..1), ``grey`` (share of grey strands, 0..1) and the numbers of the style.

    Raises:
        InputError: The ancestry has no share of any known kind.
    """
    shares = _shares(ancestry)
    weights = _style_weights(masculinity, age, shares)
    style = STYLES[int(rng.choice(len(STYLES), p=weights))]
    parameters = style_parameters(style, rng)
    ageing = max(age - 0.25, 0.0) * (0.3 + 0.7 * masculinity)
    if style not in ("receding", "horseshoe"):
        parameters["hairline_deg"] += 7.0 * ageing * float(rng.uniform(0.2, 1.0))
        parameters["recession_deg"] += (
            14.0 * ageing * float(rng.uniform(0.0, 1.0)) + 2.0 * masculinity
        )
    curliness = shares["african"]
    if style not in ("shaved", "afro"):
        for key, gain in (("curl_mm", 2.5), ("clump_mm", 0.8), ("wave_mm", 1.5)):
            parameters[key] += gain * curliness * float(rng.uniform(0.4, 1.0))
    if colour is None:
        colour = sample_hair_colour(rng, age=age, ancestry=[shares[name] for name in ANCESTRIES])
    return parameters | colour_parameters(colour)


def colour_parameters(colour: HairColour) -> dict[str, Any]:
    """Return ``hair_colour`` (pigmented strands, linear RGB, 0..1) and ``grey`` (0..1)."""
    return {
        "hair_colour": [float(c) for c in hair_rgb(colour, grey=0.0)],
        "grey": float(colour["grey"]),
    }


def _shares(ancestry: Mapping[str, float]) -> dict[str, float]:
    total = sum(float(ancestry.get(name, 0.0)) for name in ANCESTRIES)
    if not total > 0:
        raise InputError(f"ancestry {dict(ancestry)} has no share of {', '.join(ANCESTRIES)}")
    return {name: float(ancestry.get(name, 0.0)) / total for name in ANCESTRIES}


def _style_weights(
    masculinity: float, age: float, shares: Mapping[str, float]
) -> NDArray[np.float64]:
    weights = {
        s: masculinity * men + (1.0 - masculinity) * women for s, (men, women) in _WEIGHTS.items()
    }
    african, asian = shares["african"], shares["asian"]
    weights["afro"] *= 0.15 + 9.0 * african**2
    weights["curly"] *= 0.5 + 2.2 * african + 0.3 * (1.0 - asian)
    for style in ("buzz", "shaved"):
        weights[style] *= 1.0 + 0.8 * african
    for style in ("side_parting", "quiff", "curtain", "long_straight", "fringe", "bob", "tucked"):
        weights[style] *= 1.0 - 0.65 * african
    for style in ("fringe", "long_straight"):
        weights[style] *= 1.0 + 0.5 * asian
    for style in ("receding", "horseshoe"):
        weights[style] *= 0.1 + 2.4 * age
    for style in ("pixie", "bob"):
        weights[style] *= 1.0 + age
    for style in ("quiff", "curtain", "afro", "long_wavy"):
        weights[style] *= 1.3 - age
    values: NDArray[np.float64] = np.array([weights[s] for s in STYLES])
    return np.asarray(values / values.sum())
