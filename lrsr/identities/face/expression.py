"""What does a face do? Face units with strengths, worn on top of the resting face of a person.

The shape space carries the units of Apple's ARKit as MakeHuman modelled them ("faceunits01"). One
without ``Left`` or ``Right`` moves both sides. The person stays who they are: only the shape
changes, no texture. Turning the eyes and putting out the tongue are no expressions here.
"""

import difflib
from collections.abc import Mapping
from dataclasses import InitVar, dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from lrsr.configuration import as_number
from lrsr.errors import InputError
from lrsr.identities.shape.basis import Basis, load_basis

_LEFT_OUT = ("eyeLook", "tongueOut")
"""Units that would need another eyeball or tongue than the mesh has."""


@lru_cache(maxsize=1)
def _known_units() -> Mapping[str, tuple[str, ...]]:
    """Name every face unit, one-sided or not, and the fields "unit/..." that it stands for."""
    names = [name.removeprefix("unit/") for name in load_basis().names if name.startswith("unit/")]
    known = {name: (name,) for name in names if not name.startswith(_LEFT_OUT)}
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
        units: Strength, 0 to 1, of each face unit that is used; "mouthSmile" stands for those of
            "mouthSmileLeft" and "mouthSmileRight" that are not named. Units of no strength are
            dropped.
        strength: How much of all of them, 0 to 1.

    Raises:
        InputError: There is no such unit, or a strength is not between 0 and 1.

    Example:
        >>> Expression("wink", {"eyeBlinkLeft": 1, "mouthSmile": 0}).units
        {'eyeBlinkLeft': 1.0}
    """

    name: str
    units: Mapping[str, float] = field(default_factory=dict, hash=False)
    strength: InitVar[float] = 1.0

    def __post_init__(self, strength: float) -> None:
        known = _known_units() if self.units else {}  # it reads the shape space
        share = _strength("strength", strength)
        strengths: dict[str, float] = {}
        for unit, given in self.units.items():
            if unit not in known:
                near = difflib.get_close_matches(unit, known, n=4, cutoff=0.5)
                wish = ", ".join(near or [name for name in known if not name.endswith("t")])
                raise InputError(f"face unit {unit!r} does not exist; choose one of {wish}")
            value = _strength(unit, given)
            value = value if share == 1 else round(share * value, 4)
            own = known[unit] == (unit,)
            strengths |= {side: value for side in known[unit] if own or side not in self.units}
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
        return Expression(self.name, self.units, share)

    def adding(self, units: Mapping[str, float]) -> "Expression":
        """Return the same expression with more of some units, of each at most all.

        Args:
            units: Strength, 0 to 1, of what is added.

        Raises:
            InputError: There is no such unit, or a strength is not between 0 and 1.

        Example:
            >>> Expression("doze", {"eyeBlinkLeft": 0.9}).adding({"eyeBlink": 0.2}).units
            {'eyeBlinkLeft': 1.0, 'eyeBlinkRight': 0.2}
        """
        total = dict(self.units)
        for unit, more in Expression(self.name, units).units.items():
            total[unit] = min(1.0, round(total.get(unit, 0.0) + more, 4))
        return Expression(self.name, total)


def _strength(name: str, value: object) -> float:
    strength = as_number(value, f"expression.{name}")
    if not 0 <= strength <= 1:
        raise InputError(f"expression.{name}={value}: wanted 0 to 1")
    return strength


NEUTRAL = Expression("neutral")
"""The face at rest."""
