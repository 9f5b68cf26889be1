"""Where does a score fall among a few hundred others, without comparing it with them?

Scores are classed against k distinct, rising values: class 2i lies strictly between value i-1 and
value i, class 2i+1 is equal to value i. A table whose bins rise with the score gives the class of
every score that shares no bin with a value, 2 below; only the others are compared.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

_BINS_PER_VALUE = 24
_MOST_BINS = 1 << 16


@dataclass(frozen=True)
class Table:
    """Bins that rise with the score: ``floor((clip(x, first, last) - first) * per_unit)``.

    Subtraction, product and truncation each keep the order in floating point, so no score above
    another lies in a lower bin, however the arithmetic rounds.

    Attributes:
        first: Scores below fall into the first bin.
        last: Scores above fall into the last bin.
        per_unit: Bins per unit of score.
        below: ``(bins,)`` how many values lie in lower bins.
        close: ``(bins,)`` whether a value shares the bin.
        crowded: ``(bins,)`` whether several do.
    """

    first: Any
    last: Any
    per_unit: Any
    below: NDArray[np.int32]
    close: NDArray[np.bool_]
    crowded: NDArray[np.bool_]

    def bins(self, scores: Array) -> NDArray[np.intp]:
        """Return the bin of each score, ``(n,)``."""
        return _bins(scores, self.first, self.last, self.per_unit)

    def classify(self, scores: Array, bins: NDArray[np.intp], values: Array) -> NDArray[np.int32]:
        """Return the class of scores that share a bin with a value, ``(n,)``, exactly.

        Args:
            scores: ``(n,)``, the dtype of ``values``.
            bins: ``(n,)`` their bins, each of them close.
            values: ``(k,)`` those that the table was built for.
        """
        below = self.below[bins]
        value = values[below]
        above = scores > value
        classes: NDArray[np.int32] = 2 * below + (scores >= value) + above
        again = np.flatnonzero(above & self.crowded[bins])
        classes[again] = compare(scores[again], values)
        return classes


def build_table(values: Array) -> Table | None:
    """Lay bins over the bulk of the values; None where no fair table exists.

    The ends come from the quartiles, three times their distance away (or the extremes, where those
    are nearer), so that one stray value cannot put all the others into one bin.

    Args:
        values: ``(k,)`` distinct and rising.
    """
    size = min(1 << int(_BINS_PER_VALUE * values.size).bit_length(), _MOST_BINS)
    if not 8 <= 2 * values.size <= size // 4:
        return None
    kind = np.float32 if values.dtype == np.float32 else np.float64
    points = values.astype(np.float64)
    lower, upper = points[values.size // 4], points[-1 - values.size // 4]
    with np.errstate(over="ignore", invalid="ignore"):
        reach = 3 * (upper - lower)
        least, most = max(points[0], lower - reach), min(points[-1], upper + reach)
        margin = 4 * (most - least) / size
        first, last = kind(least - margin), kind(most + margin)
        per_unit = kind((size - 1) / (float(last) - float(first)))
        bounded = np.isfinite(last - first) and np.isfinite(per_unit)
    if not bounded or per_unit <= 0 or (last - first) * per_unit >= size:
        return None
    occupied = np.bincount(_bins(values, first, last, per_unit), minlength=size)
    below = (np.cumsum(occupied) - occupied).astype(np.int32)
    return Table(first, last, per_unit, below, occupied > 0, occupied > 1)


def compare(scores: Array, values: Array) -> NDArray[np.int32]:
    """Return the class of each score, ``(n,)``, by bisection.

    Args:
        scores: ``(n,)``.
        values: ``(k,)`` distinct and rising.

    Example:
        >>> compare(np.array([0, 1, 1.5, 9]), np.array([1, 2])).tolist()
        [0, 1, 2, 4]
    """
    left = np.searchsorted(values, scores, side="left").astype(np.int32)
    tied = values[np.minimum(left, values.size - 1)] == scores
    return np.asarray(2 * left + tied, dtype=np.int32)


@cache
def sorting_is_slow(dtype: str) -> bool:
    """Say whether looking scores of this dtype up is faster here than sorting them.

    Timed once per process: with AVX-512 NumPy sorts float32 faster than it gathers, without it
    several times slower. Either way counts the same.
    """
    scores = np.linspace(0, 1000, 1 << 14).astype(dtype)
    np.random.default_rng(0).shuffle(scores)
    table = build_table(np.unique(scores[:400]))
    if table is None:
        return False

    def look_up() -> None:
        bins = table.bins(scores)
        np.flatnonzero(table.close[bins])
        np.bincount(bins, minlength=table.close.size)

    return _seconds(look_up) < _seconds(lambda: np.sort(scores))


def _bins(scores: Array, first: Any, last: Any, per_unit: Any) -> NDArray[np.intp]:
    if scores.dtype != first.dtype:
        scores = scores.astype(first.dtype)
    place = np.clip(scores, first, last)
    place -= first
    place *= per_unit
    return place.astype(np.intp)


def _seconds(work: Callable[[], object]) -> float:
    times = []
    for _ in range(5):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return min(times)
