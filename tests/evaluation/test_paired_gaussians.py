"""Tests of lrsr/evaluation/paired_gaussians.py."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from lrsr.errors import ScoreError
from lrsr.evaluation.paired_gaussians import paired_log_ratios

RHO = np.array([0.9, 0.5, 0.0])


def rows(count: int, seed: int) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(count, len(RHO)))


def test_a_ratio_is_that_of_the_two_densities() -> None:
    probes, gallery = rows(4, 0), rows(5, 1)
    one, several = np.eye(6), multivariate_normal(np.zeros(6))
    one[:3, 3:] = one[3:, :3] = np.diag(RHO)
    together = multivariate_normal(np.zeros(6), one)
    wanted = [
        [together.logpdf([*x, *y]) - several.logpdf([*x, *y]) for y in gallery] for x in probes
    ]
    found = paired_log_ratios(probes, gallery, RHO, "abcd", "abcde").rows(0, 4)
    np.testing.assert_allclose(found, wanted, rtol=1e-10)


def test_what_does_not_go_together_says_nothing() -> None:
    scores = paired_log_ratios(rows(3, 0), rows(3, 1), np.zeros(3), "abc", "abc")
    np.testing.assert_allclose(scores.rows(0, 3), 0, atol=1e-15)


def test_evidence_is_for_the_truth_on_average() -> None:
    x = rows(20_000, 0)
    y = RHO * x + np.sqrt(1 - RHO**2) * rows(20_000, 1)
    people = [str(number) for number in range(len(x))]
    same = paired_log_ratios(x, y, RHO, people, people).mated_scores()
    other = paired_log_ratios(x, np.roll(y, 1, axis=0), RHO, people, people).mated_scores()
    # The mean of ln p/q under p is the mutual information, -Σ ln(1 - ρ²) / 2; under q, E[p/q] = 1.
    assert same.mean() == pytest.approx(-np.log(1 - RHO**2).sum() / 2, abs=0.02)
    assert np.exp(other).mean() == pytest.approx(1, abs=0.05)


def test_no_face_has_no_score() -> None:
    probes, gallery = rows(2, 0), rows(2, 1)
    probes[1] = gallery[0] = np.nan
    scores = paired_log_ratios(probes, gallery, RHO, "ab", "ab")
    assert np.isnan(scores.rows(0, 2)).tolist() == [[True, False], [True, True]]
    assert not scores.complete


@pytest.mark.parametrize(
    ("columns", "rho", "message"),
    [
        pytest.param(3, [0.5, 1.0, 0.5], "wanted 0 <= ρ < 1", id="certain"),
        pytest.param(3, [0.5, -0.1, 0.5], "wanted 0 <= ρ < 1", id="negative"),
        pytest.param(3, [0.5, np.nan, 0.5], "wanted 0 <= ρ < 1", id="nan"),
        pytest.param(2, [0.5, 0.5, 0.5], "wanted as many", id="columns"),
    ],
)
def test_what_cannot_be_compared_is_refused(columns: int, rho: list[float], message: str) -> None:
    with pytest.raises(ScoreError, match=message):
        paired_log_ratios(rows(2, 0)[:, :columns], rows(2, 1), np.array(rho), "ab", "ab")
