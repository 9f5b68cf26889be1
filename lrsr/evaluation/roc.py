"""Which true-match rates can be had at which false-match rates, and how sure is the curve?

A comparison matches when its score is at or above the threshold (ISO/IEC 19795-1). A curve holds
every corner of the step function, at most two per distinct genuine score, read off the exact
counts: nothing is binned, thinned or interpolated. Between two corners with equal true-match rate
the curve is flat, with equal false-match rate upright; a slanted piece is a tie of genuine and
impostor scores, whose inside no threshold reaches (the area under it is the tie's one half).
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lrsr.errors import ScoreError
from lrsr.evaluation.arrays import plain_array, plain_number
from lrsr.evaluation.delong import check_level, normal_quantile
from lrsr.evaluation.placements import Ints, Placements

_Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RocCurve:
    """The corners of an ROC curve from (0, 0) to (1, 1), the threshold falling.

    Attributes:
        thresholds: ``(c,)`` accepting score >= threshold gives the corner; the first is infinite.
        false_matches: ``(c,)`` impostor scores at or above the threshold.
        true_matches: ``(c,)`` genuine scores at or above the threshold.
        n_genuine: Genuine scores.
        n_impostor: Impostor scores.
    """

    thresholds: _Floats
    false_matches: Ints
    true_matches: Ints
    n_genuine: int
    n_impostor: int

    @property
    def fmr(self) -> _Floats:
        """``(c,)`` false-match rate of each corner, rising."""
        return self.false_matches / self.n_impostor

    @property
    def tmr(self) -> _Floats:
        """``(c,)`` true-match rate of each corner, rising."""
        return self.true_matches / self.n_genuine

    @property
    def fnmr(self) -> _Floats:
        """``(c,)`` false-non-match rate, 1 - tmr, falling."""
        return (self.n_genuine - self.true_matches) / self.n_genuine

    @property
    def auc(self) -> float:
        """Area under the curve: exactly that of :func:`lrsr.evaluation.delong.measure_auc`."""
        steps = np.diff(self.false_matches)
        doubled = int((steps * (self.true_matches[1:] + self.true_matches[:-1])).sum())
        return doubled / (2 * self.n_genuine * self.n_impostor)


@dataclass(frozen=True, eq=False)
class RocBand:
    """A pointwise confidence band of an ROC curve, as two step functions of the FMR.

    Attributes:
        fmr: ``(f,)`` rising from 0 to 1.
        low: ``(f,)`` lower limit of the true-match rate, valid up to the next FMR (a step "post").
        high: ``(f,)`` upper limit, valid down to the FMR before (a step "pre").
        level: Confidence level, pointwise.
    """

    fmr: _Floats
    low: _Floats
    high: _Floats
    level: float


@dataclass(frozen=True)
class PartialArea:
    """The area under the part of an ROC curve with few false matches; every field goes to JSON.

    Attributes:
        max_fmr: The part's end, (0, 1].
        area: 0 to ``max_fmr``.
        standardised: The area on the scale of the whole one, where 1 is perfect and 0.5 guessing.
    """

    max_fmr: float
    area: float
    standardised: float


def partial_area(curve: RocCurve, max_fmr: float) -> PartialArea:
    """Measure the area at FMRs from 0 to ``max_fmr``, straight lines between the corners.

    Standardised as McClish (Medical Decision Making 9, 1989) does: (1 + (A - g) / (e - g)) / 2,
    where e is the end, the area of a perfect method, and g = e^2 / 2 that of guessing.

    Args:
        curve: Of :func:`trace_roc_of`.
        max_fmr: In (0, 1].

    Raises:
        ScoreError: The end lies outside (0, 1].

    Example:
        >>> from lrsr.evaluation.placements import place
        >>> found = partial_area(trace_roc_of(place([2, 4], [1, 3])), 0.5)
        >>> found.area, round(found.standardised, 4)
        (0.25, 0.6667)
    """
    end = plain_number(max_fmr, "largest FMR")
    if not 0 < end <= 1:
        raise ScoreError(f"largest FMR {max_fmr}: wanted a number above 0, to 1")
    inside = int(np.searchsorted(curve.fmr, end, side="right"))
    fmr = np.append(curve.fmr[:inside], end)
    last = np.interp(end, curve.fmr[inside - 1 :], curve.tmr[inside - 1 :])
    tmr = np.append(curve.tmr[:inside], last)
    area, guessing = float(np.dot(np.diff(fmr), tmr[1:] + tmr[:-1])) / 2, end**2 / 2
    return PartialArea(end, area, (1 + (area - guessing) / (end - guessing)) / 2)


def trace_roc_of(placements: Placements) -> RocCurve:
    """Return every corner of the ROC curve of impostor scores that were counted.

    Raises:
        ScoreError: No impostor score was counted.
    """
    if placements.n_impostor == 0:
        raise ScoreError("0 impostor scores: a curve needs at least 1")
    # Thresholds keep the dtype of the scores, so that comparing them rounds nothing.
    values = placements.values[::-1]
    values = values if values.dtype.kind == "f" else values.astype(np.float64)
    thresholds = np.full(2 * values.size + 2, np.inf)
    thresholds[1:-1:2] = np.nextafter(values, values.dtype.type(np.inf))  # just above, then at it
    thresholds[2:-1:2], thresholds[-1] = values, -np.inf
    own = np.zeros_like(placements.sizes)
    own[1::2] = placements.ties
    false_matches, true_matches = (
        np.concatenate(([0], np.cumsum(of_class[::-1]))) for of_class in (placements.sizes, own)
    )
    keep = np.ones(thresholds.size, dtype=bool)
    keep[1:] = (np.diff(false_matches) > 0) | (np.diff(true_matches) > 0)
    return RocCurve(
        thresholds[keep],
        false_matches[keep],
        true_matches[keep],
        placements.genuine.size,
        placements.n_impostor,
    )


def wilson_interval(
    successes: ArrayLike, trials: int, level: float = 0.95
) -> tuple[_Floats, _Floats]:
    """Return Wilson's score interval of a proportion (JASA 22, 1927).

    Args:
        successes: Any shape, 0 to ``trials``.
        trials: How many independent trials, >= 1.
        level: Confidence level, in (0, 1).

    Raises:
        ScoreError: No trial, successes outside 0 to ``trials``, or a level outside (0, 1).

    Example:
        >>> low, high = wilson_interval(0, 10)
        >>> round(float(low), 4), round(float(high), 4)
        (0.0, 0.2775)
    """
    hits = plain_array(successes, "successes").astype(np.float64)
    count = plain_number(trials, "trials")
    if count < 1 or not ((hits >= 0) & (hits <= count)).all():
        raise ScoreError(
            f"{hits} successes in {count:g} trials: wanted at least 1, and 0 to as many"
        )
    square = normal_quantile(level) ** 2
    centre = (hits + square / 2) / (count + square)
    spread = hits * (count - hits) / count + square / 4
    half = np.sqrt(square * spread) / (count + square)
    low = np.where(hits == 0, 0.0, centre - half)
    high = np.where(hits == count, 1.0, centre + half)
    return low, high


def band(curve: RocCurve, level: float = 0.95) -> RocBand:
    """Put a pointwise confidence band round an ROC curve.

    At every threshold the FMR and the true-match rate are proportions of independent samples. Each
    gets a Wilson interval at the level's square root, so that the rectangle of the two holds the
    true point with ``level``; the band is what the rectangles sweep. No density is estimated (as
    the variance of Hsieh and Turnbull would need) and nothing is interpolated; the band errs on
    the wide side, by the second interval. It is pointwise, not simultaneous, and takes the pairs as
    independent: with several images per person it is too narrow.

    Args:
        curve: Of :func:`trace_roc_of`.
        level: Confidence level, in (0, 1).

    Raises:
        ScoreError: The level lies outside (0, 1).
    """
    level = check_level(level)
    each = math.sqrt(level)
    top = np.append(np.diff(curve.false_matches) > 0, True)  # of the upright pieces
    fmr_low, fmr_high = wilson_interval(curve.false_matches[top], curve.n_impostor, each)
    tmr_low, tmr_high = wilson_interval(curve.true_matches[top], curve.n_genuine, each)
    grid = np.unique(np.concatenate((curve.fmr, fmr_low, fmr_high, [0.0, 1.0])))
    # Below: the best rectangle that surely lies left of this FMR. Above: the first that surely
    # lies right of it.
    left = np.searchsorted(fmr_high, grid, side="right") - 1
    right = np.searchsorted(fmr_low, grid, side="left")
    low = np.where(left >= 0, tmr_low[left], 0.0)
    high = np.where(right < tmr_high.size, tmr_high[np.minimum(right, tmr_high.size - 1)], 1.0)
    return RocBand(grid, low, high, level)
