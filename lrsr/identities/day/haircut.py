"""How else can somebody wear their hair? Cut, grown, or parted otherwise, never on another scalp.

Hairline, bald places and whether hair curls are the person's; style, length and parting are not.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from lrsr.identities.face.resting import RestingFace
from lrsr.identities.gate.plausibility import check_hair
from lrsr.identities.hair.choice import sample_hair
from lrsr.identities.hair.styles import AT_HAIRLINE_MM

_WAYS = ("cut", "grown", "parted")

_OF_THE_SCALP = (
    *("hairline_deg", "recession_deg", "peak_deg", "tilt_deg", "nape_deg"),
    *("bald_deg", "hair_colour", "grey"),
)
_BALDING = {
    "receding": {"shaved", "buzz", "crop", "receding", "slicked_back"},
    "horseshoe": {"shaved", "horseshoe"},
}
"""What can be made of hair that has gone; nobody loses it within a few years."""
_CURLS = {
    "afro": {"afro", "buzz", "shaved", "curly", "pulled_back"},
    "curly": {"curly", "buzz", "crop", "pixie", "pulled_back", "long_curly"},
    "long_curly": {"long_curly", "curly", "pixie", "pulled_back"},
}
_TRIES = 60
_CUT, _GROWN = 0.7, 1.45
"""At most and at least this share of the length before: less is not seen."""


def restyle(
    person: Mapping[str, Any], face: RestingFace, rng: np.random.Generator
) -> tuple[dict[str, Any], str]:
    """Change somebody's hair.

    Args:
        person: Numbers, see :func:`lrsr.identities.morphable.sample_parameters`.
        face: The same person's, at rest.
        rng: The only source of chance.

    Returns:
        New numbers of the hair, and what was done: one of :data:`_WAYS`, or "same" where
        nothing else suits.
    """
    own, skin = person["hair"], face.skin.astype(np.float32)
    first = int(rng.integers(len(_WAYS)))
    for way in (*_WAYS[first:], *_WAYS[:first]):
        for hair in _tries(person, way, rng):
            if not check_hair(hair, skin, person["seed"]):
                return hair, way
    return dict(own), "same"


def _hair_length_mm(hair: Mapping[str, Any]) -> float:
    """Say how long hair is, roughly: hanging hair by where it ends, other by how it stands."""
    if hair["sunk_mm"] > 0:
        return 0.5
    low = float(min(hair["lower_mm"]))
    stands = float(max(hair["top_mm"], hair["back_mm"]))
    return 100.0 - low if low < AT_HAIRLINE_MM else stands


def _tries(person: Mapping[str, Any], way: str, rng: np.random.Generator) -> Any:
    """Yield hair of that way, until it is good enough or there is no more."""
    own = person["hair"]
    if way == "parted":
        if own["parting_length"] > 0 and abs(own["parting_deg"]) > 4.0:
            yield _mirrored(own)
        return
    before = _hair_length_mm(own)
    for _ in range(_TRIES):
        drawn = sample_hair(
            rng,
            person["masculinity"],
            person["age"],
            person["ancestry"],
            person["appearance"]["hair_colour"],
        )
        after = _hair_length_mm(drawn)
        fits = after < _CUT * before if way == "cut" else _GROWN * before < after < 8 * before + 60
        if fits and _suits(drawn["style"], own):
            yield drawn | {name: own[name] for name in _OF_THE_SCALP if name in own}


def _suits(style: str, own: Mapping[str, Any]) -> bool:
    worn = own["style"]
    if worn in _BALDING:
        return style in _BALDING[worn]
    if style in _BALDING:
        return False
    if worn in _CURLS:
        return style in _CURLS[worn]
    return style not in _CURLS


def _mirrored(own: Mapping[str, Any]) -> dict[str, Any]:
    """Part hair on the other side."""
    return {
        **own,
        "parting_deg": -own["parting_deg"],
        "crown_x_deg": -own["crown_x_deg"],
        "sweep_mm": -own["sweep_mm"],
        "fringe_tilt_mm": -own["fringe_tilt_mm"],
        "front_left_deg": own["front_right_deg"],
        "front_right_deg": own["front_left_deg"],
    }
