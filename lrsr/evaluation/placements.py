"""Where does each impostor score fall among the genuine ones? Every measure is made of the answer.

Genuine scores are few. Their k distinct values u_0 < u_1 < ... split all scores into 2k+1 classes:
below u_0, at u_0, between u_0 and u_1, at u_1, ... above the last; class 2i+1 is a tie with u_i.
The class of every impostor score is found, and all else is a ``bincount`` of classes: they hold the
whole ROC curve, its area and DeLong's variance, exactly and with ties, in however many tiles the
scores come.

A class is looked up in a table of bins that rise with the score. A bin without a genuine value lies
in one class, so its scores need no comparison; those that share a bin with a value are compared
with it, and the few that share it with several values are found by bisection.
"""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lrsr.evaluation.arrays import Array, check_finite, check_scores, to_common

Ints = NDArray[np.int64]
Classes = NDArray[np.signedinteger[Any]]

BLOCK = 1 << 16
"""Scores handled at once: what stays near a core with its temporaries (1 MiB)."""
_BINS_PER_VALUE = 24
_MOST_BINS = 1 << 17


class Placements:
    """Fixed genuine scores, and how many impostor scores were found in each class so far.

    Args:
        genuine: ``(m,)`` genuine scores, at least one; float32, float64 or integers.

    Attributes:
        genuine: ``(m,)`` as given.
        values: ``(k,)`` distinct, rising; in the widest dtype that was compared so far.
        ties: ``(k,)`` how many genuine scores have that value.
        sizes: ``(2k+1,)`` impostor scores in each class.

    Raises:
        ScoreError: No genuine score, a dtype that is not real, or a NaN or an infinity.

    Example:
        >>> placements = Placements([1.0, 2.0])
        >>> classes = placements.classes(np.array([[0.0, 1.0], [1.5, 3.0]]))
        >>> placements.count(classes)
        >>> classes.tolist(), placements.lo.tolist(), placements.hi.tolist()
        ([[0, 1], [2, 4]], [1, 3], [2, 3])
    """

    def __init__(self, genuine: ArrayLike) -> None:
        self.genuine = check_scores(genuine, "genuine")
        check_finite(self.genuine, "genuine")
        self.values, ties = np.unique(self.genuine, return_counts=True)
        self.ties: Ints = ties.astype(np.int64)
        self.sizes: Ints = np.zeros(2 * ties.size + 1, dtype=np.int64)
        self._kind = np.int16 if self.sizes.size <= np.iinfo(np.int16).max else np.int32
        self._table: _Table | None = None

    @property
    def n_impostor(self) -> int:
        """How many impostor scores were counted."""
        return int(self.sizes.sum())

    @property
    def lo(self) -> Ints:
        """``(k,)`` impostor scores strictly below each value."""
        return np.cumsum(self.sizes)[:-1:2]

    @property
    def hi(self) -> Ints:
        """``(k,)`` impostor scores at or below each value."""
        return np.cumsum(self.sizes)[1::2]

    @property
    def own_classes(self) -> Ints:
        """``(m,)`` the class of each genuine score itself; odd."""
        return 2 * np.searchsorted(self.values, self.genuine) + 1

    @property
    def of_genuine(self) -> Ints:
        """``(m,)`` twice the impostor scores that each genuine score beats, ties as one half."""
        placements: Ints = (self.lo + self.hi)[self.own_classes >> 1]
        return placements

    def of_impostor(self, classes: Classes) -> Ints:
        """Return twice the genuine scores above each impostor score, ties as one half."""
        placements: Ints = class_placements(self.ties)[classes]
        return placements

    def classes(self, impostor: Array, start: int = 0) -> Classes:
        """Return the class of each score, in the shape given.

        Args:
            impostor: Any shape, float32, float64 or integers.
            start: Index of the first of them, for the message.

        Raises:
            ScoreError: A NaN, an infinity, or integers too large to be compared with fractions.
        """
        flat = impostor.reshape(-1)
        classes: Classes = np.empty(flat.size, dtype=self._kind)
        for first in range(0, flat.size, BLOCK):
            block = flat[first : first + BLOCK]
            check_finite(block, "impostor", start + first)
            block, values = to_common(block, self.values)
            if self._table is None or values.dtype != self._table.values.dtype:
                self.values, self._table = values, _Table(values, self._kind)
            classes[first : first + BLOCK] = self._table.classify(block)
        return classes.reshape(impostor.shape)

    def count(self, classes: Classes) -> None:
        """Count impostor scores of these classes."""
        self.sizes += np.bincount(classes.reshape(-1), minlength=self.sizes.size)


