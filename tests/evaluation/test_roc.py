"""Tests of lrsr/evaluation/roc.py."""

from fractions import Fraction

import numpy as np
import pytest
from fakes.measures import trace_roc
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import ArrayLike
from oracles import auc as oracle
from scipy.stats import binomtest, norm
from sklearn.metrics import roc_auc_score, roc_curve

from lrsr.errors import ScoreError
from lrsr.evaluation.delong import measure_auc
from lrsr.evaluation.placements import Placements
from lrsr.evaluation.roc import (
    RocCurve,
    band,
    partial_area,
    trace_roc_of,
    wilson_interval,
)

score_lists = st.lists(st.integers(-6, 6), min_size=1, max_size=20)


def binormal(m: int = 200, n: int = 2000, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return rng.normal(1.5, 1, m), rng.normal(0, 1, n)


def tmr_at(curve: RocCurve, fmr: ArrayLike) -> np.ndarray:
    """The largest true-match rate that some threshold reaches at or below each FMR."""
    return np.asarray(curve.tmr[np.searchsorted(curve.fmr, np.asarray(fmr), side="right") - 1])


# Values from elsewhere.


@given(genuine=score_lists, impostor=score_lists)
@settings(deadline=None, max_examples=40)
def test_every_corner_is_attainable_and_every_attainable_point_lies_on_the_curve(
    genuine: list[int], impostor: list[int]
) -> None:
    curve = trace_roc(genuine, impostor)
    points = oracle.operating_points(genuine, impostor)
    corners = {
        (Fraction(f, curve.n_impostor), Fraction(t, curve.n_genuine))
        for f, t in zip(curve.false_matches.tolist(), curve.true_matches.tolist(), strict=True)
    }
    assert corners <= set(points)
    for fmr, tmr in points:
        best = max(t for f, t in points if f <= fmr)
        assert float(tmr_at(curve, float(fmr))) == pytest.approx(float(best), abs=1e-12)
        assert (fmr, tmr) in corners or any(
            f0 <= fmr <= f1 and t0 == tmr == t1 for (f0, t0) in corners for (f1, t1) in corners
        )


def test_corners_agree_with_scikit_learn() -> None:
    genuine, impostor = (x.round(1) for x in binormal())
    labels = np.repeat([1, 0], [genuine.size, impostor.size])
    fmr, tmr, _ = roc_curve(labels, np.concatenate((genuine, impostor)), drop_intermediate=False)
    theirs = set(zip((fmr * impostor.size).round(), (tmr * genuine.size).round(), strict=True))
    curve = trace_roc(genuine, impostor)
    assert set(zip(curve.false_matches, curve.true_matches, strict=True)) <= theirs


@pytest.mark.parametrize("successes", [0, 1, 7, 19, 20])
def test_wilson_interval_agrees_with_scipy(successes: int) -> None:
    theirs = binomtest(successes, 20).proportion_ci(0.9, method="wilson")
    low, high = wilson_interval(successes, 20, 0.9)
    assert (float(low), float(high)) == pytest.approx((theirs.low, theirs.high), abs=1e-14)


# Laws.


@given(genuine=score_lists, impostor=score_lists)
@settings(deadline=None, max_examples=40)
def test_area_under_the_corners_is_the_auc(genuine: list[int], impostor: list[int]) -> None:
    assert trace_roc(genuine, impostor).auc == measure_auc(genuine, impostor)


def test_a_threshold_is_found_between_scores_of_two_widths() -> None:
    curve = trace_roc(np.float32([0.5, 0.25]), np.array([0.5 + 1e-12, 0.0]))
    accepted = np.array([0.5 + 1e-12, 0.0]) >= curve.thresholds[:, None]
    assert (accepted.sum(axis=1) == curve.false_matches).all()


def test_accepting_at_a_corners_threshold_gives_the_corner() -> None:
    for dtype in (np.float32, np.float64):
        genuine, impostor = (x.round(1).astype(dtype) for x in binormal(40, 200))
        curve = trace_roc(genuine, impostor)
        accepted = impostor >= curve.thresholds[:, None].astype(dtype)
        assert (accepted.sum(axis=1) == curve.false_matches).all()
        accepted = genuine >= curve.thresholds[:, None].astype(dtype)
        assert (accepted.sum(axis=1) == curve.true_matches).all()


def test_there_are_at_most_two_corners_for_each_genuine_value() -> None:
    genuine, impostor = binormal(20, 5000)
    assert trace_roc(genuine, impostor).fmr.size <= 2 * 20 + 2


def test_rates_rise_along_the_curve() -> None:
    curve = trace_roc(*binormal())
    assert (np.diff(curve.fmr) >= 0).all()
    assert (np.diff(curve.tmr) >= 0).all()
    assert (np.diff(curve.thresholds) < 0).all()
    assert curve.fnmr == pytest.approx(1 - curve.tmr)


def test_a_rising_map_leaves_the_curve() -> None:
    genuine, impostor = binormal()
    a, b = trace_roc(genuine, impostor), trace_roc(np.exp(genuine), np.exp(impostor))
    assert (a.fmr == b.fmr).all()
    assert (a.tmr == b.tmr).all()


def test_nothing_is_interpolated_inside_a_tie() -> None:
    curve = trace_roc([1, 1], [1, 1])
    assert tmr_at(curve, [0.0, 0.5, 0.999, 1.0]).tolist() == [0, 0, 0, 1]


def test_blocks_trace_the_same_curve() -> None:
    genuine, impostor = binormal()
    placements = Placements(genuine)
    for part in np.array_split(impostor, 5):
        placements.count(placements.classes(part))
    streamed, whole = trace_roc_of(placements), trace_roc(genuine, impostor)
    assert (streamed.false_matches == whole.false_matches).all()


def test_band_holds_the_curve() -> None:
    curve = trace_roc(*binormal())
    limits = band(curve)
    place = np.searchsorted(limits.fmr, curve.fmr)
    assert (limits.low[place] <= tmr_at(curve, curve.fmr)).all()
    assert (curve.tmr <= limits.high[place]).all()


def test_band_rises_and_stays_in_range() -> None:
    limits = band(trace_roc(*binormal()))
    for side in (limits.low, limits.high):
        assert (np.diff(side) >= 0).all()
        assert ((side >= 0) & (side <= 1)).all()
    assert (limits.low <= limits.high).all()


def test_band_widens_with_the_level_and_narrows_with_the_pairs() -> None:
    def width(m: int, level: float) -> float:
        limits = band(trace_roc(*binormal(m, 20_000)), level)
        at = np.searchsorted(limits.fmr, 0.1)
        return float(limits.high[at] - limits.low[at])

    assert width(100, 0.5) < width(100, 0.95)
    assert width(1600, 0.95) < width(100, 0.95) / 2.5


@pytest.mark.parametrize("fmr", [0.01, 0.1, 0.5])
def test_band_covers_the_true_curve_at_least_as_often_as_it_says(fmr: float) -> None:
    rng = np.random.default_rng(2)
    truth = norm.sf(norm.isf(fmr) - 1.5)
    trials, hits = 300, 0
    for _ in range(trials):
        limits = band(trace_roc(rng.normal(1.5, 1, 100), rng.normal(0, 1, 2000)))
        low = limits.low[np.searchsorted(limits.fmr, fmr, side="right") - 1]
        high = limits.high[np.searchsorted(limits.fmr, fmr, side="left")]
        hits += low <= truth <= high
    assert hits >= 0.95 * trials - 3 * np.sqrt(trials * 0.95 * 0.05)


# Edges.


def test_complete_separation_is_an_upright_and_a_flat_line() -> None:
    curve = trace_roc([2, 3], [0, 1])
    assert (curve.fmr.tolist(), curve.tmr.tolist()) == ([0, 0, 0, 1], [0, 0.5, 1, 1])


def test_constant_scores_are_a_slanted_line() -> None:
    curve = trace_roc([1], [1, 1])
    assert (curve.fmr.tolist(), curve.tmr.tolist()) == ([0, 1], [0, 1])


def test_the_curve_starts_by_accepting_nothing_and_ends_by_accepting_all() -> None:
    curve = trace_roc([1], [0, 2])
    assert (curve.fmr[0], curve.tmr[0], curve.thresholds[0]) == (0, 0, np.inf)
    assert (curve.fmr[-1], curve.tmr[-1], curve.thresholds[-1]) == (1, 1, -np.inf)


# Errors.


def test_a_curve_without_genuine_scores_is_refused() -> None:
    with pytest.raises(ScoreError, match="0 genuine"):
        trace_roc([], [1.0])


def test_counts_without_impostor_scores_are_refused() -> None:
    with pytest.raises(ScoreError, match="0 impostor"):
        trace_roc_of(Placements([1.0]))


def test_a_band_of_level_one_is_refused() -> None:
    with pytest.raises(ScoreError, match="confidence level"):
        band(trace_roc([1], [0]), 1.0)


@pytest.mark.parametrize(("successes", "trials"), [(-1, 5), (6, 5), (0, 0)])
def test_impossible_proportions_are_refused(successes: int, trials: int) -> None:
    with pytest.raises(ScoreError, match="successes"):
        wilson_interval(successes, trials)


@pytest.mark.parametrize("end", [0.05, 0.3, 1.0])
def test_standardised_partial_area_is_that_of_scikit_learn(end: float) -> None:
    rng = np.random.default_rng(0)
    genuine, impostor = rng.normal(1, 1, 40).round(1), rng.normal(0, 1, 300).round(1)
    found = partial_area(trace_roc(genuine, impostor), end)
    truth = np.append(np.ones(40), np.zeros(300))
    wanted = roc_auc_score(truth, np.append(genuine, impostor), max_fpr=end)
    assert found.standardised == pytest.approx(wanted, abs=1e-12)


def test_whole_partial_area_is_the_area() -> None:
    curve = trace_roc([2, 4, 4], [1, 3, 4])
    assert partial_area(curve, 1).area == pytest.approx(curve.auc, abs=1e-12)


@pytest.mark.parametrize("end", [0, 1.5])
def test_a_partial_area_to_nowhere_is_refused(end: float) -> None:
    with pytest.raises(ScoreError, match="largest FMR"):
        partial_area(trace_roc([2, 4], [1, 3]), end)
