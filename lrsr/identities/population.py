"""Who can be drawn? Everybody evenly, or only one sex, some ancestries, or a span of ages.

A restriction changes what a seed draws only as far as it must: a person who already fits stays who
they were, so that populations can be compared person by person.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lrsr.errors import InputError

Sex = Literal["any", "female", "male"]
_SEXES: tuple[Sex, ...] = get_args(Sex)

ANCESTRIES = ("african", "asian", "caucasian")
"""The poles of the shape space."""

YOUNGEST_YEARS, OLDEST_YEARS = 25.0, 75.0
"""What the shape space's young and old adult stand for; nobody is younger or older."""

_PURITY = 0.85
"""Share of the chosen ancestries that a restricted person has at least; real people are mixed."""


@dataclass(frozen=True)
class Population:
    """From whom people are drawn; the default is everybody, evenly.

    Attributes:
        sex: "any", half of them women; "female" or "male".
        ancestry: Which of :data:`ANCESTRIES`, evenly mixed; all, in any order, is no restriction.
        age_years: Youngest and oldest, within 25 to 75.

    Raises:
        InputError: There is no such sex or ancestry, or the ages are no span within 25 to 75.
    """

    sex: Sex = "any"
    ancestry: tuple[str, ...] = ANCESTRIES
    age_years: tuple[float, float] = (YOUNGEST_YEARS, OLDEST_YEARS)

    def __post_init__(self) -> None:
        if self.sex not in _SEXES:
            raise InputError(f"identities.sex={self.sex}: wanted one of {', '.join(_SEXES)}")
        chosen = tuple(race for race in ANCESTRIES if race in self.ancestry)
        if not self.ancestry or set(chosen) != set(self.ancestry):
            raise InputError(
                f"identities.ancestry=[{','.join(map(str, self.ancestry))}]: wanted some of"
                f" {', '.join(ANCESTRIES)}"
            )
        ages = tuple(float(age) for age in self.age_years)
        if len(ages) != 2 or not YOUNGEST_YEARS <= ages[0] < ages[1] <= OLDEST_YEARS:
            raise InputError(
                f"identities.age_years=[{','.join(f'{age:g}' for age in ages)}]: wanted the"
                f" youngest and the oldest age, within {YOUNGEST_YEARS:g} to {OLDEST_YEARS:g}"
            )
        object.__setattr__(self, "ancestry", chosen)
        object.__setattr__(self, "age_years", ages)

    @property
    def tag(self) -> str:
        """A short name that differs between populations; empty for everybody.

        Example:
            >>> Population("female", ("asian",), (30, 50)).tag
            'female-asian-30to50'
        """
        low, high = self.age_years
        words = [
            *([self.sex] if self.sex != "any" else []),
            *(self.ancestry if self.ancestry != ANCESTRIES else []),
            *([f"{low:g}to{high:g}"] if (low, high) != (YOUNGEST_YEARS, OLDEST_YEARS) else []),
        ]
        return "-".join(words)

    def male(self, drawn: bool) -> bool:
        """Turn the sex that was drawn from everybody into one of this population."""
        return drawn if self.sex == "any" else self.sex == "male"

    def age(self, drawn: float) -> float:
        """Turn a draw from all ages into one of this span, with the same order.

        Args:
            drawn: 0 (25 years) to 1 (75 years).

        Returns:
            On the same scale.

        Example:
            >>> round(Population(age_years=(30, 50)).age(0.5), 6)  # 40 years
            0.3
        """
        low, high = (
            (years - YOUNGEST_YEARS) / (OLDEST_YEARS - YOUNGEST_YEARS) for years in self.age_years
        )
        return drawn if (low, high) == (0.0, 1.0) else low + (high - low) * drawn

    def shares(self, drawn: ArrayLike) -> NDArray[np.float64]:
        """Turn shares drawn from all ancestries into those of a person of the chosen ones.

        Their proportions among themselves stay (what is left of a Dirichlet draw is again one); the
        others keep 15 % of what they had.

        Args:
            drawn: ``(3,)`` shares of :data:`ANCESTRIES`, summing to 1.

        Returns:
            ``(3,)``, summing to 1.
        """
        everything = np.asarray(drawn, dtype=np.float64)
        if self.ancestry == ANCESTRIES:
            return everything
        kept = np.array([race in self.ancestry for race in ANCESTRIES]) * (everything + 1e-9)
        return np.asarray(_PURITY * kept / kept.sum() + (1 - _PURITY) * everything)


EVERYBODY = Population()


def population_from(values: Mapping[str, object]) -> Population:
    """Read a population that was written as plain values, e.g. in a roster.

    Raises:
        InputError: A value is missing or wrong.
    """
    try:
        return Population(
            sex=values["sex"],  # type: ignore[arg-type]  # checked by the class
            ancestry=tuple(values["ancestry"]),  # type: ignore[arg-type]  # refused below
            age_years=tuple(values["age_years"]),  # type: ignore[arg-type]  # refused below
        )
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"no population: {dict(values)}") from error
