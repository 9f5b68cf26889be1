"""What may have changed between the day somebody was enrolled and the day of a probe? A value.

What makes the person stays: sex, ancestry, the sliders of the shape, iris, moles, the way hair
grows. What it says may change is drawn for each person from streams of their own, one for each kind
of change, so that a cap leaves the haircut of that day as it was. The same person, day and numbers
give the same bytes.
"""

from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.random import Generator, SeedSequence

from lrsr.configuration import as_number, as_whole, as_word, require

_CHANCES = ("hair", "stubble", "make_up", "glasses", "cap", "face_mask")
_SPANS = {"greyer": (0.0, 1.0), "tan": (-1.0, 1.0), "weight": (0.0, 0.6), "years": (0.0, 20.0)}
"""Lowest and highest that each may say."""

_KINDS = (*_CHANCES, *_SPANS)
"""Append, never reorder: each has a random stream of its own."""
_DAYS = 1000
"""Sets these streams apart from all others that start from the seed of a person."""
_LATEST_DAY = 2**31

Span = tuple[float, float]
NOTHING: Span = (0.0, 0.0)


@dataclass(frozen=True)
class AnotherDay:
    """What may differ from the enrolled picture; by default nothing does.

    Chances are 0 to 1, spans hold the least and the most, drawn evenly.

    Attributes:
        name: For records.
        day: Which one, 1 to 2**31: the same person on another day draws anew.
        hair: Chance that it was cut, has grown or is parted otherwise.
        stubble: Chance that a man has let it grow, or a bearded one has trimmed or shaved it off.
        make_up: Chance that a woman wears none who wore some, or other than before.
        glasses: Chance that they are worn; nobody was enrolled with any.
        cap: Chance.
        face_mask: Chance.
        greyer: Share of the pigmented hairs that have turned white, 0 to 1.
        tan: Natural logarithm of melanin now over then, -1 to 1.
        weight: Lost or gained by chance, 0 to 0.6, where 1 leads from MakeHuman's thinnest to its
            heaviest.
        years: Gone by, 0 to 20.

    Raises:
        InputError: A number is out of its range.
    """

    name: str
    day: int = 1
    hair: float = 0.0
    stubble: float = 0.0
    make_up: float = 0.0
    glasses: float = 0.0
    cap: float = 0.0
    face_mask: float = 0.0
    greyer: Span = NOTHING
    tan: Span = NOTHING
    weight: Span = NOTHING
    years: Span = NOTHING

    def __post_init__(self) -> None:
        object.__setattr__(self, "name", as_word(self.name, "another_day.name"))
        day = as_whole(self.day, "another_day.day")
        require(1 <= day <= _LATEST_DAY, "another_day.day", day, f"1 to {_LATEST_DAY}")
        object.__setattr__(self, "day", day)
        for name in _CHANCES:
            chance = as_number(getattr(self, name), f"another_day.{name}")
            require(0 <= chance <= 1, f"another_day.{name}", f"{chance:g}", "0 to 1")
            object.__setattr__(self, name, chance)
        for name, limits in _SPANS.items():
            span = _span(f"another_day.{name}", getattr(self, name), limits)
            object.__setattr__(self, name, span)

    @property
    def is_same(self) -> bool:
        """Does nothing change?"""
        return not any(getattr(self, name) for name in _CHANCES) and all(
            getattr(self, name) == NOTHING for name in _SPANS
        )

    def record(self) -> dict[str, Any]:
        """Return the numbers in plain values; nothing where nothing changes."""
        return {} if self.is_same else {k: v for k, v in asdict(self).items() if k != "name"}

    def later(self, days: int) -> "AnotherDay":
        """Return the day that comes so many later, of the same numbers; the same if it is none."""
        return self if self.is_same else replace(self, day=self.day + days)

    def stream(self, seed: int, kind: str) -> Generator:
        """Return what one kind of change is drawn from.

        Args:
            seed: The person.
            kind: The name of a chance or a span.
        """
        return np.random.default_rng(SeedSequence([seed, _DAYS, self.day, _KINDS.index(kind)]))

    def happens(self, rng: Generator, kind: str) -> bool:
        """Draw whether a change of that chance comes about."""
        return bool(rng.random() < getattr(self, kind))

    def amount(self, seed: int, kind: str) -> float:
        """Draw how much of a change of that span comes about; 0 where there is none.

        Args:
            seed: The person.
            kind: The name of a span.
        """
        low, high = getattr(self, kind)
        return float(self.stream(seed, kind).uniform(low, high))

    def wears(self, seed: int, kind: str) -> bool:
        """Tell whether glasses, a cap or a face mask are worn."""
        return self.happens(self.stream(seed, kind), kind)


def _span(name: str, given: Any, limits: Span) -> Span:
    """Return the least and the most as a pair of floats.

    Raises:
        InputError: It is none, or out of its limits.
    """
    low, high = limits
    wish = f"[least,most], {low:g} <= least <= most <= {high:g}"
    try:
        pair = tuple(given)
    except TypeError:
        pair = ()
    shown = f"[{','.join(map(str, pair))}]" if pair else given
    require(len(pair) == 2 and not isinstance(given, str), name, shown, wish)
    least, most = (as_number(value, name) for value in pair)
    require(low <= least <= most <= high, name, f"[{least:g},{most:g}]", wish)
    return least, most


SAME_DAY = AnotherDay("none")
"""Nothing changes."""
