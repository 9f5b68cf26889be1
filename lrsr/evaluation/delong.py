"""How large is the area under the ROC curve, how sure is it, and do two methods differ?

DeLong, DeLong and Clarke-Pearson (Biometrics 44, 1988) in the counting form of Sun and Xu (IEEE
Signal Processing Letters 21, 2014). A score's *placement* is the number of scores of the other kind
that it beats, a tie counting one half. Twice a placement is an integer, so AUC and variance are
computed in integers and rounded once, at the last division.

The area is P(genuine > impostor) + P(genuine = impostor) / 2 and is never flipped: below one half
stays below one half. The pairs are taken as independent; where persons occur in several genuine
pairs, use :mod:`lrsr.evaluation.subjects`.
"""

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import log_ndtr, ndtri

from lrsr.errors import ScoreError
from lrsr.evaluation.arrays import check_scores, plain_number
from lrsr.evaluation.placements import BLOCK, Ints, Placements, class_placements, place


@dataclass(frozen=True)
class AucEstimate:
    """An area under the ROC curve with its uncertainty; every field goes to JSON.

    Attributes:
        auc: Area, [0, 1].
        std: Standard error of the area.
        low: Lower end of the Wald interval, auc - z std, cut to [0, 1].
        high: Upper end of the Wald interval, auc + z std, cut to [0, 1].
        n_genuine: Genuine scores.
        n_impostor: Impostor scores.
        level: Confidence level of the intervals.
        logit_low: Lower end of the interval on the logit scale, which stays inside (0, 1) and
            covers better near 1; None where the area is 0 or 1 and it does not exist.
        logit_high: Upper end of the same.
        wald_leaves_range: The Wald interval left [0, 1] and was cut: read the logit interval.
        degenerate: The variance is 0 (complete separation, or all scores alike): low = high = auc
            is no statement about the uncertainty.
        subject_std: Standard error when persons, not pairs, were sampled; None where it was not
            asked for or does not exist. See :mod:`lrsr.evaluation.subjects`.
        subject_low: Lower end of the Wald interval by it, cut to [0, 1].
        subject_high: Upper end of the same.
        bootstrap_low: Lower end of the percentile interval of the bootstrap over people; None where
            it was not asked for. See :mod:`lrsr.evaluation.bootstrap`.
        bootstrap_high: Upper end of the same.
    """

    auc: float
    std: float
    low: float
    high: float
    n_genuine: int
    n_impostor: int
    level: float = 0.95
    logit_low: float | None = None
    logit_high: float | None = None
    wald_leaves_range: bool = False
    degenerate: bool = False
    subject_std: float | None = None
    subject_low: float | None = None
    subject_high: float | None = None
    bootstrap_low: float | None = None
    bootstrap_high: float | None = None


@dataclass(frozen=True)
class AucComparison:
    """The paired test of two methods on the same pairs.

    Attributes:
        difference: AUC of a minus AUC of b.
        z: difference / std; 0 where the methods rank alike, infinite where the variance is 0 and
            the difference is not.
        p: Two-sided p of no difference; 0 beyond about abs(z) = 38, where ``log10_p`` still speaks.
        log10_p: Its decimal logarithm.
        low: Lower end of the Wald interval of the difference.
        high: Upper end of the same.
        std: Standard error of the difference, covariance included.
        level: Confidence level of the interval.
        degenerate: The variance is 0: p is 1 or 0 by definition, not by evidence.
        subject_std: Standard error when persons, not pairs, were sampled; None where it was not
            asked for or does not exist.
        subject_low: Lower end of the Wald interval by it.
        subject_high: Upper end of the same.
        bootstrap_low: Lower end of the percentile interval of the paired bootstrap over people;
            None where it was not asked for.
        bootstrap_high: Upper end of the same.
        bootstrap_p: Two-sided p of no difference by the bootstrap.
    """

    difference: float
    z: float
    p: float
    log10_p: float
    low: float
    high: float
    std: float
    level: float = 0.95
    degenerate: bool = False
    subject_std: float | None = None
    subject_low: float | None = None
    subject_high: float | None = None
    bootstrap_low: float | None = None
    bootstrap_high: float | None = None
    bootstrap_p: float | None = None


def measure_auc(genuine: ArrayLike, impostor: ArrayLike) -> float:
    """Return the area under the ROC curve alone; one score of each kind is enough.

    Args:
        genuine: ``(m,)`` scores of mated pairs, higher = more alike, m >= 1.
        impostor: ``(n,)`` scores of non-mated pairs, n >= 1.

    Raises:
        ScoreError: A side is empty, a score is not finite, or a dtype is not real.

    Example:
        >>> measure_auc([2, 3], [1, 2])
        0.875
    """
    return float(_area(place(genuine, impostor)))


