"""Tests of lrsr/evaluation/likelihood.py; those against lir are in test_published_figures.py."""

import numpy as np
import pytest

from lrsr.errors import ScoreError
from lrsr.evaluation.calibrators import CALIBRATORS
from lrsr.evaluation.likelihood import (
    ECE_ODDS,
    TIPPETT_LLRS,
    cllr,
    cllr_min,
    cross_entropy,
    split_people,
    weigh_evidence,
)
from lrsr.evaluation.pairs import PairScores
from lrsr.evaluation.scores import Scores


def scored(people: int = 60, signal: float = 2.0, seed: int = 0) -> Scores:
    names = [f"p{k:03d}" for k in range(people)]
    noise = np.random.default_rng(seed).normal(size=(people, people))
    return Scores(noise + signal * np.eye(people), names, names)


def test_no_evidence_costs_one_bit() -> None:
    assert cllr([0.0, 0.0], [0.0]) == 1.0


def test_perfect_ratios_cost_nothing_and_misleading_ones_everything() -> None:
    assert cllr([np.inf], [-np.inf]) == 0.0
    assert cllr([-np.inf], [-np.inf]) == np.inf


def test_cost_of_the_best_calibration_is_that_of_any_rising_map() -> None:
    own, other = np.random.default_rng(0).normal([[1.0]] * 2, 1, (2, 50)) - [[0.0], [1.0]]
    assert cllr_min(np.exp(own), np.exp(other)) == pytest.approx(cllr_min(own, other), abs=1e-12)
    assert cllr_min(own, other) <= cllr(own, other)


def test_cross_entropy_at_even_odds_is_cllr() -> None:
    own, other = [0.5, 1.2, -0.3], [-0.8, 0.4]
    assert cross_entropy(own, other, [0.0])[0] == pytest.approx(cllr(own, other), abs=1e-12)


def test_nan_and_nothing_are_refused() -> None:
    with pytest.raises(ScoreError, match="impostor likelihood ratios"):
        cllr([1.0], [np.nan])
    with pytest.raises(ScoreError, match="0 genuine"):
        cross_entropy([], [1.0], [0.0])
    with pytest.raises(ScoreError, match="0 genuine scores"):
        cllr_min([], [1.0])


def test_nobody_is_in_both_halves_and_the_seed_decides() -> None:
    source = scored()
    one, other = split_people(source, 3)
    assert not {*one} & {*other}
    assert len(one) == len(other) == 30
    assert split_people(source, 3) == (one, other)
    assert split_people(source, 4) != (one, other)


@pytest.mark.parametrize("calibration", list(CALIBRATORS))
def test_evidence_of_good_scores_is_better_than_none(calibration: str) -> None:
    found = weigh_evidence(scored(100, 3.0), calibration, bootstrap=50)
    assert found.cllr_min.value <= found.cllr.value < 0.6
    assert found.cllr_cal.value == pytest.approx(found.cllr.value - found.cllr_min.value)
    for cost in (found.cllr, found.cllr_min, found.cllr_cal):
        assert cost.low is not None
        assert cost.high is not None
        assert cost.low <= cost.value <= cost.high
    assert (found.n_development, found.n_test, found.n_genuine) == (50, 50, 50)
    assert found.n_impostor == 50 * 49


def test_evidence_is_what_calibrating_by_hand_gives() -> None:
    source, halves = scored(), split_people(scored(), 5)
    development, test = (source.restricted(people) for people in halves)
    calibrate = CALIBRATORS["logistic"](development.genuine(), development.impostor())
    found = weigh_evidence(source, seed=5)
    own, other = (
        np.clip(calibrate(scores), found.bound_low, found.bound_high)
        for scores in (test.genuine(), test.impostor())
    )
    assert found.cllr.value == pytest.approx(cllr(own, other), abs=1e-6)
    assert found.cllr_min.value == pytest.approx(
        cllr_min(test.genuine(), test.impostor()), abs=1e-9
    )
    assert found.ece.values == pytest.approx(cross_entropy(own, other, ECE_ODDS), abs=1e-6)
    reached = [(own >= x).mean() for x in TIPPETT_LLRS]
    assert found.tippett_genuine.values == pytest.approx(reached, abs=1e-6)
    assert found.misleading_genuine == (own < 0).mean()
    assert found.cllr.low is None


def test_evidence_of_noise_is_worth_nothing() -> None:
    found = weigh_evidence(scored(80, 0.0), bootstrap=50)
    assert found.cllr.value == pytest.approx(1.0, abs=0.05)


def test_interval_is_as_wide_as_samples_of_people_differ() -> None:
    samples = [weigh_evidence(scored(80, 2.0, seed), seed=seed).cllr.value for seed in range(40)]
    found = weigh_evidence(scored(80, 2.0), bootstrap=200, level=0.68)
    assert found.cllr.high is not None
    assert found.cllr.low is not None
    half = (found.cllr.high - found.cllr.low) / 2
    assert half == pytest.approx(np.std(samples), rel=0.5)


def test_failures_to_acquire_are_left_out() -> None:
    matrix = scored().matrix.copy()
    matrix[:10] = np.nan
    source = Scores(matrix, scored().probe_ids, scored().gallery_ids)
    assert weigh_evidence(source).n_genuine <= 30


def test_unnamed_pairs_are_split_pair_by_pair_and_have_no_interval() -> None:
    rng = np.random.default_rng(0)
    values = np.append(rng.normal(2, 1, 40), rng.normal(0, 1, 200))
    left = [f"pair {k}" for k in range(240)]
    right = [*left[:40], *(f"other {k}" for k in range(200))]
    found = weigh_evidence(PairScores(values, left, right, people_known=False), bootstrap=20)
    assert found.cllr.low is None
    assert found.n_genuine + found.n_impostor == 120


def test_too_few_people_are_refused() -> None:
    with pytest.raises(ScoreError, match="5 people with a genuine score in one half"):
        weigh_evidence(scored(10))


def test_an_unknown_calibration_is_refused() -> None:
    with pytest.raises(ScoreError, match="wanted one of logistic, pav, kde"):
        weigh_evidence(scored(), "platt")
