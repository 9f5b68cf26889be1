"""What does another day do to the numbers of a person? Hair, beard, make-up, tan, weight, years.

Numbers of a person go in, changed ones come out; what makes the person is left as it is. What is
worn over head and face is added later, by :mod:`lrsr.identities.day.worn`.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from lrsr.identities.day.another_day import AnotherDay
from lrsr.identities.day.haircut import restyle
from lrsr.identities.face.resting import RestingFace, rest_face
from lrsr.identities.hair.choice import colour_parameters
from lrsr.identities.population import OLDEST_YEARS, YOUNGEST_YEARS
from lrsr.identities.shape.anatomy import coefficients
from lrsr.identities.shape.basis import load_basis
from lrsr.identities.skin.complexion import MELANIN_LIMITS
from lrsr.identities.skin.make_up import sample_make_up

Numbers = dict[str, Any]

_AGEING = ("complexion", "lines", "grain", "sheen")
"""What of the appearance follows the years by the same draws; moles and iris stay."""

_FATTENED = {
    "head/head-fat-decr-incr": 1.6,
    "cheek/cheek-volume-decr-incr": 1.0,
    "neck/neck-double-decr-incr": 1.2,
}
"""What weight adds to the sliders, per unit of it, beyond MakeHuman's own bodies: faces show more
of it than their average does (by eye)."""

_MOST_SLIDER = 1.5
_OPACITIES = ("lipstick", "eyeliner", "eyeshadow", "blush")
_TRIES = 12


def change_person(
    numbers: Mapping[str, Any],
    face: RestingFace,
    day: AnotherDay,
    appearance_at: Callable[[float], Mapping[str, Any]],
) -> tuple[Numbers, RestingFace]:
    """Let a day come.

    Args:
        numbers: Of the person as enrolled, see
            :func:`lrsr.identities.morphable.sample_parameters`.
        face: At rest.
        day: What may change.
        appearance_at: Draws the person's appearance again, at another age (0 to 1), from the same
            stream.

    Returns:
        Numbers and face of that day. The numbers have one entry more, ``another_day``: what came
        about, JSON-serialisable.
    """
    seed = numbers["seed"]
    came: Numbers = {}
    new: Numbers = {**numbers, "appearance": {**numbers["appearance"]}}
    if years := day.amount(seed, "years"):
        came["years"] = round(years, 2)
        _grow_older(new, years, appearance_at)
    if weight := day.amount(seed, "weight"):
        lost = day.stream(seed, "weight").spawn(1)[0].random() < 0.5
        came["weight"] = round(-weight if lost else weight, 3)
        new["anatomy"] = _weigh(new["anatomy"], came["weight"])
    if years or weight:
        face = _shape(new)
    if greyer := day.amount(seed, "greyer"):
        came["greyer"] = round(greyer, 3)
        hair = new["appearance"]["hair_colour"]
        new["appearance"]["hair_colour"] = {**hair, "grey": _whiter(hair["grey"], greyer)}
    if tan := day.amount(seed, "tan"):
        came["tan"] = round(tan, 3)
        new["appearance"]["complexion"] = _tanned(new["appearance"]["complexion"], tan)
    for kind, draw in (("stubble", _let_grow), ("make_up", _make_up)):
        rng = day.stream(seed, kind)
        if day.happens(rng, kind) and (said := draw(new, rng)):
            came[kind] = said
    new["hair"] = {**new["hair"], **colour_parameters(new["appearance"]["hair_colour"])}
    rng = day.stream(seed, "hair")
    if day.happens(rng, "hair"):
        new["hair"], came["hair"] = restyle(new, face, rng)
    new["another_day"] = came
    return new, face


def _grow_older(
    new: Numbers, years: float, appearance_at: Callable[[float], Mapping[str, Any]]
) -> None:
    """Let skin, shape and hair age; nobody is older than the oldest adult of the shape space."""
    new["age"] = min(1.0, new["age"] + years / (OLDEST_YEARS - YOUNGEST_YEARS))
    new["age_years"] = YOUNGEST_YEARS + (OLDEST_YEARS - YOUNGEST_YEARS) * new["age"]
    older, looks = appearance_at(new["age"]), new["appearance"]
    looks |= {name: older[name] for name in _AGEING}
    grey = max(looks["hair_colour"]["grey"], older["hair_colour"]["grey"])
    if older["hair_colour"]["eumelanin"] == looks["hair_colour"]["eumelanin"]:  # else it is dyed
        looks["hair_colour"] = {**looks["hair_colour"], "grey": grey}


def _weigh(anatomy: Mapping[str, Any], gained: float) -> Numbers:
    sliders = dict(anatomy["sliders"])
    for name, gain in _FATTENED.items():
        moved = sliders.get(name, 0.0) + gain * gained
        sliders[name] = float(np.clip(moved, -_MOST_SLIDER, _MOST_SLIDER))
    weight = float(np.clip(anatomy["weight"] + gained, 0.0, 1.0))
    return {**anatomy, "weight": weight, "sliders": sliders}


def _shape(new: Mapping[str, Any]) -> RestingFace:
    traits = {name: new[name] for name in ("masculinity", "age", "ancestry")}
    return rest_face(coefficients(load_basis().names, new["anatomy"], **traits))


def _whiter(grey: float, share: float) -> float:
    return grey + share * (1.0 - grey)


def _tanned(complexion: Mapping[str, Any], tan: float) -> Numbers:
    melanin = float(np.clip(complexion["melanin"] * np.exp(tan), *MELANIN_LIMITS))
    return {**complexion, "melanin": melanin}


def _let_grow(new: Numbers, rng: np.random.Generator) -> str:
    """Change a man's beard; return what was done, "" for nothing."""
    beard, own = new["appearance"]["beard"], new["appearance"]["beard"]["kind"]
    days, trimmed, away = rng.uniform(0.4, 1.0), rng.uniform(0.45, 0.8), rng.random()
    if new["sex"] == "female" or (own == "none" and beard["shadow"] <= 0):
        return ""
    if own == "none":
        said, kind, length, dense = "grown", "stubble", beard["length_mm"], days * beard["density"]
    elif own == "stubble" or away < 0.3:
        said, kind, length, dense = "shaved", "none", beard["length_mm"], beard["density"]
    else:
        said, kind, dense = "trimmed" if away < 0.65 else "longer", own, beard["density"]
        length = beard["length_mm"] * (trimmed if said == "trimmed" else 1.0 / trimmed)
    length = float(np.clip(length, 1.0, 6.0))
    changed = {**beard, "kind": kind, "length_mm": length, "density": float(max(dense, 0.35))}
    new["appearance"]["beard"] = changed
    return said


def _make_up(new: Numbers, rng: np.random.Generator) -> str:
    """Change a woman's make-up; return what was done, "" for nothing."""
    worn = new["appearance"]["make_up"]
    wears = any(worn[name] > 0 for name in _OPACITIES)
    off = rng.random() < 0.5
    if new["sex"] == "male":
        return ""
    if wears and off:
        new["appearance"]["make_up"] = {**worn, **dict.fromkeys(_OPACITIES, 0.0)}
        return "off"
    for _ in range(_TRIES):
        other = sample_make_up(rng, masculinity=new["masculinity"], age=new["age"])
        if any(other[name] > 0 for name in _OPACITIES):  # type: ignore[literal-required]
            new["appearance"]["make_up"] = other
            return "other" if wears else "on"
    return ""
