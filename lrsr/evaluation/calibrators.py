"""Which likelihood ratio does a score stand for? Learned from scores of other people.

All are log10 LR, of balanced classes: the numbers of pairs at hand say nothing about a case. A
ratio beyond what the data can support is cut to the empirical bounds (ELUB) of Vergeer et al.
(Science & Justice 56, 2016).

NFI's `lir` is the field's library. It is the oracle of these functions (tests/data/lir.json), not a
dependency: it would bring optuna, pydantic and a second way to configure and to plot, and its
measures have no interval over people, for which the pairs must be weighted anyway.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import isotonic_regression

from lrsr.errors import ScoreError
from lrsr.evaluation.arrays import check_finite, check_scores, float_array

Floats = NDArray[np.float64]
Calibration = Callable[[ArrayLike], Floats]
"""Turns scores ``(n,)`` into log10 LR ``(n,)``."""

_STEP = 0.01
_EXTREME = 9.0
_GRID = 401
_RIDGE = 1e-9
_LN10 = math.log(10)


def fit_logistic(genuine: ArrayLike, impostor: ArrayLike) -> Calibration:
    """Fit log LR = a + b score by maximum likelihood, both kinds weighing the same.

    Args:
        genuine: ``(m,)`` scores, m >= 1.
        impostor: ``(n,)`` scores, n >= 1. A ridge of 1e-9 per pair on the slope keeps it finite
            where the kinds are separated completely.

    Raises:
        ScoreError: A side is empty, a score is not finite, or all scores are alike.

    Example:
        >>> calibrate = fit_logistic([1, 2, 3, 4], [0, 1, 2, 3])
        >>> calibrate([2, 3]).round(3).tolist()
        [0.0, 0.328]
    """
    scores, share = _pooled(genuine, impostor)
    mean, spread = float(scores.mean()), float(scores.std())
    if spread == 0:
        raise ScoreError("all scores are alike: there is nothing to calibrate")
    inputs = np.stack([np.ones_like(scores), (scores - mean) / spread])
    weights = np.where(share > 0, 0.5 / share.sum(), 0.5 / (1 - share).sum())
    ridge, found = np.array([0.0, _RIDGE]), np.zeros(2)
    for _ in range(200):
        odds = found @ inputs
        posterior = np.exp(-np.logaddexp(0, -odds))
        gradient = inputs @ (weights * (posterior - share)) + ridge * found
        hessian = (inputs * (weights * posterior * (1 - posterior))) @ inputs.T + np.diag(ridge)
        step = np.linalg.solve(hessian + 1e-15 * np.eye(2), gradient)
        step *= min(1.0, 2.0 / float(np.abs(step).max()))  # far away Newton's own is too long
        found -= step
        if np.abs(step).max() < 1e-12:
            break
    intercept, slope = float(found[0]), float(found[1])

    def calibrate(values: ArrayLike) -> Floats:
        given = float_array(values, "scores")
        return (intercept + slope * (given - mean) / spread) / _LN10

    return calibrate


def fit_pav(genuine: ArrayLike, impostor: ArrayLike, misleading: int = 1) -> Calibration:
    """Fit the rising step function that suits the scores best, by pooling adjacent violators.

    Between its steps the posterior at equal priors is interpolated.

    Args:
        genuine: ``(m,)`` scores, m >= 1.
        impostor: ``(n,)`` scores, n >= 1.
        misleading: Pairs of each kind added beyond the other end, so that every ratio is finite; 0:
            the ends are infinite, as in the optimum that Cllr_min is made of.

    Raises:
        ScoreError: A side is empty or a score is not finite.
    """
    scores, share = _pooled(genuine, impostor)
    extra = np.repeat([float(scores.max()) + 1, float(scores.min()) - 1], misleading)
    scores = np.append(scores, extra)
    share = np.append(share, np.repeat([0.0, 1.0], misleading))
    values, where = np.unique(scores, return_inverse=True)
    own = np.bincount(where, share) / share.sum()
    other = np.bincount(where, 1 - share) / (1 - share).sum()
    posterior = pool(own, other)

    def calibrate(given: ArrayLike) -> Floats:
        return log_odds(np.interp(float_array(given, "scores"), values, posterior))

    return calibrate


def fit_kde(genuine: ArrayLike, impostor: ArrayLike) -> Calibration:
    """Divide two densities, each a sum of normal kernels of Silverman's width.

    Both are measured at 401 places and their logarithms interpolated between them; beyond three
    widths outside all scores the ratio stays as it is there.

    Args:
        genuine: ``(m,)`` scores, m >= 2.
        impostor: ``(n,)`` scores, n >= 2.

    Raises:
        ScoreError: Fewer than two scores of a kind, a score that is not finite, or all of a kind
            alike.
    """
    kinds = [_checked(genuine, "genuine", 2), _checked(impostor, "impostor", 2)]
    widths = []
    for name, scores in zip(("genuine", "impostor"), kinds, strict=True):
        if (spread := float(scores.std())) == 0:
            raise ScoreError(f"all {name} scores are alike: a density needs spread")
        widths.append(spread * (4 / 3 / scores.size) ** 0.2)
    reach = 3 * max(widths)
    low, high = min(s.min() for s in kinds) - reach, max(s.max() for s in kinds) + reach
    grid = np.linspace(low, high, _GRID)
    densities = [_log_density(grid, *kind) for kind in zip(kinds, widths, strict=True)]
    ratio = (densities[0] - densities[1]) / _LN10

    def calibrate(given: ArrayLike) -> Floats:
        return np.interp(float_array(given, "scores"), grid, ratio)

    return calibrate


CALIBRATORS: Mapping[str, Callable[[ArrayLike, ArrayLike], Calibration]] = {
    "logistic": fit_logistic,
    "pav": fit_pav,
    "kde": fit_kde,
}
"""By the name of the setting ``calibration``."""


@dataclass(frozen=True)
class Bounds:
    """Where ratios stop to be supported, log10 LR.

    Attributes:
        low: At most 0.
        high: At least 0.
    """

    low: float
    high: float


def elub(genuine_llr: ArrayLike, impostor_llr: ArrayLike) -> Bounds:
    """Return the empirical lower and upper bound (ELUB) of a set of ratios.

    Beyond them, deciding by these ratios, with one misleading pair of each kind more, would cost
    more than deciding without (Vergeer et al. 2016, eqs. 5 to 8); looked for in steps of 0.01.

    Args:
        genuine_llr: ``(m,)`` log10 LR, infinities allowed.
        impostor_llr: ``(n,)`` the same.
    """
    own, other = (
        np.sort(np.clip(float_array(llr, "likelihood ratios").reshape(-1), -_EXTREME, _EXTREME))
        for llr in (genuine_llr, impostor_llr)
    )
    least = max(min(own[0], other[0]), -math.log10(own.size + 1))
    most = min(max(own[-1], other[-1]), math.log10(other.size + 1))
    first, last = min(0, math.floor(least / _STEP)), max(0, math.floor(most / _STEP) + 1)
    threshold = np.linspace(first * _STEP, last * _STEP, last - first + 1)
    missed, accepted = (
        np.searchsorted(own, threshold, side="right") + 1,
        other.size - np.searchsorted(other, threshold, side="right") + 1,
    )
    odds = 10**threshold
    system = missed / (own.size + 1) + odds * accepted / (other.size + 1)
    worse = np.where(threshold < 0, odds, 1.0) < system  # without: all accepted, or none
    below, above = threshold[worse & (threshold <= 0)], threshold[worse & (threshold >= 0)]
    low = float(np.max(below + _STEP, initial=threshold[0]))
    high = float(np.min(above - _STEP, initial=threshold[-1]))
    return Bounds(min(low, 0.0), max(high, 0.0))


def pool(genuine: Floats, impostor: Floats) -> Floats:
    """Return the rising posterior of classes in order that suits their weights best.

    Args:
        genuine: ``(c,)`` weight of the genuine scores of each class; no class is empty of both.
        impostor: ``(c,)`` of the impostor scores.
    """
    weight = genuine + impostor
    found: Floats = isotonic_regression(genuine / weight, weights=weight).x
    return found


def log_odds(posterior: Floats) -> Floats:
    """Return log10 p / (1 - p); infinite at 0 and 1."""
    with np.errstate(divide="ignore"):
        found: Floats = np.log10(posterior) - np.log10(1 - posterior)
    return found


def _log_density(places: Floats, scores: Floats, width: float) -> Floats:
    """Return the natural logarithm of a kernel density, some places at a time."""
    found = np.empty_like(places)
    step = max(1, (1 << 21) // scores.size)
    for start in range(0, places.size, step):
        part = -(((places[start : start + step, None] - scores) / width) ** 2) / 2
        top = part.max(axis=1)
        found[start : start + step] = top + np.log(np.exp(part - top[:, None]).sum(axis=1))
    return found - math.log(scores.size * width)


def _pooled(genuine: ArrayLike, impostor: ArrayLike) -> tuple[Floats, Floats]:
    """Return all scores, and 1 for those that are genuine."""
    own, other = _checked(genuine, "genuine", 1), _checked(impostor, "impostor", 1)
    return np.append(own, other), np.append(np.ones(own.size), np.zeros(other.size))


def _checked(scores: ArrayLike, name: str, at_least: int) -> Floats:
    array = check_scores(scores, name, at_least=at_least).astype(np.float64)
    check_finite(array, name)
    return array
