"""What does a face do? Face units with strengths, worn on top of the resting face of a person.

The shape space carries the units of Apple's ARKit as MakeHuman modelled them ("faceunits01"). One
without ``Left`` or ``Right`` moves both sides. The person stays who they are: only the shape
changes, no texture. Turning the eyes and putting out the tongue are no expressions here.
"""

import difflib
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lrsr.errors import InputError
from lrsr.identities.shape.basis import Basis, load_basis

LEFT_OUT = ("eyeLook", "tongueOut")
"""Units that would need another eyeball or tongue than the mesh has."""


@lru_cache(maxsize=1)
def known_units() -> Mapping[str, tuple[str, ...]]:
    """Name every face unit, one-sided or not, and the fields "unit/..." that it stands for."""
    names = [name.removeprefix("unit/") for name in load_basis().names if name.startswith("unit/")]
    known = {name: (name,) for name in names if not name.startswith(LEFT_OUT)}
    pairs = {name.removesuffix("Left") for name in known if name.endswith("Left")}
    both = {
        name: (f"{name}Left", f"{name}Right")
        for name in sorted(pairs)
        if f"{name}Right" in known and name != "jaw" and name != "mouth"
    }
    return {**known, **both}


@dataclass(frozen=True)
class Expression:
    """What a face does beyond being at rest.

    Attributes:
        name: For manifests.
        units: Strength, 0 to 1, of each face unit that is used; "mouthSmile" stands for
            "mouthSmileLeft" and "mouthSmileRight". Units of no strength are dropped.

    Raises:
        InputError: There is no such unit, or a strength is not between 0 and 1.

    Example:
        >>> Expression("wink", {"eyeBlinkLeft": 1, "mouthSmile": 0}).units
        {'eyeBlinkLeft': 1.0}
    """

    name: str
    units: Mapping[str, float] = field(default_factory=dict, hash=False)

    def __post_init__(self) -> None:
        known = known_units()
        strengths: dict[str, float] = {}
        for unit, strength in self.units.items():
            if unit not in known:
                near = difflib.get_close_matches(unit, known, n=4, cutoff=0.5)
                wish = ", ".join(near or [name for name in known if not name.endswith("t")])
                raise InputError(f"face unit {unit!r} does not exist; choose one of {wish}")
            value = _strength(unit, strength)
            for side in known[unit]:
                strengths[side] = max(value, strengths.get(side, 0.0))
        kept = {unit: strengths[unit] for unit in sorted(strengths) if strengths[unit] > 0}
        object.__setattr__(self, "units", kept)

    def act(self, basis: Basis, weights: NDArray[np.float64]) -> NDArray[np.float64]:
        """Add the units to those of a resting face: each goes this share of its way to the end.

        Args:
            basis: The shape space.
            weights: ``(K,)`` coefficients of a person at rest.

        Returns:
            ``(K,)``; ``weights`` itself if the expression is neutral.
        """
        if not self.units:
            return weights
        acting = weights.copy()
        for unit, strength in self.units.items():
            column = basis.column[f"unit/{unit}"]
            acting[column] += strength * max(0.0, 1.0 - acting[column])
        return acting

    def scaled(self, share: float) -> "Expression":
        """Return the same expression, weaker.

        Args:
            share: 0 (neutral) to 1 (as it is).

        Raises:
            InputError: The share is out of its range.
        """
        share = _strength("share", share)
        units = {unit: round(share * strength, 4) for unit, strength in self.units.items()}
        return Expression(self.name, units)


def _strength(name: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"expression: {name}={value!r}: wanted a number from 0 to 1")
    if not (math.isfinite(value) and 0 <= value <= 1):
        raise InputError(f"expression: {name}={value}: wanted 0 to 1")
    return float(value)


EXPRESSIONS: Mapping[str, Mapping[str, float]] = {
    "neutral": {},
    "smile": {
        "mouthSmile": 0.6,
        "mouthDimple": 0.15,
        "mouthStretch": 0.1,
        "cheekSquint": 0.5,
        "eyeSquint": 0.3,
    },
    "grin": {
        "mouthSmile": 0.75,
        "mouthUpperUp": 0.55,
        "mouthLowerDown": 0.3,
        "jawOpen": 0.08,
        "cheekSquint": 0.6,
        "eyeSquint": 0.45,
    },
    "mouth_open": {"jawOpen": 0.25},
    "blink": {"eyeBlink": 1.0},
    "squint": {"eyeSquint": 0.9, "cheekSquint": 0.5, "browDown": 0.3},
    "frown": {"browDown": 0.8, "mouthFrown": 0.5, "mouthPress": 0.3, "eyeSquint": 0.2},
    "surprise": {"browInnerUp": 0.7, "browOuterUp": 0.7, "eyeWide": 0.5, "jawOpen": 0.2},
}
"""Expressions by name: face units and strengths (chosen by eye on some dozen people)."""


def find_expression(
    name: str | Expression, units: Mapping[str, Any] | None = None, strength: float = 1.0
) -> Expression:
    """Return an expression by its name, or the expression itself, with other units as well.

    Args:
        name: One of :data:`EXPRESSIONS`, or an expression.
        units: Strengths of more units, or others for those that it has.
        strength: How much of what the name stands for, 0 to 1.

    Raises:
        InputError: There is no expression or face unit of that name, or a strength is out of its
            range.

    Example:
        >>> find_expression("blink", {"jawOpen": 0.1}).units
        {'eyeBlinkLeft': 1.0, 'eyeBlinkRight': 1.0, 'jawOpen': 0.1}
    """
    if isinstance(name, Expression):
        base = name
    elif name in EXPRESSIONS:
        base = Expression(name, EXPRESSIONS[name])
    else:
        raise InputError(
            f"expression {name!r} does not exist; choose one of {', '.join(EXPRESSIONS)}"
        )
    if strength != 1.0:
        base = base.scaled(strength)
    if not units:
        return base
    changes = Expression(base.name, {str(unit): value for unit, value in units.items()})
    cleared = {unit for given in units for unit in known_units()[str(given)]}
    kept = {unit: value for unit, value in base.units.items() if unit not in cleared}
    return Expression(base.name, {**kept, **changes.units})