def estimate_auc(genuine: ArrayLike, impostor: ArrayLike, level: float = 0.95) -> AucEstimate:
    """Estimate the area under the ROC curve with DeLong's standard error.

    Args:
        genuine: ``(m,)`` scores of mated pairs, higher = more alike, m >= 2; float32, float64 or
            integers of any range.
        impostor: ``(n,)`` scores of non-mated pairs, n >= 2.
        level: Confidence level of the intervals, in (0, 1).

    Raises:
        ScoreError: Fewer than two scores of a kind (no variance exists), a score that is not
            finite, a dtype that is not real, or a level outside (0, 1).

    Example:
        >>> estimate = estimate_auc([0.4, 0.6, 0.9], [0.1, 0.2, 0.4, 0.5])
        >>> round(estimate.auc, 4), round(estimate.std, 4)
        (0.875, 0.1483)
    """
    genuine = check_scores(genuine, "genuine", at_least=2)
    impostor = check_scores(impostor, "impostor", at_least=2)
    return estimate_auc_of(place(genuine, impostor), level)


def estimate_auc_of(placements: Placements, level: float = 0.95) -> AucEstimate:
    """Estimate the area as :func:`estimate_auc`, of impostor scores that were counted.

    Raises:
        ScoreError: Fewer than two scores of a kind, or a level outside (0, 1).
    """
    m, n = placements.genuine.size, placements.n_impostor
    _check_numbers(m, n)
    beats = placements.lo + placements.hi
    variance = _variance_of_mean(beats, placements.ties) / (2 * n) ** 2
    by_class = class_placements(placements.ties)
    variance += _variance_of_mean(by_class, placements.sizes) / (2 * m) ** 2
    return _auc_interval(float(_area(placements)), math.sqrt(variance), m, n, level)


def _auc_interval(
    auc: float, std: float, n_genuine: int, n_impostor: int, level: float = 0.95
) -> AucEstimate:
    """Put the Wald and the logit interval round an area with a known standard error.

    Args:
        auc: Area, [0, 1].
        std: Standard error, >= 0.
        n_genuine: Genuine scores, reported.
        n_impostor: Impostor scores, reported.
        level: Confidence level, in (0, 1).

    Raises:
        ScoreError: The level lies outside (0, 1).
    """
    level = check_level(level)
    reach = normal_quantile(level) * std
    logit_low = logit_high = None
    if 0 < auc < 1 and std > 0:
        # The delta method: d logit(a) / d a = 1 / (a (1 - a)).
        centre, half = math.log(auc / (1 - auc)), reach / (auc * (1 - auc))
        logit_low, logit_high = _logistic(centre - half), _logistic(centre + half)
    return AucEstimate(
        auc=auc,
        std=std,
        low=max(0.0, auc - reach),
        high=min(1.0, auc + reach),
        n_genuine=n_genuine,
        n_impostor=n_impostor,
        level=level,
        logit_low=logit_low,
        logit_high=logit_high,
        wald_leaves_range=auc - reach < 0 or auc + reach > 1,
        degenerate=std == 0,
    )


def compare_aucs(
    genuine_a: ArrayLike,
    impostor_a: ArrayLike,
    genuine_b: ArrayLike,
    impostor_b: ArrayLike,
    level: float = 0.95,
) -> AucComparison:
    """Test whether two methods have the same area, on the same pairs in the same order.

    The variance is that of the differences of placements, which equals
    var(a) + var(b) - 2 cov(a, b) without the loss of digits: two methods that rank alike differ by
    exactly 0 with variance exactly 0, and then z = 0 and p = 1.

    Args:
        genuine_a: ``(m,)`` genuine scores of method a, m >= 2.
        impostor_a: ``(n,)`` impostor scores of method a, n >= 2.
        genuine_b: ``(m,)`` scores of method b for the same pairs.
        impostor_b: ``(n,)`` scores of method b for the same pairs.
        level: Confidence level of the interval of the difference.

    Raises:
        ScoreError: The methods have different numbers of scores, fewer than two of a kind, a score
            that is not finite, a dtype that is not real, or a level outside (0, 1).

    Example:
        >>> a, b, impostor = [0.9, 0.8, 0.4], [0.9, 0.3, 0.4], [0.1, 0.2, 0.5, 0.35]
        >>> result = compare_aucs(a, impostor, b, impostor)
        >>> round(result.difference, 4), round(result.p, 3)
        (0.1667, 0.386)
    """
    placements, impostors = [], []
    for name, genuine, impostor in (("a", genuine_a, impostor_a), ("b", genuine_b, impostor_b)):
        placements.append(Placements(check_scores(genuine, f"{name} genuine", at_least=2)))
        impostors.append(check_scores(impostor, f"{name} impostor", at_least=2))
    (a, b), n = placements, impostors[0].size
    for kind, of_a, of_b in (
        ("genuine", a.genuine.size, b.genuine.size),
        ("impostor", n, impostors[1].size),
    ):
        if of_a != of_b:
            raise ScoreError(
                f"{of_a} {kind} scores of a against {of_b} of b: "
                "a paired test wants the same pairs in the same order"
            )
    sums = DifferenceSums()
    for start in range(0, n, BLOCK):
        parts = []
        for side, impostor in zip(placements, impostors, strict=True):
            classes = side.classes(impostor[start : start + BLOCK], start)
            side.count(classes)
            parts.append(side.of_impostor(classes))
        sums.add(*parts)
    return sums.compare(a, b, level)


