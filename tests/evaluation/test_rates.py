"""Tests of lrsr.evaluation.rates.py."""

import json
import math
from dataclasses import asdict
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import ArrayLike
from oracles import auc as oracle
from scipy.special import ndtr, ndtri

from lrsr.errors import ScoreError
from lrsr.evaluation.rates import (
    Highest,
    Moments,
    Ranker,
    cmc,
    d_prime,
    equal_error_rate,
    fnmr_at_fmr,
    operating_point,
)
from lrsr.evaluation.roc import trace_roc
from lrsr.evaluation.scores import Scores

NAN = float("nan")
score_lists = st.lists(st.integers(-6, 6), min_size=1, max_size=20)


def binormal(m: int = 200, n: int = 20_000, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return rng.normal(2, 1, m), rng.normal(0, 1, n)


def eer(genuine: ArrayLike, impostor: ArrayLike) -> float:
    return equal_error_rate(trace_roc(genuine, impostor))


def rank_probes(scores: Scores, rows: int = 2) -> np.ndarray:
    ranker = Ranker(scores)
    return np.concatenate([ranker.rank(tile) for tile in scores.tiles(rows)])


# FNMR at a stated FMR.


@given(genuine=score_lists, impostor=score_lists, percent=st.integers(0, 100))
@settings(deadline=None, max_examples=40)
def test_operating_point_is_the_best_of_all_thresholds(
    genuine: list[int], impostor: list[int], percent: int
) -> None:
    point = fnmr_at_fmr(genuine, impostor, percent / 100)
    allowed = [p for p in oracle.operating_points(genuine, impostor) if p[0] * 100 <= percent]
    fmr, tmr = max(allowed)
    assert (point.fmr, point.fnmr) == (float(fmr), float(1 - tmr))


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_accepting_at_the_threshold_gives_the_stated_errors(dtype: type) -> None:
    genuine, impostor = (x.round(2).astype(dtype) for x in binormal())
    for target in (0.1, 0.01, 0.001):
        point = fnmr_at_fmr(genuine, impostor, target)
        assert (impostor >= dtype(point.threshold)).sum() == point.false_matches
        assert (genuine < dtype(point.threshold)).mean() == pytest.approx(point.fnmr)


def test_a_target_is_the_decimal_that_was_written() -> None:
    # The float 0.3 is less than 3/10, yet three false matches of ten are 0.3.
    assert fnmr_at_fmr([0.0], np.arange(10), 0.3).false_matches == 3


def test_ties_across_the_target_stay_outside() -> None:
    point = fnmr_at_fmr([1.0, 3.0], [0, 2, 2, 2], 0.5)
    assert (point.fmr, point.fnmr) == (0, 0.5)


@pytest.mark.parametrize(("n", "few"), [(9_999, True), (10_000, False)])
def test_fewer_than_ten_expected_false_matches_are_flagged(n: int, few: bool) -> None:
    assert fnmr_at_fmr([1.0], np.arange(n), 0.001).few_false_matches is few


def test_an_fmr_of_one_accepts_all() -> None:
    point = fnmr_at_fmr([-9.0], [0.0], 1)
    assert (point.fmr, point.fnmr, point.threshold) == (1, 0, None)


def test_an_fmr_of_zero_refuses_every_impostor_score() -> None:
    point = fnmr_at_fmr([1.0, 2.0, 3.0], [0.0, 2.0], 0)
    assert (point.fmr, point.fnmr, point.threshold) == (0, 2 / 3, np.nextafter(2.0, 3))


def test_operating_point_carries_wilsons_interval() -> None:
    # 2 of 10 missed: Wilson (1927) gives 0.0567 to 0.5098.
    point = fnmr_at_fmr(np.arange(10), [1.5], 0)
    assert (point.fnmr_low, point.fnmr_high) == pytest.approx((0.0567, 0.5098), abs=5e-5)


def test_operating_point_goes_to_json() -> None:
    point = fnmr_at_fmr(*binormal(), 0.01)
    assert json.loads(json.dumps(asdict(point), allow_nan=False))["fmr"] == 0.01


@pytest.mark.parametrize("target", [-0.1, 1.1, NAN])
def test_a_target_outside_zero_to_one_is_refused(target: float) -> None:
    with pytest.raises(ScoreError, match="target FMR"):
        fnmr_at_fmr([1.0], [0.0], target)


@pytest.mark.parametrize(
    ("genuine", "impostor", "message"),
    [
        pytest.param([], [0.0], "0 genuine", id="no-genuine"),
        pytest.param([NAN], [0.0], "genuine score 0 is nan", id="nan-genuine"),
        pytest.param([1.0], [0.0, math.inf], "impostor score 1 is inf", id="infinite-impostor"),
    ],
)
def test_an_operating_point_of_broken_scores_is_refused(
    genuine: list[float], impostor: list[float], message: str
) -> None:
    with pytest.raises(ScoreError, match=message):
        fnmr_at_fmr(genuine, impostor, 0.1)


@pytest.mark.parametrize("target", [0.0, 0.001, 0.3, 0.999, 1.0])
@pytest.mark.parametrize("parts", [1, 7, 400])
def test_the_highest_scores_are_enough_for_an_operating_point(target: float, parts: int) -> None:
    genuine, impostor = (x.round(2) for x in binormal(50, 3000))
    highest = Highest(min(3000, int(target * 3000) + 1), impostor.dtype)
    for part in np.array_split(impostor, parts):
        highest.add(part)
    found = operating_point(genuine, highest.scores(), impostor.size, target)
    assert found == fnmr_at_fmr(genuine, impostor, target)


@pytest.mark.parametrize("count", [1, 10, 999, 1000])
def test_the_highest_scores_are_those_at_the_end_of_the_sorted_ones(count: int) -> None:
    scores = np.random.default_rng(count).integers(0, 300, 1000)
    highest = Highest(count, scores.dtype)
    for part in np.split(scores, [3, 3, 500, 980]):
        highest.add(part)
    assert np.sort(highest.scores())[-count:].tolist() == np.sort(scores)[-count:].tolist()


# Equal error rate.


def test_equal_error_rate_of_two_normals_is_the_tail_between_them() -> None:
    quantiles = (np.arange(2000) + 0.5) / 2000
    scores = ndtri(quantiles)
    assert eer(scores + 2, scores) == pytest.approx(ndtr(-1), abs=1e-3)


@given(genuine=score_lists, impostor=score_lists)
@settings(deadline=None, max_examples=40)
def test_equal_error_rate_lies_within_a_step_of_the_fvc_rule(
    genuine: list[int], impostor: list[int]
) -> None:
    points = [(f, 1 - t) for f, t in oracle.operating_points(genuine, impostor)]
    before = [point for point in points if point[0] <= point[1]][-1]
    after = next(point for point in points if point[0] >= point[1])
    steps = eer(genuine, impostor)
    low, high = sorted(before if sum(before) <= sum(after) else after)
    assert float(low) - 1e-12 <= steps <= float(high) + 1e-12


def test_a_jump_of_both_rates_takes_the_side_with_less_error() -> None:
    # At t = 1 FMR 2/3, FNMR 0; above it FMR 0, FNMR 1/2: the sum is less above.
    assert eer([1, 2], [0, 1, 1]) == 0.25


@pytest.mark.parametrize(
    ("genuine", "impostor", "wanted"),
    [
        pytest.param([2, 3], [0, 1], 0, id="separated"),
        pytest.param([1, 1], [1, 1], 0.5, id="constant"),
    ],
)
def test_equal_error_rate_at_the_extremes(
    genuine: list[int], impostor: list[int], wanted: float
) -> None:
    assert eer(genuine, impostor) == wanted


# d'.


def test_d_prime_of_unit_normals_is_their_distance() -> None:
    genuine, impostor = binormal(20_000, 20_000)
    assert d_prime(genuine, impostor) == pytest.approx(
        2, abs=4 * math.sqrt(2 / 20_000 + 1 / 20_000)
    )


def test_d_prime_ignores_shift_and_scale() -> None:
    genuine, impostor = binormal()
    assert d_prime(3 * genuine + 7, 3 * impostor + 7) == pytest.approx(d_prime(genuine, impostor))


def test_d_prime_of_integers_is_that_of_floats() -> None:
    assert d_prime(np.int8([100, 120]), np.int8([-100, 0])) == d_prime([100.0, 120.0], [-100.0, 0])


@pytest.mark.parametrize("scale", [1.0, 1e-6], ids=["wide", "narrow"])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_moments_of_parts_are_those_of_the_whole(dtype: type, scale: float) -> None:
    scores = (1 + scale * np.random.default_rng(0).normal(size=10_000)).astype(dtype)
    moments = Moments()
    for part in np.split(scores, [0, 1, 700, 8000]):
        moments.add(part.reshape(-1, 1))
    assert moments.mean == pytest.approx(scores.mean(dtype=np.float64), rel=1e-14)
    assert moments.variance == pytest.approx(scores.var(dtype=np.float64, ddof=1), rel=1e-11)


def test_d_prime_without_spread_is_refused() -> None:
    with pytest.raises(ScoreError, match="no unit"):
        d_prime([1, 1], [0, 0])


@pytest.mark.parametrize("genuine", [[1.0], [1.0, NAN]], ids=["one", "nan"])
def test_d_prime_of_broken_scores_is_refused(genuine: list[float]) -> None:
    with pytest.raises(ScoreError, match="genuine"):
        d_prime(genuine, [0.0, 1.0])


# Ranks.


def test_rank_counts_the_people_at_or_above_the_mate() -> None:
    matrix = np.array([[0.9, 0.1, 0.3], [0.5, 0.4, 0.1], [0.2, 0.2, 0.2]])
    scores = Scores(matrix, ["a", "b", "c"], ["a", "b", "c"])
    assert rank_probes(scores).tolist() == [1, 2, 3]


def test_people_count_once_however_many_images_they_have() -> None:
    matrix = np.array([[0.5, 0.9, 0.8, 0.7, 0.6]])
    scores = Scores(matrix, ["a"], ["a", "b", "b", "b", "a"])
    assert rank_probes(scores).tolist() == [2]


def test_failed_and_unknown_probes_have_no_rank() -> None:
    matrix = np.array([[NAN, NAN], [0.1, 0.2], [NAN, 0.4]])
    scores = Scores(matrix, ["a", "stranger", "a"], ["a", "b"])
    assert rank_probes(scores).tolist() == [0, -1, 0]


def test_a_missing_gallery_score_outranks_nobody() -> None:
    scores = Scores(np.array([[0.1, NAN]]), ["a"], ["a", "b"])
    assert rank_probes(scores).tolist() == [1]


@pytest.mark.parametrize("seed", range(3))
def test_ranks_agree_with_sorting_each_row(seed: int) -> None:
    matrix = np.random.default_rng(seed).normal(size=(20, 20))
    people = [f"p{k:02d}" for k in range(20)]
    ranks = rank_probes(Scores(matrix, people, people))
    order = np.argsort(-matrix, axis=1)
    assert ranks.tolist() == [row.tolist().index(k) + 1 for k, row in enumerate(order)]


def test_cmc_counts_a_failure_as_a_miss_and_leaves_strangers_out() -> None:
    matrix = np.array([[0.9, 0.1], [0.5, 0.4], [NAN, NAN], [0.3, 0.2]])
    curve = cmc(Scores(matrix, ["a", "b", "a", "stranger"], ["a", "b"]))
    assert curve.hit_rate.tolist() == [float(Fraction(1, 3)), float(Fraction(2, 3))]
    assert (curve.rank_1, curve.n_probes, curve.n_without_mate) == (1 / 3, 3, 1)


def test_cmc_reaches_one_at_the_last_rank_and_rises() -> None:
    matrix = np.random.default_rng(0).normal(size=(30, 30))
    people = [str(k) for k in range(30)]
    curve = cmc(Scores(matrix, people, people))
    assert curve.hit_rate[-1] == 1
    assert (np.diff(curve.hit_rate) >= 0).all()


def test_cmc_can_be_cut_short() -> None:
    matrix = np.random.default_rng(0).normal(size=(30, 30))
    people = [str(k) for k in range(30)]
    scores = Scores(matrix, people, people)
    assert cmc(scores, 5).hit_rate.tolist() == cmc(scores).hit_rate[:5].tolist()


def test_cmc_without_mates_is_refused() -> None:
    with pytest.raises(ScoreError, match="no probe has a mate"):
        cmc(Scores(np.zeros((1, 1)), ["a"], ["b"]))


def test_cmc_of_no_ranks_is_refused() -> None:
    with pytest.raises(ScoreError, match="max_rank 0"):
        cmc(Scores(np.zeros((1, 1)), ["a"], ["a"]), 0)
