"""How many impostor scores lie below, and at, each genuine score? The one pass all curves need.

For the distinct genuine scores u_0 < u_1 < ... the counts lo_k = #{impostor < u_k} and
hi_k = #{impostor <= u_k} hold the whole ROC curve, its area and DeLong's variance, exactly and
with ties. Nothing is ranked. Impostor scores below every genuine one are only counted. The others
go through a table whose bins rise with the score: it classes all that share no bin with a genuine
score, and only the rest are compared. Where that would not pay (heavy ties, long tails, a processor
on which NumPy sorts faster than it looks up) the block is sorted instead; the counts are the same.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lrsr.errors import ScoreError
from lrsr.evaluation.lookup import Table, build_table, compare, sorting_is_slow

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
        self._table: Table | None = None
        self._of_class = class_placements(self.ties)
        self._of_bin: Ints = np.zeros(0, dtype=np.int64)
        self._in_bin: Ints = np.zeros(0, dtype=np.int64)
        self._table_pays = True

    def _lay_table(self) -> Table | None:
        """Return the table, laid when it is first needed; None where it has no use."""
        if self._table is None and self._table_pays:
            self._table = build_table(self._exact)
            self._table_pays = self._table is not None
            if self._table is not None:
                self._in_bin = np.zeros(self._table.close.size, dtype=np.int64)
                placements = self._of_class[2 * self._table.below]
                self._of_bin = np.where(self._table.close, -1, placements)
        return self._table

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
            counted_whole = np.where(self._table.close, 0, self._in_bin)
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
        places = self._place(self._comparable(scores))
        sizes = np.bincount(places, minlength=int(self._of_class[0]) + 1)
        at_or_under = np.cumsum(sizes[self._of_class])
        self._below += at_or_under[:-1:2]
        self._at_or_below += at_or_under[1::2]
        self._n += scores.size
        return places

    def _place(self, block: Array) -> Ints:
        table = self._lay_table()
        if table is None:
            return self._of_class[compare(block, self._exact)]
        bins = table.bins(block)
        places = self._of_bin[bins]
        close = np.flatnonzero(places < 0)
        places[close] = self._of_class[table.classify(block[close], bins[close], self._exact)]
        return places

    def _comparable(self, block: Array) -> Array:
        """Return the block in the dtype of comparison, widening the genuine scores if need be.

        Raises:
            ScoreError: Integers beyond 2**53 against fractions.
        """
        block, exact = to_common(block, self._exact)
        if exact.dtype != self._exact.dtype:
            self._settle()
            self._exact = exact
        return block

    def _settle(self) -> None:
        """Move the counts of the present table into lo and hi and drop the table."""
        counts = self.counts()
        self._below, self._at_or_below, self._table = counts.lo, counts.hi, None

    def _count(self, block: Array) -> None:
        candidate = block >= self._exact[0]
        n_candidates = int(np.count_nonzero(candidate))
        if n_candidates < _WORTH_DROPPING * block.size:
            self._below += block.size - n_candidates
            self._at_or_below += block.size - n_candidates
            block = block[np.flatnonzero(candidate)]
        if sorting_is_slow(block.dtype.str) and (table := self._lay_table()) is not None:
            block = self._set_aside(block, table)
        if block.size:
            block = np.sort(block)
            self._below += np.searchsorted(block, self._exact, side="left")
            self._at_or_below += np.searchsorted(block, self._exact, side="right")

    def _set_aside(self, scores: Array, table: Table) -> Array:
        """Count by bins what can be so counted; return the scores that must be compared."""
        bins = table.bins(scores)
        close = np.flatnonzero(table.close[bins])
        if close.size > _MOST_CLOSE * scores.size:
            self._settle()
            self._table_pays = False
            return scores
        self._in_bin += np.bincount(bins, minlength=table.close.size)
        return scores[close]


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
