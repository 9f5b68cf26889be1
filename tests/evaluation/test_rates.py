"""Tests of lrsr.evaluation.rates.py."""

import json
import math
from collections.abc import Collection
from dataclasses import asdict
from fractions import Fraction

import numpy as np
import pytest
from fakes.measures import d_prime, fnmr_at_fmr, trace_roc
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import ArrayLike
from oracles import auc as oracle
from scipy.special import ndtr, ndtri

from lrsr.errors import ScoreError
from lrsr.evaluation.rates import (
    Rates,
    equal_error_rate,
)
from lrsr.evaluation.scores import Scores

NAN = float("nan")
score_lists = st.lists(st.integers(-6, 6), min_size=1, max_size=20)


def binormal(m: int = 200, n: int = 20_000, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return rng.normal(2, 1, m), rng.normal(0, 1, n)


def eer(genuine: ArrayLike, impostor: ArrayLike) -> float:
    return equal_error_rate(trace_roc(genuine, impostor))


def gather(scores: Scores, targets: Collection[float] = (), rows: int = 2) -> Rates:
    rates = Rates(scores, targets)
    for tile in scores.tiles(rows):
        rates.add(tile)
    return rates


def rank_probes(scores: Scores) -> np.ndarray:
    return gather(scores).ranks()


def one_of_many(m: int, n: int, decimals: int, seed: int = 0) -> Scores:
    """Scores of m probes with their mates and n others: rows of different kinds of impostors."""
    rng = np.random.default_rng(seed)
    matrix = rng.normal(np.linspace(-2, 2, m)[:, None], 1, (m, n + 1)).round(decimals)
    return Scores(matrix + (np.arange(n + 1) == 0), ["a"] * m, ["a", *(f"b{k}" for k in range(n))])


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


@pytest.mark.parametrize(
    "targets", [[0.0], [0.001, 0.3], [0.1, 0.01], [0.999], [1.0, 0.5]], ids=str
)
@pytest.mark.parametrize("rows", [1, 7, 1000])
@pytest.mark.parametrize("decimals", [0, 2, 12])
def test_tiles_have_the_operating_points_of_the_whole(
    targets: list[float], rows: int, decimals: int
) -> None:
    scores = one_of_many(60, 90, decimals)
    wanted = [fnmr_at_fmr(scores.genuine(), scores.impostor(), target) for target in targets]
    assert gather(scores, targets, rows).fnmr() == tuple(wanted)


# Equal error rate.


def test_equal_error_rate_of_two_normals_is_the_tail_between_them() -> None:
    quantiles = (np.arange(2000) + 0.5) / 2000
    scores = ndtri(quantiles)
    assert eer(scores + 2, scores) == pytest.approx(ndtr(-1), abs=1e-3)


@given(genuine=score_lists, impostor=score_lists)
@settings(deadline=None, max_examples=40)
def test_equal_error_rate_is_that_of_the_fvc_rule(genuine: list[int], impostor: list[int]) -> None:
    points = [(f, 1 - t) for f, t in oracle.operating_points(genuine, impostor)]
    before = [point for point in points if point[0] <= point[1]][-1]
    after = next(point for point in points if point[0] >= point[1])
    low, high = sorted(before if sum(before) <= sum(after) else after)
    if after[0] == after[1]:
        low, high = after
    if before[1] == after[1]:  # the FMR passes, and its steps of tied scores are not held
        assert eer(genuine, impostor) == float(after[1])
    else:
        assert eer(genuine, impostor) == pytest.approx(float(low + high) / 2, abs=1e-12)


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
@pytest.mark.parametrize("rows", [1, 7, 1000])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_tiles_have_the_d_prime_of_the_whole(dtype: type, rows: int, scale: float) -> None:
    scores = one_of_many(60, 90, 12)
    scores = Scores((1 + scale * scores.matrix).astype(dtype), scores.probe_ids, scores.gallery_ids)
    moments = [
        (x.mean(dtype=np.float64), x.var(dtype=np.float64, ddof=1))
        for x in (scores.genuine(), scores.impostor())
    ]
    wanted = (moments[0][0] - moments[1][0]) / math.sqrt((moments[0][1] + moments[1][1]) / 2)
    assert gather(scores, (), rows).d_prime() == pytest.approx(wanted, rel=1e-9)
    assert d_prime(scores.genuine(), scores.impostor()) == pytest.approx(wanted, rel=1e-9)


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
    curve = gather(Scores(matrix, ["a", "b", "a", "stranger"], ["a", "b"])).cmc()
    assert curve.hit_rate.tolist() == [float(Fraction(1, 3)), float(Fraction(2, 3))]
    assert (curve.rank_1, curve.n_probes, curve.n_without_mate) == (1 / 3, 3, 1)


def test_cmc_reaches_one_at_the_last_rank_and_rises() -> None:
    matrix = np.random.default_rng(0).normal(size=(30, 30))
    people = [str(k) for k in range(30)]
    curve = gather(Scores(matrix, people, people)).cmc()
    assert curve.hit_rate[-1] == 1
    assert (np.diff(curve.hit_rate) >= 0).all()


def test_cmc_without_mates_is_refused() -> None:
    with pytest.raises(ScoreError, match="no probe has a mate"):
        gather(Scores(np.zeros((1, 1)), ["a"], ["b"])).cmc()


def test_a_probe_without_any_score_is_a_failure_to_acquire() -> None:
    matrix = np.array([[0.9, NAN], [NAN, NAN], [0.1, 0.2], [NAN, NAN], [NAN, 0.3]])
    rates = gather(Scores(matrix, list("abcde"), list("ab")))
    assert rates.fta == 0.4