@dataclass
class DifferenceSums:
    """Sums over the impostor scores of two methods, which the paired test needs.

    Attributes:
        total: Of the differences of doubled placements.
        squares: Of their squares.
    """

    total: int = 0
    squares: int = 0

    def add(self, placements_a: Ints, placements_b: Ints) -> None:
        """Take placements of impostor scores of the same pairs, any shape; 0 in both counts not."""
        shift = (placements_a - placements_b).reshape(-1)
        self.total += int(shift.sum())
        # As many squares at once as int64 surely holds.
        largest = max(1, int(shift.max(initial=0)), -int(shift.min(initial=0)))
        step = max(1, (1 << 62) // largest**2)
        for start in range(0, shift.size, step):
            part = shift[start : start + step]
            self.squares += int(np.dot(part, part))

    def compare(self, a: Placements, b: Placements, level: float = 0.95) -> AucComparison:
        """Test for a difference, once all impostor scores of both were taken and counted.

        Args:
            a: Of one method.
            b: Of the other, its genuine scores in the same order.
            level: Confidence level of the interval of the difference.

        Raises:
            ScoreError: Fewer than two scores of a kind, or a level outside (0, 1).
        """
        level, m, n = check_level(level), a.genuine.size, a.n_impostor
        _check_numbers(m, n)
        shift = a.of_genuine - b.of_genuine
        # The sum over genuine placements and that over impostor placements are both 2 m n AUC.
        difference = float(Fraction(int(shift.sum()), 2 * m * n))
        variance = _variance_of_mean(shift, np.ones_like(shift)) / (2 * n) ** 2
        variance += _variance_from_sums(self.total, self.squares, n) / (2 * m) ** 2
        return _compare(difference, math.sqrt(variance), level)


def _compare(difference: float, std: float, level: float) -> AucComparison:
    reach = normal_quantile(level) * std
    z = difference / std if std > 0 else 0.0
    if std == 0 and difference:
        z = math.copysign(math.inf, difference)
    log_p = min(0.0, math.log(2) + float(log_ndtr(-abs(z))))
    return AucComparison(
        difference=difference,
        z=z,
        p=math.erfc(abs(z) / math.sqrt(2)),
        log10_p=log_p / math.log(10),
        low=difference - reach,
        high=difference + reach,
        std=std,
        level=level,
        degenerate=std == 0,
    )


def _area(placements: Placements) -> Fraction:
    doubled = int((placements.ties * (placements.lo + placements.hi)).sum())
    return Fraction(doubled, 2 * placements.genuine.size * placements.n_impostor)


def _check_numbers(m: int, n: int) -> None:
    if min(m, n) < 2:
        raise ScoreError(
            f"{m} genuine and {n} impostor scores: a variance needs two of each; give more pairs"
        )


def _variance_of_mean(values: Ints, weights: Ints) -> Fraction:
    """Return the sample variance of integers with multiplicities, over their number, exactly.

    Centred on an integer near the mean first, so that the squares stay small; Python's integers
    take over where int64 could not hold the sum.
    """
    size = int(weights.sum())
    centred = values - int(values[int(np.argmax(weights))])
    largest = int(np.abs(centred).max())
    if largest**2 * size >= 1 << 62:
        centred, weights = centred.astype(object), weights.astype(object)
    weighted = weights * centred
    return _variance_from_sums(int(weighted.sum()), int((weighted * centred).sum()), size)


def _variance_from_sums(total: int, squares: int, size: int) -> Fraction:
    return Fraction(squares * size - total**2, size * size * (size - 1))


def normal_quantile(level: float) -> float:
    """Return the two-sided standard normal quantile, 1.96 for 0.95.

    Raises:
        ScoreError: The level lies outside (0, 1).

    Example:
        >>> round(normal_quantile(0.95), 4)
        1.96
    """
    return float(ndtri(0.5 + check_level(level) / 2))


def check_level(level: Any) -> float:
    """Return a confidence level of any numeric type.

    Raises:
        ScoreError: It is no number in (0, 1).
    """
    number = plain_number(level, "confidence level")
    if not 0 < number < 1:
        raise ScoreError(f"confidence level {level}: wanted a number between 0 and 1")
    return number


def _logistic(x: float) -> float:
    return 1 / (1 + math.exp(-x)) if x >= 0 else math.exp(x) / (1 + math.exp(x))
