"""How many impostor scores lie below, and at, each genuine score? The one pass all curves need.

For the distinct genuine scores u_0 < u_1 < ... the counts lo_k = #{impostor < u_k} and
hi_k = #{impostor <= u_k} hold the whole ROC curve, its area and DeLong's variance, exactly and
with ties. Nothing is ranked. Impostor scores below every genuine one are only counted. The others
go through a table whose bins rise with the score: it classes all that share no bin with a genuine
score, and only the rest are compared. Where that would not pay (heavy ties, long tails, a processor
on which NumPy sorts faster than it looks up) the block is sorted instead; the counts are the same.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lrsr.errors import ScoreError

Array = NDArray[Any]
Ints = NDArray[np.int64]

BLOCK = 1 << 17
"""Scores handled at once: what stays near a core with its temporaries (4 MiB)."""
_EXACT_IN_FLOAT64 = 1 << 53
_MOST_CLOSE = 0.3
"""Share of scores in a block that may need comparing before sorting the block is cheaper."""
_WORTH_DROPPING = 0.6
"""Share of scores above the least genuine one below which setting the others aside pays."""


def check_scores(scores: ArrayLike, name: str, *, at_least: int = 1) -> Array:
    """Return the scores as a flat array of float32, float64 or integers, refusing what is not one.

    Finiteness is looked at later, block by block; see :func:`check_finite`.

    Args:
        scores: Any shape; booleans and float16 are widened without loss.
        name: What the message calls them.
        at_least: How many there must be.

    Raises:
        ScoreError: Too few scores, or a dtype that is not real (or wider than float64).
    """
    array = np.asarray(scores)
    if array.size < at_least:
        raise ScoreError(f"{array.size} {name} scores, wanted at least {at_least}: give more pairs")
    if array.dtype == np.bool_ or array.dtype == np.float16:
        array = array.astype(np.float32)
    if array.dtype.kind not in "iuf" or array.dtype.itemsize > 8:
        raise ScoreError(
            f"{name} scores have dtype {array.dtype}: give float32, float64 or integers"
        )
    return array.reshape(-1)


def check_finite(scores: Array, name: str, start: int = 0) -> None:
    """Refuse NaN and infinities.

    Args:
        scores: ``(n,)``.
        name: What the message calls them.
        start: Index of the first of them in the user's array.

    Raises:
        ScoreError: One is not finite; the message gives the index of the first.
    """
    if scores.dtype.kind != "f":
        return
    finite = np.isfinite(scores)
    if not finite.all():
        first = int(np.argmin(finite))
        raise ScoreError(
            f"{name} score {start + first} is {scores[first]}: scores must be finite; "
            "a failure to acquire is counted apart (Scores.n_fta), not compared"
        )


def to_common(a: Array, b: Array) -> tuple[Array, Array]:
    """Return two sets of scores in one dtype that holds both exactly.

    Raises:
        ScoreError: Integers beyond 2**53 against a dtype that is not theirs.
    """
    if a.dtype == b.dtype:
        return a, b
    common = np.result_type(a, b)
    if common.kind == "f":
        common = np.dtype(np.float64)
        if max(_magnitude(part) for part in (a, b)) > _EXACT_IN_FLOAT64:
            raise ScoreError(
                "integer scores beyond 2**53 cannot be compared with another dtype exactly: "
                "give all scores in one dtype"
            )
    return a.astype(common, copy=False), b.astype(common, copy=False)


def _magnitude(scores: Array) -> int:
    """Return the largest absolute value of integers; 0 for fractions, which need no care."""
    if scores.dtype.kind == "f" or scores.size == 0:
        return 0
    return max(abs(int(scores.min())), abs(int(scores.max())))


@dataclass(frozen=True)
class Counts:
    """The counts that every measure of this package is made of.

    Attributes:
        values: ``(k,)`` distinct genuine scores, rising.
        ties: ``(k,)`` how many genuine scores have that value, >= 1.
        lo: ``(k,)`` impostor scores strictly below the value.
        hi: ``(k,)`` impostor scores at or below it.
        n_impostor: How many impostor scores were counted.
    """

    values: Array
    ties: Ints
    lo: Ints
    hi: Ints
    n_impostor: int

    @property
    def n_genuine(self) -> int:
        """How many genuine scores there are."""
        return int(self.ties.sum())

    @property
    def genuine_placements(self) -> Ints:
        """``(k,)`` twice the impostor scores that a genuine score beats, ties as one half."""
        return self.lo + self.hi

    @property
    def classes(self) -> tuple[Ints, Ints]:
        """The ``2k+1`` classes of impostor scores: twice the genuine scores above, and how many.

        Below u_0, at u_0, between u_0 and u_1, at u_1, ... above the last.
        """
        edges = np.zeros(2 * self.values.size + 2, dtype=np.int64)
        edges[1:-1:2], edges[2:-1:2], edges[-1] = self.lo, self.hi, self.n_impostor
        return class_placements(self.ties), np.diff(edges)


def class_placements(ties: Ints) -> Ints:
    """Return twice the genuine scores above each of the ``2k+1`` classes, ties as one half.

    Example:
        >>> class_placements(np.array([1, 2])).tolist()
        [6, 5, 4, 2, 0]
    """
    beaten = np.zeros(2 * ties.size + 1, dtype=np.int64)
    beaten[1::2] = ties
    beaten[2::2] = ties
    return 2 * int(ties.sum()) - np.cumsum(beaten)


@dataclass(frozen=True)
class _Table:
    """Bins that rise with the score: ``floor((clip(x, first, last) - first) * per_unit)``.

    Subtraction, product and truncation each keep the order in floating point, so no score above
    another lies in a lower bin, however the arithmetic rounds.
    """

    first: Any
    last: Any
    per_unit: Any
    classes: NDArray[np.int32]
    """``(bins,)`` class of every impostor score of the bin; -1 where a genuine score shares it."""

    def bins(self, scores: Array) -> NDArray[np.intp]:
        """Return the bin of each score, ``(n,)``."""
        if scores.dtype != self.first.dtype:
            scores = scores.astype(self.first.dtype)
        place = np.clip(scores, self.first, self.last)
        place -= self.first
        place *= self.per_unit
        return place.astype(np.intp)


def _build_table(values: Array) -> _Table | None:
    """Lay bins over the bulk of the distinct genuine scores; None where no fair table exists.

    The ends come from the quartiles, three times their distance away (or the extremes, where those
    are nearer), so that one stray score cannot put all the others into one bin.
    """
    size = 1 << min(int(12 * values.size).bit_length(), 16)
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
    table = _Table(first, last, per_unit, np.empty(size, dtype=np.int32))
    occupied = np.bincount(table.bins(values), minlength=size)
    classes = (2 * np.cumsum(occupied)).astype(np.int32)
    classes[occupied > 0] = -1
    return _Table(first, last, per_unit, classes)


@cache
def _sorting_is_slow(dtype: str) -> bool:
    """Say whether looking scores of this dtype up is faster here than sorting them.

    Timed once per process: with AVX-512 NumPy sorts float32 faster than it gathers, without it
    several times slower. Either way counts the same.
    """
    scores = np.linspace(0, 1000, 1 << 14).astype(dtype)
    np.random.default_rng(0).shuffle(scores)
    table = _build_table(np.unique(scores[:400]))
    if table is None:
        return False

    def look_up() -> None:
        bins = table.bins(scores)
        np.flatnonzero((table.classes < 0)[bins])
        np.bincount(bins, minlength=table.classes.size)

    return _seconds(look_up) < _seconds(lambda: np.sort(scores))


def _seconds(work: Callable[[], object]) -> float:
    times = []
    for _ in range(5):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return min(times)


class Counter:
    """Counts impostor scores against fixed genuine scores, block after block.

    Args:
        genuine: ``(m,)`` genuine scores, at least one; float32, float64 or integers.

    Raises:
        ScoreError: No genuine score, a dtype that is not real, or a NaN or an infinity.

    Example:
        >>> counter = Counter([1.0, 2.0])
        >>> counter.add([0.0, 1.0, 3.0])
        >>> counter.counts().lo.tolist(), counter.counts().hi.tolist()
        ([1, 2], [2, 2])
    """

    def __init__(self, genuine: ArrayLike) -> None:
        checked = check_scores(genuine, "genuine")
        check_finite(checked, "genuine")
        self.values, ties = np.unique(checked, return_counts=True)
        self.ties: Ints = ties.astype(np.int64)
        self._exact: Array = self.values
        self._below: Ints = np.zeros(self.values.size, dtype=np.int64)
        self._at_or_below: Ints = np.zeros(self.values.size, dtype=np.int64)
        self._n = 0
        self._lay_table()

    def _lay_table(self) -> None:
        self._table = _build_table(self._exact)
        self._in_bin: Ints = np.zeros(self._table.classes.size if self._table else 0, np.int64)

    def add(self, impostor: ArrayLike) -> None:
        """Count more impostor scores, any shape and any number.

        Raises:
            ScoreError: A NaN, an infinity, a dtype that is not real, or integers too large to be
                compared with fractions.
        """
        scores = check_scores(impostor, "impostor", at_least=0)
        step = max(BLOCK, 8 * self.values.size)
        for start in range(0, scores.size, step):
            block = scores[start : start + step]
            check_finite(block, "impostor", self._n + start)
            self._count(self._comparable(block))
        self._n += scores.size

    def counts(self) -> Counts:
        """Return the counts of all impostor scores so far."""
        lo, hi = self._below.copy(), self._at_or_below.copy()
        if self._table is not None:
            counted_whole = np.where(self._table.classes < 0, 0, self._in_bin)
            under = np.cumsum(counted_whole)[self._table.bins(self._exact)]
            lo += under
            hi += under
        return Counts(self._exact, self.ties, lo, hi, self._n)

    def place(self, impostor: ArrayLike) -> Ints:
        """Count impostor scores ``(b,)`` and return twice the genuine scores above each.

        A tie counts one half, so the values lie between 0 and ``2 m``.

        Raises:
            ScoreError: As :meth:`add`.
        """
        scores = check_scores(impostor, "impostor", at_least=0)
        check_finite(scores, "impostor", self._n)
        classes = self._classes(self._comparable(scores))
        sizes = np.bincount(classes, minlength=2 * self.values.size + 1)
        self._below += np.cumsum(sizes)[:-1:2]
        self._at_or_below += np.cumsum(sizes)[1::2]
        self._n += scores.size
        return class_placements(self.ties)[classes]

    def _comparable(self, block: Array) -> Array:
        """Return the block in the dtype of comparison, widening the genuine scores if need be.

        Raises:
            ScoreError: Integers beyond 2**53 against fractions.
        """
        block, exact = to_common(block, self._exact)
        if exact.dtype != self._exact.dtype:
            self._settle()
            self._exact = exact
            self._lay_table()
        return block

    def _settle(self) -> None:
        """Move the counts of the present table into lo and hi before the table changes."""
        counts = self.counts()
        self._below, self._at_or_below = counts.lo, counts.hi

    def _count(self, block: Array) -> None:
        candidate = block >= self._exact[0]
        n_candidates = int(np.count_nonzero(candidate))
        if n_candidates < _WORTH_DROPPING * block.size:
            self._below += block.size - n_candidates
            self._at_or_below += block.size - n_candidates
            block = block[np.flatnonzero(candidate)]
        if self._table is not None and _sorting_is_slow(block.dtype.str):
            block = self._set_aside(block, self._table)
        if block.size:
            block = np.sort(block)
            self._below += np.searchsorted(block, self._exact, side="left")
            self._at_or_below += np.searchsorted(block, self._exact, side="right")

    def _set_aside(self, scores: Array, table: _Table) -> Array:
        """Count by bins what can be so counted; return the scores that must be compared."""
        bins = table.bins(scores)
        close = np.flatnonzero((table.classes < 0)[bins])
        if close.size > _MOST_CLOSE * scores.size:
            self._settle()
            self._table = None
            return scores
        self._in_bin += np.bincount(bins, minlength=table.classes.size)
        return scores[close]

    def _classes(self, block: Array) -> Array:
        """Return the class, 0 to 2k, of each score: see :attr:`Counts.classes`."""
        if self._table is None:
            return self._compare(block)
        classes = self._table.classes[self._table.bins(block)]
        close = np.flatnonzero(classes < 0)
        classes[close] = self._compare(block[close])
        return classes

    def _compare(self, scores: Array) -> Array:
        left = np.searchsorted(self._exact, scores, side="left")
        return left + np.searchsorted(self._exact, scores, side="right")


def count(genuine: ArrayLike, impostor: ArrayLike) -> Counts:
    """Count the impostor scores below and at each distinct genuine score.

    Args:
        genuine: ``(m,)``, m >= 1.
        impostor: ``(n,)``, n >= 1.

    Raises:
        ScoreError: A side is empty, a score is not finite, or a dtype is not real.
    """
    counter = Counter(genuine)
    counter.add(check_scores(impostor, "impostor"))
    return counter.counts()
