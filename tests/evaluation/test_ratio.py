"""Tests of lrsr/evaluation/ratio.py: normal scores have a ratio that is known in closed form."""

import math

import numpy as np
import pytest

from lrsr.errors import ScoreError
from lrsr.evaluation.pairs import PairScores
from lrsr.evaluation.ratio import ratio_of
from lrsr.evaluation.scores import Scores


def normal(people: int, signal: float = 2.0, seed: int = 0) -> Scores:
    names = [f"p{k:03d}" for k in range(people)]
    noise = np.random.default_rng(seed).normal(size=(people, people))
    return Scores(noise + signal * np.eye(people), names, names)


@pytest.mark.parametrize("score", [0.0, 1.0, 2.0])
def test_the_ratio_is_that_of_two_normal_densities(score: float) -> None:
    """N(2, 1) against N(0, 1): ln LR = 2 s - 2."""
    found = ratio_of(score, normal(1000))
    assert found.llr == pytest.approx((2 * score - 2) / math.log(10), abs=0.1)
    assert (found.n_people, found.n_genuine, found.n_impostor) == (1000, 1000, 999_000)
    assert not found.cut
    assert not found.beyond


def test_the_interval_holds_the_truth_and_narrows_with_people() -> None:
    few, many = (ratio_of(1.5, normal(people), bootstrap=60) for people in (20, 120))
    for found in (few, many):
        assert found.low is not None
        assert found.high is not None
        assert found.low < 1 / math.log(10) < found.high
    assert (many.high or 0) - (many.low or 0) < (few.high or 0) - (few.low or 0)


def test_equal_seeds_give_equal_intervals() -> None:
    one, again, other = (ratio_of(1, normal(20), bootstrap=20, seed=k) for k in (1, 1, 2))
    assert one == again
    assert one != other


def test_what_the_pairs_cannot_support_is_cut_and_told() -> None:
    found = ratio_of(50.0, normal(20))
    assert found.llr == found.bound_high < 3
    assert found.cut
    assert found.beyond


def test_unnamed_pairs_have_no_interval_over_people() -> None:
    scores = np.append(np.random.default_rng(0).normal(2, 1, 20), np.zeros(20) + 0.1)
    left = [str(k) for k in range(40)]
    right = [name if k < 20 else f"x{name}" for k, name in enumerate(left)]
    found = ratio_of(1.0, PairScores(scores, left, right, people_known=False), bootstrap=20)
    assert (found.low, found.high) == (None, None)


@pytest.mark.parametrize(
    ("score", "people", "calibration", "says"),
    [
        (math.nan, 20, "logistic", "a score of nan has no likelihood ratio"),
        (1.0, 9, "logistic", "9 people with a genuine score"),
        (1.0, 20, "guess", "calibration guess: wanted one of"),
    ],
)
def test_what_cannot_be_told_is_refused(
    score: float, people: int, calibration: str, says: str
) -> None:
    with pytest.raises(ScoreError, match=says):
        ratio_of(score, normal(people), calibration)
