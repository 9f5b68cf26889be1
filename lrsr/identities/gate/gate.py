"""Which of its draws does a person get? The first that passes; why others did not is recorded.

What may fail by chance is drawn again from the next of its random streams, while all else about the
person stays: sex, age, ancestry and skin are settled before, so the gate does not choose who there
is. What came out depends on the seed alone.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar

T = TypeVar("T")

_MOST_DRAWS = 1000
"""Far more than anybody needs: three draws in four pass."""


def draw_plausible(
    draw: Callable[[int], T], judge: Callable[[T], list[str]]
) -> tuple[T, list[list[str]]]:
    """Draw until something passes.

    Args:
        draw: Gives the draw of a number 0, 1, 2, ...; always the same for the same number.
        judge: Names the tests that one fails.

    Returns:
        The first draw that fails none, and what each of those before failed.

    Raises:
        RuntimeError: Nothing passes.
    """
    failures: list[list[str]] = []
    for attempt in range(_MOST_DRAWS):
        drawn = draw(attempt)
        failed = judge(drawn)
        if not failed:
            return drawn, failures
        failures.append(failed)
    raise RuntimeError(f"none of {_MOST_DRAWS} draws passes; the last failed {failures[-1]}")


def record(failures: list[list[str]]) -> dict[str, Any]:
    """Say what the gate did to a person, as plain values.

    Args:
        failures: What each draw that was dismissed failed, whatever was drawn.

    Returns:
        JSON-serialisable: ``redraws``, how many draws were dismissed; ``failures``, the names of
        the tests that each of them failed.
    """
    return {"redraws": len(failures), "failures": failures}


def tally(records: Iterable[Mapping[str, Any]]) -> dict[str, Any]:
    """Count what the gate did to a set of people.

    Args:
        records: One of each, as :func:`record` writes them.

    Returns:
        JSON-serialisable: ``people``, all of them; ``redrawn``, those of whom something was drawn
        again; ``redraws``, how often in all; ``reasons``, how many people had a draw that failed
        each test, most frequent first.
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
    }
