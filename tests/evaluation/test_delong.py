"""Tests of lrsr/evaluation/delong.py."""

import json
import math
from dataclasses import asdict
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import auc as oracle
from sklearn.metrics import roc_auc_score

from lrsr.errors import ScoreError
from lrsr.evaluation.delong import (
    DifferenceSums,
    _auc_interval,
    compare_aucs,
    estimate_auc,
    estimate_auc_of,
    measure_auc,
    normal_quantile,
)
from lrsr.evaluation.placements import BLOCK, Placements, place
from lrsr.evaluation.scores import CosineScores, Scores

DATA = Path(__file__).parent.parent / "data"
PROC = json.loads((DATA / "delong_proc.json").read_text())["cases"]
HANLEY = json.loads((DATA / "hanley_mcneil_1982.json").read_text())

score_lists = st.lists(st.integers(-20, 20), min_size=2, max_size=25)


def overlapping(m: int = 40, n: int = 300, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return rng.normal(1, 1, m), rng.normal(0, 1, n)


# Values from elsewhere.


@pytest.mark.parametrize("case", PROC, ids=lambda case: case["name"])
def test_estimate_agrees_with_proc(case: dict[str, Any]) -> None:
    a = estimate_auc(case["genuine_a"], case["impostor_a"])
    assert (a.auc, a.std) == pytest.approx((case["auc_a"], case["std_a"]), rel=1e-12)
    assert (a.low, a.high) == pytest.approx((case["low_a"], case["high_a"]), rel=1e-12)


@pytest.mark.parametrize("case", PROC, ids=lambda case: case["name"])
def test_comparison_agrees_with_proc(case: dict[str, Any]) -> None:
    keys = ("genuine_a", "impostor_a", "genuine_b", "impostor_b")
    result = compare_aucs(*(case[key] for key in keys))
    assert (result.z, result.p) == pytest.approx((case["z"], case["p"]), rel=1e-11)
    wanted = (case["difference_low"], case["difference_high"])
    assert (result.low, result.high) == pytest.approx(wanted, rel=1e-11)


def test_estimate_agrees_with_the_ct_ratings_of_hanley_and_mcneil() -> None:
    genuine = np.repeat(HANLEY["ratings"], HANLEY["abnormal"])
    impostor = np.repeat(HANLEY["ratings"], HANLEY["normal"])
    estimate = estimate_auc(genuine, impostor)
    assert round(estimate.auc, 3) == HANLEY["auc"]
    assert estimate.std == pytest.approx(HANLEY["std_proc"], rel=1e-12)


@pytest.mark.parametrize("decimals", [0, 1, 12])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_auc_agrees_with_scikit_learn(dtype: type, decimals: int) -> None:
    genuine, impostor = (x.round(decimals).astype(dtype) for x in overlapping(200, 3000))
    labels = np.repeat([1, 0], [genuine.size, impostor.size])
    wanted = roc_auc_score(labels, np.concatenate((genuine, impostor)))
    assert measure_auc(genuine, impostor) == pytest.approx(wanted, rel=1e-12)


@given(genuine=score_lists, impostor=score_lists)
@settings(deadline=None, max_examples=40)
def test_estimate_is_the_rational_result_rounded(genuine: list[int], impostor: list[int]) -> None:
    estimate = estimate_auc(genuine, impostor)
    assert estimate.auc == float(oracle.auc(genuine, impostor))
    assert estimate.std == math.sqrt(oracle.variance(genuine, impostor))


@given(
    genuine=st.lists(st.tuples(st.integers(-9, 9), st.integers(-9, 9)), min_size=2, max_size=20),
    impostor=st.lists(st.tuples(st.integers(-9, 9), st.integers(-9, 9)), min_size=2, max_size=20),
)
@settings(deadline=None, max_examples=40)
def test_comparison_is_the_rational_result_rounded(
    genuine: list[tuple[int, int]], impostor: list[tuple[int, int]]
) -> None:
    (genuine_a, genuine_b), (impostor_a, impostor_b) = (
        zip(*genuine, strict=True),
        zip(*impostor, strict=True),
    )
    result = compare_aucs(genuine_a, impostor_a, genuine_b, impostor_b)
    wanted = oracle.auc(genuine_a, impostor_a) - oracle.auc(genuine_b, impostor_b)
    variance = oracle.variance_of_difference(genuine_a, impostor_a, genuine_b, impostor_b)
    assert result.difference == float(wanted)
    assert result.std == math.sqrt(variance)


def test_a_large_set_agrees_with_the_rational_result() -> None:
    genuine, impostor = (x.round(2) for x in overlapping(30, 700))
    estimate = estimate_auc(genuine, impostor)
    assert estimate.auc == pytest.approx(float(oracle.auc(genuine, impostor)), rel=1e-15)
    assert estimate.std**2 == pytest.approx(float(oracle.variance(genuine, impostor)), rel=1e-12)


def test_variance_keeps_its_digits_close_to_complete_separation() -> None:
    # One impostor of n beats one genuine score of m: placements by hand.
    m, n = 1000, 2_000_000
    estimate = estimate_auc(np.r_[0.5, np.full(m - 1, 2.0)], np.r_[1.0, np.zeros(n - 1)])
    assert estimate.auc == float(1 - Fraction(1, m * n))
    variance = Fraction(1, m * m * n * n) * 2
    assert estimate.std**2 == pytest.approx(float(variance), rel=1e-12)


def test_squares_beyond_int64_are_summed_exactly() -> None:
    # m = 4: two genuine scores beat all impostors, two beat none. S10 = 1/3, S01 = 0.
    n = 5_000_000_000
    placements = Placements([0.0, 0.0, 2.0, 2.0])
    placements.sizes[2] = n
    estimate = estimate_auc_of(placements)
    assert estimate.auc == 0.5
    assert estimate.std**2 == pytest.approx(1 / 12, rel=1e-15)


def test_squares_of_differences_beyond_int64_are_summed_exactly() -> None:
    far = 3_000_000_000
    sums = DifferenceSums()
    sums.add(np.array([[far, 0, 5]]), np.array([[0, far, 5]]))
    assert (sums.total, sums.squares) == (0, 2 * far**2)


def test_log10_p_speaks_where_p_underflows() -> None:
    # Abramowitz and Stegun 26.2.12: log10 of 2 Q(z) at z = 50 is -544.666...
    genuine, impostor = np.arange(3000.0), np.arange(3000.0)
    shuffled = np.random.default_rng(0).permutation(impostor)
    result = compare_aucs(genuine + 2900, impostor, genuine, shuffled)
    z = abs(result.z)
    assert z > 40
    series = 1 - z**-2 + 3 * z**-4 - 15 * z**-6
    log_p = math.log(2 * series / (z * math.sqrt(2 * math.pi))) - z * z / 2
    assert result.p == 0
    assert result.log10_p == pytest.approx(log_p / math.log(10), rel=1e-9)


def test_normal_quantile_is_the_tables_value() -> None:
    assert normal_quantile(0.99) == pytest.approx(2.5758293035489004, rel=1e-15)


# Laws.


def test_auc_counts_ties_as_half() -> None:
    assert measure_auc([1, 1], [1, 1, 1]) == 0.5


def test_auc_is_never_flipped() -> None:
    assert estimate_auc([0.0, 1.0], [2.0, 3.0]).auc == 0


def test_reversed_scores_have_the_complement() -> None:
    genuine, impostor = overlapping()
    there, back = estimate_auc(genuine, impostor), estimate_auc(-genuine, -impostor)
    assert back.auc == pytest.approx(1 - there.auc, rel=1e-15)
    assert back.std == there.std


def test_a_rising_map_changes_nothing() -> None:
    genuine, impostor = overlapping()
    assert estimate_auc(np.exp(genuine), np.exp(impostor)) == estimate_auc(genuine, impostor)


def test_order_of_the_scores_does_not_matter() -> None:
    genuine, impostor = overlapping()
    assert estimate_auc(genuine[::-1], impostor[::-1]) == estimate_auc(genuine, impostor)


def test_shape_of_the_scores_does_not_matter() -> None:
    genuine, impostor = overlapping()
    flat = estimate_auc(genuine, impostor)
    assert estimate_auc(genuine.reshape(8, 5), impostor.reshape(10, 30)) == flat


def test_scores_beyond_zero_to_one_are_taken_as_they_are() -> None:
    assert measure_auc([1000.0, 2000.0], [999.0, 1500.0]) == 0.75


def test_a_method_does_not_differ_from_itself() -> None:
    genuine, impostor = overlapping()
    result = compare_aucs(genuine, impostor, genuine, impostor)
    assert (result.difference, result.z, result.p, result.log10_p) == (0, 0, 1, 0)
    assert (result.low, result.high, result.degenerate) == (0, 0, True)


def test_a_method_does_not_differ_from_its_rising_map() -> None:
    genuine, impostor = overlapping()
    result = compare_aucs(genuine, impostor, np.arctan(genuine), np.arctan(impostor))
    assert (result.difference, result.z, result.p) == (0, 0, 1)


def test_exchanging_the_methods_changes_the_sign_only() -> None:
    (genuine_a, impostor_a), (genuine_b, impostor_b) = overlapping(seed=1), overlapping(seed=2)
    ab = compare_aucs(genuine_a, impostor_a, genuine_b, impostor_b)
    ba = compare_aucs(genuine_b, impostor_b, genuine_a, impostor_a)
    assert (ba.difference, ba.z, ba.p) == (-ab.difference, -ab.z, ab.p)
    assert (ba.low, ba.high) == (-ab.high, -ab.low)


def test_comparison_of_more_than_one_block_agrees_with_the_difference_of_estimates() -> None:
    genuine_a, impostor_a = overlapping(300, BLOCK + 1000, seed=3)
    genuine_b, impostor_b = overlapping(300, BLOCK + 1000, seed=4)
    a, b = estimate_auc(genuine_a, impostor_a), estimate_auc(genuine_b, impostor_b)
    result = compare_aucs(genuine_a, impostor_a, genuine_b, impostor_b)
    assert result.difference == pytest.approx(a.auc - b.auc, rel=1e-12)
    # Independent methods: no covariance but chance.
    assert result.std == pytest.approx(math.hypot(a.std, b.std), rel=0.15)


def test_blocks_of_different_dtypes_compare() -> None:
    genuine, impostor = overlapping()
    result = compare_aucs(
        genuine.astype(np.float32), impostor.astype(np.float32), genuine, impostor
    )
    assert result.p == 1


def test_interval_widens_with_the_level() -> None:
    genuine, impostor = overlapping()
    narrow, wide = estimate_auc(genuine, impostor, 0.8), estimate_auc(genuine, impostor, 0.99)
    assert wide.low < narrow.low < narrow.high < wide.high


def test_wald_interval_covers_the_truth_as_often_as_it_says() -> None:
    rng = np.random.default_rng(7)
    truth, trials = 0.7602499389065233, 600  # Phi(1 / sqrt 2): normals one standard deviation apart
    hits = 0
    for _ in range(trials):
        estimate = estimate_auc(rng.normal(1, 1, 60), rng.normal(0, 1, 300))
        hits += estimate.low <= truth <= estimate.high
    assert abs(hits - 0.94 * trials) < 4 * math.sqrt(trials * 0.95 * 0.05)


def test_p_is_even_where_the_methods_are_equal() -> None:
    rng = np.random.default_rng(8)
    trials, small = 500, 0
    for _ in range(trials):
        genuine, impostor = rng.normal(1, 1, 50), rng.normal(0, 1, 200)
        noise = [x + 0.5 * rng.normal(size=x.size) for x in (genuine, impostor, genuine, impostor)]
        small += compare_aucs(*noise).p < 0.1
    assert abs(small - 0.1 * trials) < 4 * math.sqrt(trials * 0.1 * 0.9)


@pytest.mark.parametrize("tile", [1, 100, 1 << 18])
def test_streamed_scores_have_the_area_of_stored_ones(
    tile: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("lrsr.evaluation.scores._TILE", tile)
    faces = np.random.default_rng(0).integers(-3, 4, (30, 8)).astype(np.float32)
    other = faces + np.random.default_rng(1).integers(-3, 4, (30, 8)).astype(np.float32)
    ids = [str(k) for k in range(30)]
    scores = Scores(np.float64(faces) @ np.float64(other).T, ids, ids)
    wanted = estimate_auc(scores.genuine(), scores.impostor())
    for source in (CosineScores(faces, other, ids, ids), scores):
        placements = Placements(source.genuine())
        for tile in source.tiles():
            placements.count(placements.classes(tile.impostors))
        assert estimate_auc_of(placements) == wanted


# Edges.


def test_complete_separation_is_flagged_and_has_no_logit_interval() -> None:
    estimate = estimate_auc([2, 3], [0, 1])
    assert (estimate.auc, estimate.std, estimate.low, estimate.high) == (1, 0, 1, 1)
    assert estimate.degenerate
    assert estimate.logit_low is estimate.logit_high is None


def test_constant_scores_are_flagged() -> None:
    estimate = estimate_auc([1, 1], [1, 1])
    assert (estimate.auc, estimate.std, estimate.degenerate) == (0.5, 0, True)
    assert estimate.logit_low is None


def test_a_wald_interval_beyond_one_is_cut_and_flagged() -> None:
    estimate = estimate_auc([0.4, 0.6, 0.9], [0.1, 0.2, 0.4, 0.5])
    assert estimate.high == 1
    assert estimate.wald_leaves_range
    assert estimate.logit_low is not None
    assert estimate.logit_high is not None
    assert 0 < estimate.logit_low < estimate.auc < estimate.logit_high < 1


def test_logit_interval_is_the_wald_interval_of_the_log_odds() -> None:
    estimate = _auc_interval(0.9, 0.03, 10, 20)
    half = 1.959963984540054 * 0.03 / (0.9 * 0.1)
    assert estimate.logit_low == pytest.approx(1 / (1 + math.exp(-math.log(9) + half)), rel=1e-14)
    assert estimate.logit_high == pytest.approx(1 / (1 + math.exp(-math.log(9) - half)), rel=1e-14)


def test_logit_interval_of_a_low_area_mirrors_that_of_a_high_one() -> None:
    low, high = _auc_interval(0.1, 0.03, 2, 2), _auc_interval(0.9, 0.03, 2, 2)
    assert low.logit_low is not None
    assert low.logit_low == pytest.approx(1 - (high.logit_high or 0), rel=1e-13)


def test_separated_against_reversed_is_infinitely_sure_and_flagged() -> None:
    result = compare_aucs([2, 3], [0, 1], [0, 1], [2, 3])
    assert (result.difference, result.z, result.p, result.degenerate) == (1, math.inf, 0, True)


def test_estimate_and_comparison_go_to_json() -> None:
    genuine, impostor = overlapping()
    estimate = estimate_auc(genuine, impostor)
    comparison = compare_aucs(genuine, impostor, impostor[:40], impostor)
    text = json.dumps([asdict(estimate), asdict(comparison)], allow_nan=False)
    assert json.loads(text)[0]["n_impostor"] == 300


def test_one_score_of_each_kind_has_an_area() -> None:
    assert measure_auc([1.0], [0.0]) == 1


# Errors.


@pytest.mark.parametrize(
    ("genuine", "impostor", "message"),
    [
        pytest.param([1], [0, 1], "1 genuine scores, wanted at least 2", id="one-genuine"),
        pytest.param([1, 2], [0], "1 impostor scores, wanted at least 2", id="one-impostor"),
        pytest.param([], [0, 1], "0 genuine", id="no-genuine"),
        pytest.param([1, math.nan], [0, 1], "genuine score 1 is nan", id="nan"),
        pytest.param([1, 2], [math.inf, 1], "impostor score 0 is inf", id="infinite"),
        pytest.param(["a", "b"], [0, 1], "dtype", id="text"),
    ],
)
def test_scores_without_a_variance_are_refused(
    genuine: list[float], impostor: list[float], message: str
) -> None:
    with pytest.raises(ScoreError, match=message):
        estimate_auc(genuine, impostor)


def test_measure_refuses_an_empty_side() -> None:
    with pytest.raises(ScoreError, match="0 impostor scores"):
        measure_auc([1.0], [])


def test_counts_of_one_genuine_score_are_refused() -> None:
    with pytest.raises(ScoreError, match="a variance needs two of each"):
        estimate_auc_of(place([1.0], [0.0, 2.0]))


@pytest.mark.parametrize("level", [0.0, 1.0, 95.0, math.nan])
def test_a_level_outside_zero_to_one_is_refused(level: float) -> None:
    with pytest.raises(ScoreError, match="confidence level"):
        estimate_auc([1, 2], [0, 1], level)
    with pytest.raises(ScoreError, match="confidence level"):
        compare_aucs([1, 2], [0, 1], [1, 2], [0, 1], level)
    with pytest.raises(ScoreError, match="confidence level"):
        _auc_interval(0.5, 0.1, 2, 2, level)


def test_unpaired_scores_are_refused() -> None:
    with pytest.raises(ScoreError, match="3 genuine scores of a against 2 of b"):
        compare_aucs([1, 2, 3], [0, 1], [1, 2], [0, 1])
    with pytest.raises(ScoreError, match="2 impostor scores of a against 3 of b"):
        compare_aucs([1, 2], [0, 1], [1, 2], [0, 1, 2])


def test_a_comparison_says_which_method_has_too_few_scores() -> None:
    with pytest.raises(ScoreError, match="1 b genuine scores"):
        compare_aucs([1, 2], [0, 1], [1], [0, 1])
