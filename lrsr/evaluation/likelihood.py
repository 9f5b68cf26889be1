"""What is a score worth as evidence? Calibrated on some people, and judged on the others.

A likelihood ratio is as good as its cost, Cllr (Brümmer and du Preez, Computer Speech and Language
20, 2006): 0 is perfect, 1 as good as none, more is harmful. Cllr_min is that of the best rising
calibration of the very same scores, what they can tell apart; the rest, Cllr_cal, is owed to the
calibration. Tippett and ECE plots (Ramos and Gonzalez-Rodriguez, Forensic Science International
230, 2013) show the ratios behind it. Intervals are those of the bootstrap over the people who are
judged, with the calibration as it is: percentiles of the draws for Cllr, their spread about the
value for the two that pooling takes part in.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import expit

from lrsr.errors import ScoreError
from lrsr.evaluation.arrays import Array, float_array
from lrsr.evaluation.bootstrap import Draws, draw_people, percentiles, weigh, weighted_means
from lrsr.evaluation.calibrators import (
    CALIBRATORS,
    Calibration,
    Floats,
    elub,
    fit_pav,
    log_odds,
    pool,
)
from lrsr.evaluation.delong import normal_quantile
from lrsr.evaluation.pooled import PooledPairs
from lrsr.evaluation.scores import Index, ScoreSource

TIPPETT_LLRS = np.round(np.arange(-6, 6.01, 0.1), 10)
"""Where Tippett curves are measured, log10 LR."""

ECE_ODDS = np.round(np.arange(-3, 3.01, 0.2), 10)
"""Prior log10 odds at which the cross-entropy is measured."""

_FEWEST = 10
"""People with a genuine score, on either side of the split, below which nothing is calibrated."""

_OF_CURVES = 200
"""Draws of people for the bands of curves; costs have all that are asked for."""

_MOST = 1000
"""People on either side; further ones are left out, as a million pairs say enough."""


@dataclass(frozen=True)
class Cost:
    """A cost with its interval over people; every field goes to JSON.

    Attributes:
        value: Bits.
        low: Lower end; None where no people were drawn.
        high: Upper end.
    """

    value: float
    low: float | None = None
    high: float | None = None


@dataclass(frozen=True, eq=False)
class Curve:
    """A curve with its pointwise band over people.

    Attributes:
        values: ``(k,)``.
        low: ``(k,)`` lower limit; None where no people were drawn.
        high: ``(k,)`` upper limit.
    """

    values: Floats
    low: Floats | None = None
    high: Floats | None = None


@dataclass(frozen=True, eq=False)
class Evidence:
    """What the likelihood ratios of one method are worth.

    Attributes:
        calibration: How scores became ratios.
        cllr: Cost of the ratios.
        cllr_min: Cost of the best rising calibration of the same scores.
        cllr_cal: The difference.
        bound_low: Empirical lower bound, log10 LR; no ratio is below it.
        bound_high: Empirical upper bound.
        misleading_genuine: Share of genuine pairs with LR < 1.
        misleading_impostor: Share of impostor pairs with LR > 1.
        n_development: People who were calibrated on.
        n_test: People who were judged.
        n_genuine: Genuine pairs of those.
        n_impostor: Impostor pairs of those.
        tippett_genuine: Share of genuine pairs with at least the LR of :data:`TIPPETT_LLRS`.
        tippett_impostor: The same of impostor pairs.
        ece: Empirical cross-entropy at the odds of :data:`ECE_ODDS`, bits.
        ece_min: That of the best rising calibration; without a band.
        ece_none: That of LR = 1 for all.
    """

    calibration: str
    cllr: Cost
    cllr_min: Cost
    cllr_cal: Cost
    bound_low: float
    bound_high: float
    misleading_genuine: float
    misleading_impostor: float
    n_development: int
    n_test: int
    n_genuine: int
    n_impostor: int
    tippett_genuine: Curve
    tippett_impostor: Curve
    ece: Curve
    ece_min: Curve
    ece_none: Floats


def cllr(genuine_llr: ArrayLike, impostor_llr: ArrayLike) -> float:
    """Return the cost of log10 likelihood ratios, bits (Brümmer and du Preez 2006, eq. 39).

    Args:
        genuine_llr: ``(m,)`` of mated pairs; may be infinite.
        impostor_llr: ``(n,)`` of non-mated pairs.

    Raises:
        ScoreError: A side is empty or holds a NaN.

    Example:
        >>> round(cllr([1.0], [-1.0]), 4), cllr([0.0], [0.0])
        (0.1375, 1.0)
    """
    own, other = _ratios(genuine_llr, "genuine"), _ratios(impostor_llr, "impostor")
    return float(_penalty(-own).mean() + _penalty(other).mean()) / 2


def cllr_min(genuine: ArrayLike, impostor: ArrayLike) -> float:
    """Return the cost of the best rising calibration of scores, bits; of ratios or any others.

    Raises:
        ScoreError: A side is empty, or a score is not finite.

    Example:
        >>> cllr_min([2, 3], [0, 1])
        0.0
    """
    best = fit_pav(genuine, impostor, misleading=0)
    return cllr(best(genuine), best(impostor))


def cross_entropy(genuine_llr: ArrayLike, impostor_llr: ArrayLike, odds: ArrayLike) -> Floats:
    """Return the empirical cross-entropy at prior odds, bits; at odds 0 that is Cllr.

    Args:
        genuine_llr: ``(m,)`` log10 LR.
        impostor_llr: ``(n,)`` the same.
        odds: ``(k,)`` prior log10 odds.

    Raises:
        ScoreError: A side is empty or holds a NaN, or odds are not finite.
    """
    own, other = _ratios(genuine_llr, "genuine"), _ratios(impostor_llr, "impostor")
    places = float_array(odds, "prior odds").reshape(-1)
    if not np.isfinite(places).all():
        raise ScoreError("prior odds: a NaN or an infinity among them; give finite log10 odds")
    prior = expit(places * math.log(10))
    costs = [
        p * _penalty(-own - x).mean() + (1 - p) * _penalty(other + x).mean()
        for p, x in zip(prior.tolist(), places.tolist(), strict=True)
    ]
    return np.array(costs)


def split_people(source: ScoreSource, seed: int) -> tuple[list[str], list[str]]:
    """Part people at random into development and test; equal people and seeds, equal halves."""
    return split_ids(
        {*source.probe_ids, *(source.gallery_ids if source.people_known else ())}, seed
    )


def split_ids(ids: Iterable[str], seed: int) -> tuple[list[str], list[str]]:
    """Part people at random as :func:`split_people` does; in which order they come is the same."""
    people = sorted({*ids})
    order = np.random.default_rng(seed).permutation(len(people))
    half = len(people) // 2
    parts = order[:half], order[half:]
    return tuple([people[k] for k in part[:_MOST]] for part in parts)  # type: ignore[return-value]  # two


def weigh_evidence(
    source: ScoreSource,
    calibration: str = "logistic",
    *,
    bootstrap: int = 0,
    seed: int = 0,
    level: float = 0.95,
) -> Evidence:
    """Calibrate on half of the people and judge the ratios of the other half.

    Pairs of one person of each half are left out. Ratios are cut to the bounds of
    :func:`lrsr.evaluation.calibrators.elub`, found on the development half.

    Args:
        source: All scores.
        calibration: One of :data:`lrsr.evaluation.calibrators.CALIBRATORS`.
        bootstrap: Draws of people for the intervals; 0: none.
        seed: Of split and draws.
        level: Of the intervals, in (0, 1).

    Raises:
        ScoreError: No such calibration, or fewer than ten people with a genuine score in a half.
    """
    learn, judge = (source.restricted(people) for people in split_people(source, seed))
    return judge_evidence(learn, judge, calibration, bootstrap=bootstrap, seed=seed, level=level)


def judge_evidence(
    development: ScoreSource,
    test: ScoreSource,
    calibration: str = "logistic",
    *,
    bootstrap: int = 0,
    seed: int = 0,
    level: float = 0.95,
) -> Evidence:
    """Calibrate on scores of some people and judge the ratios of others, maybe pictured otherwise.

    Args:
        development: Scores that are calibrated on.
        test: Scores that are judged; of nobody who is in the others.
        calibration: See :func:`weigh_evidence`, as the next ones.
        bootstrap: Draws of people.
        seed: Of the draws.
        level: Of the intervals.

    Raises:
        ScoreError: No such calibration, or fewer than ten people with a genuine score on a side.
    """
    learn = find_calibrator(calibration)
    for part in (development, test):
        check_enough(part)
    own, other = development.genuine(), development.impostor()
    calibrate = learn(own, other)
    bounds = elub(calibrate(own), calibrate(other))
    pairs = PooledPairs(test)
    draws = draw_people(test, bootstrap, seed) if bootstrap and test.people_known else None
    ratios = [
        np.clip(calibrate(one), bounds.low, bounds.high) for one in (pairs.genuine, pairs.impostor)
    ]
    judge = _Judge(pairs, ratios, draws, level)
    costs, curves = judge.costs(), judge.curves()
    return Evidence(
        calibration=calibration,
        cllr=costs["cllr"],
        cllr_min=costs["cllr_min"],
        cllr_cal=costs["cllr_cal"],
        bound_low=bounds.low,
        bound_high=bounds.high,
        misleading_genuine=float((ratios[0] < 0).mean()),
        misleading_impostor=float((ratios[1] > 0).mean()),
        n_development=len({*development.probe_ids}),
        n_test=len({*test.probe_ids}),
        n_genuine=pairs.genuine.size,
        n_impostor=pairs.impostor.size,
        tippett_genuine=curves["tippett_genuine"],
        tippett_impostor=curves["tippett_impostor"],
        ece=curves["ece"],
        ece_min=curves["ece_min"],
        ece_none=cross_entropy([0.0], [0.0], ECE_ODDS),
    )


def find_calibrator(name: str) -> Callable[[ArrayLike, ArrayLike], Calibration]:
    """Return what learns a calibration from genuine and impostor scores.

    Raises:
        ScoreError: There is none of that name.
    """
    if name not in CALIBRATORS:
        raise ScoreError(f"calibration {name}: wanted one of {', '.join(CALIBRATORS)}")
    return CALIBRATORS[name]


def check_enough(part: ScoreSource) -> None:
    """Refuse scores of too few people to calibrate on or to judge by.

    Raises:
        ScoreError: Fewer than ten people have a genuine score, or nobody has an impostor score.
    """
    scored = {
        part.probe_ids[row]
        for row, score in zip(part.mates[0].tolist(), part.mated_scores().tolist(), strict=True)
        if not math.isnan(score)
    }
    if len(scored) < _FEWEST or not part.impostor().size:
        raise ScoreError(
            f"{len(scored)} people with a genuine score in one half: likelihood ratios need "
            f"{_FEWEST} to calibrate on and {_FEWEST} to judge"
        )


class _Judge:
    """Measures ratios under every draw of people; the first column is everybody once."""

    def __init__(
        self, pairs: PooledPairs, ratios: Sequence[Floats], draws: Draws | None, level: float
    ) -> None:
        self._pairs, self._ratios, self._level = pairs, ratios, level
        people = 1 + max(int(code.max()) for code in (pairs.who, pairs.left, pairs.right))
        once = np.ones((people if draws is None else len(draws), 1), dtype=np.float32)
        self._draws = once if draws is None else np.hstack([once, draws])
        self._best = self._pooled()

    def costs(self) -> dict[str, Cost]:
        """Return Cllr, Cllr_min and Cllr_cal."""
        none = np.zeros(1)
        cost, least = self._entropies(none, self._draws)[0], self._least(none)[0]
        return {
            "cllr": self._cost(cost),
            "cllr_min": self._spread_cost(least),
            "cllr_cal": self._spread_cost(cost - least),
        }

    def curves(self) -> dict[str, Curve]:
        """Return the Tippett and the cross-entropy curves."""
        draws = self._draws[:, : 1 + _OF_CURVES]
        genuine, impostor = (
            (one >= TIPPETT_LLRS[:, None]).astype(np.float32) for one in self._ratios
        )
        own, other = self._means(genuine, impostor, draws)
        return {
            "tippett_genuine": self._curve(own),
            "tippett_impostor": self._curve(other),
            "ece": self._curve(self._entropies(ECE_ODDS, draws)),
            "ece_min": Curve(self._least(ECE_ODDS, 1)[:, 0]),
        }

    def _means(self, genuine: Array, impostor: Array, draws: Draws) -> tuple[Floats, Floats]:
        """Average features ``(k, pairs)`` of each kind under every draw: ``(k, draws)``."""
        pairs = self._pairs
        own = weighted_means(draws, genuine, pairs.who)
        return own, weighted_means(draws, impostor, pairs.left, pairs.right)

    def _entropies(self, odds: Floats, draws: Draws) -> Floats:
        own, other = self._means(
            _penalty(-self._ratios[0] - odds[:, None]),
            _penalty(self._ratios[1] + odds[:, None]),
            draws,
        )
        prior = (1 / (1 + 10**-odds))[:, None]
        found: Floats = prior * own + (1 - prior) * other
        return found

    def _pooled(self) -> tuple[Floats, Floats, Floats]:
        """Pool the classes of every draw: log10 LR and the weight of each kind, ``(c, draws)``."""
        pairs = self._pairs
        mine, others, number = _runs(pairs.genuine, pairs.impostor)
        genuine = weigh(self._draws, mine, number, pairs.who)
        impostor = weigh(self._draws, others, number, pairs.left, pairs.right)
        with np.errstate(invalid="ignore"):
            genuine /= genuine.sum(axis=0)
            impostor /= impostor.sum(axis=0)
        ratio = np.zeros_like(genuine)
        for draw in range(genuine.shape[1]):
            some = genuine[:, draw] + impostor[:, draw] > 0
            ratio[some, draw] = log_odds(pool(genuine[some, draw], impostor[some, draw]))
        return ratio, genuine, impostor

    def _least(self, odds: Floats, draws: int | None = None) -> Floats:
        """Return the cross-entropy of the best ratios under so many draws."""
        ratio, own, other = (part[:, :draws] for part in self._best)
        found = np.empty((odds.size, ratio.shape[1]))
        with np.errstate(invalid="ignore"):  # a class without weight costs nothing
            for k, x in enumerate(odds.tolist()):
                prior = 1 / (1 + 10**-x)
                mine = np.where(own == 0, 0.0, own * _penalty(-ratio - x)).sum(axis=0)
                others = np.where(other == 0, 0.0, other * _penalty(ratio + x)).sum(axis=0)
                found[k] = prior * mine + (1 - prior) * others
        return found

    def _cost(self, found: Floats) -> Cost:
        if found.size == 1:
            return Cost(float(found[0]))
        return Cost(float(found[0]), *percentiles(found[1:], self._level))

    def _spread_cost(self, found: Floats) -> Cost:
        """Put the draws' spread about the value.

        Their percentiles would miss it: among copies of the same people the best calibration fits
        better than among as many different ones.
        """
        value = float(found[0])
        if found.size == 1:
            return Cost(value)
        reach = normal_quantile(self._level) * float(np.nanstd(found[1:]))
        return Cost(value, max(0.0, value - reach), value + reach)

    def _curve(self, found: Floats) -> Curve:
        if found.shape[1] == 1:
            return Curve(found[:, 0])
        tail = (1 - self._level) / 2
        low, high = np.nanquantile(found[:, 1:], [tail, 1 - tail], axis=1)
        return Curve(found[:, 0], low, high)


def _runs(genuine: Floats, impostor: Floats) -> tuple[Index, Index, int]:
    """Return the class of every score: neighbours of one kind are one, as pooling joins them."""
    values, where = np.unique(np.append(genuine, impostor), return_inverse=True)
    own = np.bincount(where[: genuine.size], minlength=values.size)
    other = np.bincount(where[genuine.size :], minlength=values.size)
    kind = np.where(own == 0, 0, np.where(other == 0, 1, 2))
    starts = np.append(True, (np.diff(kind) != 0) | (kind[1:] == 2))
    classes = (np.cumsum(starts) - 1)[where]
    return classes[: genuine.size], classes[genuine.size :], int(starts.sum())


def _penalty(llr: Floats) -> Floats:
    """Return log2(1 + LR) of log10 LR, which may be infinite."""
    found: Floats = np.where(llr == -np.inf, 0.0, np.logaddexp2(0, llr * math.log2(10)))
    return found


def _ratios(llr: ArrayLike, name: str) -> Floats:
    ratios = float_array(llr, f"{name} likelihood ratios").reshape(-1)
    if ratios.size == 0 or np.isnan(ratios).any():
        raise ScoreError(f"{ratios.size} {name} likelihood ratios, or a NaN among them")
    return ratios