def place(genuine: ArrayLike, impostor: ArrayLike) -> Placements:
    """Count all impostor scores among the genuine ones.

    Args:
        genuine: ``(m,)``, m >= 1.
        impostor: ``(n,)``, n >= 1.

    Raises:
        ScoreError: A side is empty, a score is not finite, or a dtype is not real.
    """
    placements, scores = Placements(genuine), check_scores(impostor, "impostor")
    for start in range(0, scores.size, BLOCK):
        block = scores[start : start + BLOCK]
        below = block < placements.values[:1]
        number = int(np.count_nonzero(below))
        if 2 * number > block.size and block.dtype == placements.values.dtype:
            # Of a good recogniser most lie below all genuine scores, and need only be counted.
            check_finite(block, "impostor", start)
            placements.sizes[0] += number
            block = block[np.flatnonzero(~below)]
        placements.count(placements.classes(block, start))
    return placements


def class_placements(ties: Ints) -> Ints:
    """Return twice the genuine scores above each of the ``2k+1`` classes, ties as one half.

    Example:
        >>> class_placements(np.array([1, 2])).tolist()
        [6, 5, 4, 2, 0]
    """
    beaten = np.zeros(2 * ties.size + 1, dtype=np.int64)
    beaten[1::2] = beaten[2::2] = ties
    return 2 * int(ties.sum()) - np.cumsum(beaten)


class _Table:
    """Bins that rise with the score: ``floor((clip(x, first, last) - first) * per_unit)``.

    Subtraction, product and truncation each keep the order in floating point, so no score above
    another lies in a lower bin, however the arithmetic rounds. The ends come from the quartiles,
    three times their distance away (or the extremes, where those are nearer), so that one stray
    value cannot put all the others into one bin.

    Args:
        values: ``(k,)`` distinct and rising.
        kind: The integers that hold a class.
    """

    def __init__(self, values: Array, kind: type) -> None:
        self.values = values
        size = min(1 << (_BINS_PER_VALUE * values.size).bit_length(), _MOST_BINS)
        real = np.float32 if values.dtype == np.float32 else np.float64
        points = values.astype(np.float64)
        lower, upper = points[values.size // 4], points[-1 - values.size // 4]
        with np.errstate(all="ignore"):
            reach = 3 * (upper - lower)
            least, most = max(points[0], lower - reach), min(points[-1], upper + reach)
            margin = 4 * (most - least) / size
            self.first, self.last = real(least - margin), real(most + margin)
            self.per_unit = real((size - 1) / np.float64(self.last - self.first))
            width = (self.last - self.first) * self.per_unit
        if not (np.isfinite(self.per_unit) and 0 < width < size):  # no spread, or no room for it
            self.first = self.last = self.per_unit = real(0)
        bins = self._bins(values)
        occupied = np.bincount(bins, minlength=size)
        below = np.cumsum(occupied) - occupied
        self.class_of_bin: Classes = (2 * below + (occupied > 0)).astype(kind)
        # Whether the next value shares the bin of each: then being above a value is not enough.
        self.crowded = np.append(bins[1:] == bins[:-1], False)

    def _bins(self, scores: Array) -> NDArray[np.int32]:
        place: Array = np.clip(scores.astype(self.first.dtype, copy=False), self.first, self.last)
        place -= self.first
        place *= self.per_unit
        return place.astype(np.int32)

    def classify(self, scores: Array) -> Classes:
        """Return the class of each score ``(n,)``, finite and of the dtype of the values."""
        classes = self.class_of_bin.take(self._bins(scores), mode="clip")
        close = (classes & 1).astype(np.bool_)
        if 2 * np.count_nonzero(close) > scores.size:  # heavy ties: most need no more than this
            close &= scores != self.values.take(classes >> 1, mode="clip")
        where = np.flatnonzero(close)
        apart, index = scores[where], classes[where] >> 1
        above = apart > self.values[index]
        moved = 2 * index + (apart >= self.values[index]) + above
        again = np.flatnonzero(above & self.crowded[index])
        left = np.searchsorted(self.values, apart[again])
        moved[again] = 2 * left + (self.values.take(left, mode="clip") == apart[again])
        classes[where] = moved
        return classes
