"""Which of its draws does a person get? The first that passes; why others did not is recorded.

What may fail by chance is drawn again from the next of its random streams, while all else about the
person stays: sex, age, ancestry and skin are settled before, so the gate does not choose who there
is. What came out depends on the seed alone.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Generic, NamedTuple, TypeVar

from lrsr.identities.gate.plausibility import Plausibility

T = TypeVar("T")

_MOST_DRAWS = 48
"""Of people of whom nine draws in ten fail, six in a thousand have no draw that passes; fewer, as
later draws of a face are milder (:mod:`lrsr.identities.gate.mildness`)."""


class Accepted(NamedTuple, Generic[T]):
    """What a person got.

    Attributes:
        drawn: The first draw that passed or, if none did, the one that missed by least.
        attempt: Its number.
        failures: Names of the tests that each of the dismissed draws failed.
        unresolved: Of those that the accepted one fails; none unless all draws failed.
    """

    drawn: T
    attempt: int
    failures: tuple[tuple[str, ...], ...]
    unresolved: tuple[str, ...]


def draw_plausible(
    draw: Callable[[int], T], judge: Callable[[T], Plausibility], *, most: int = _MOST_DRAWS
) -> Accepted[T]:
    """Draw until something passes.

    Args:
        draw: Gives the draw of a number 0, 1, 2, ...; always the same for the same number.
        judge: Says whether one passes.
        most: How many are drawn at most, >= 1.
    """
    tried: list[tuple[T, Plausibility]] = []
    for attempt in range(most):
        drawn = draw(attempt)
        verdict = judge(drawn)
        tried.append((drawn, verdict))
        if verdict.passed:
            break
    else:
        attempt = min(range(most), key=lambda number: tried[number][1].excess)
    failures = [outcome.failures for k, (_, outcome) in enumerate(tried) if k != attempt]
    drawn, verdict = tried[attempt]
    return Accepted(drawn, attempt, tuple(failures), verdict.failures)


def record(accepted: Sequence[Accepted[Any]]) -> dict[str, Any]:
    """Say what a gate did, as plain values.

    Args:
        accepted: Of one person, whatever was drawn.

    Returns:
        JSON-serialisable: ``redraws``, how many draws were dismissed; ``failures``, the names of
        the tests that each of them failed; ``unresolved``, of those that what was kept fails,
        because nothing passed (none, nearly always).
    """
    failures = [list(names) for one in accepted for names in one.failures]
    return {
        "redraws": len(failures),
        "failures": failures,
        "unresolved": [name for one in accepted for name in one.unresolved],
    }


def tally(records: Iterable[Mapping[str, Any]]) -> dict[str, Any]:
    """Count what the gate did to a set of people.

    Args:
        records: One of each, as :func:`record` writes them.

    Returns:
        JSON-serialisable: ``people``, all of them; ``redrawn``, those of whom something was drawn
        again; ``redraws``, how often in all; ``reasons``, how many people had a draw that failed
        each test, most frequent first; ``unresolved``, those whose last draw fails, too.
    """
    records = list(records)
    reasons = Counter(
        name for one in records for name in sorted({n for names in one["failures"] for n in names})
    )
    return {
        "people": len(records),
        "redrawn": sum(one["redraws"] > 0 for one in records),
        "redraws": sum(one["redraws"] for one in records),
        "reasons": dict(reasons.most_common()),
        "unresolved": sum(bool(one["unresolved"]) for one in records),
    }
