"""Tests of lrsr/evaluation/calibrators.py; those against lir are in test_published_figures.py."""

import numpy as np
import pytest
from sklearn.isotonic import IsotonicRegression

from lrsr.errors import ScoreError
from lrsr.evaluation.calibrators import CALIBRATORS, elub, fit_kde, fit_logistic, fit_pav, pool


def drawn(m: int = 60, n: int = 400, shift: float = 2.0) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(0)
    return rng.normal(shift, 1, m), rng.normal(0, 1, n)


def test_logistic_finds_the_ratio_of_two_normals() -> None:
    """Of N(2, 1) and N(0, 1) the natural log LR is 2 x - 2."""
    rng = np.random.default_rng(1)
    calibrate = fit_logistic(rng.normal(2, 1, 20_000), rng.normal(0, 1, 20_000))
    at = np.array([-1.0, 1.0, 3.0])
    assert calibrate(at) * np.log(10) == pytest.approx(2 * at - 2, abs=0.15)


@pytest.mark.parametrize("name", ["logistic", "kde"])
def test_ratios_do_not_depend_on_the_unit(name: str) -> None:
    own, other = drawn()
    one = CALIBRATORS[name](own, other)([0.5, 1.5])
    same = CALIBRATORS[name](3 * own + 7, 3 * other + 7)([8.5, 11.5])
    assert same == pytest.approx(one, abs=1e-6)


@pytest.mark.parametrize("name", ["logistic", "pav"])
def test_ratios_do_not_depend_on_how_often_every_impostor_counts(name: str) -> None:
    own, other = drawn()
    if name == "pav":  # one misleading pair weighs less among more
        calibrate = [fit_pav(own, side, misleading=0) for side in (other, np.repeat(other, 3))]
    else:
        calibrate = [CALIBRATORS[name](own, side) for side in (other, np.repeat(other, 3))]
    at = np.quantile(np.append(own, other), [0.3, 0.6, 0.9])
    assert calibrate[1](at) == pytest.approx(calibrate[0](at), abs=1e-6)


@pytest.mark.parametrize("name", ["logistic", "pav"])
def test_ratios_rise_with_the_score(name: str) -> None:
    found = CALIBRATORS[name](*drawn())(np.linspace(-4, 6, 50))
    assert (np.diff(found) >= -1e-12).all()


@pytest.mark.parametrize("name", list(CALIBRATORS))
def test_separated_scores_have_finite_ratios(name: str) -> None:
    found = CALIBRATORS[name]([3.0, 4.0, 5.0], [0.0, 1.0, 2.0])([-9.0, 0.0, 2.5, 5.0, 9.0])
    assert np.isfinite(found).all()


def test_pav_without_misleading_pairs_is_infinite_at_the_ends() -> None:
    found = fit_pav([2.0, 3.0], [0.0, 1.0], misleading=0)([0.0, 3.0])
    assert found.tolist() == [-np.inf, np.inf]


def test_pooling_agrees_with_scikit_learn() -> None:
    rng = np.random.default_rng(2)
    own, other = rng.integers(0, 5, 30).astype(float), rng.integers(1, 5, 30).astype(float)
    weight = own + other
    wanted = IsotonicRegression().fit(np.arange(30), own / weight, weight).predict(np.arange(30))
    assert pool(own, other) == pytest.approx(wanted, abs=1e-12)


def test_bounds_stay_within_what_the_numbers_of_pairs_can_support() -> None:
    bounds = elub(np.full(50, 8.0), np.full(200, -8.0))
    assert -np.log10(51) - 0.02 <= bounds.low < 0 < bounds.high <= np.log10(201) + 0.02


def test_ratios_that_mislead_have_no_room() -> None:
    bounds = elub([-2.0, -1.0], [1.0, 2.0])
    assert (bounds.low, bounds.high) == (0.0, 0.0)


def test_scores_that_are_all_alike_are_refused() -> None:
    with pytest.raises(ScoreError, match="all scores are alike"):
        fit_logistic([1.0, 1.0], [1.0])
    with pytest.raises(ScoreError, match="all genuine scores are alike"):
        fit_kde([1.0, 1.0], [1.0, 2.0])


@pytest.mark.parametrize("name", list(CALIBRATORS))
def test_an_empty_side_or_a_nan_is_refused(name: str) -> None:
    with pytest.raises(ScoreError, match="0 impostor scores"):
        CALIBRATORS[name]([1.0, 2.0], [])
    with pytest.raises(ScoreError, match="genuine score 1 is nan"):
        CALIBRATORS[name]([1.0, np.nan], [0.0, 1.0])
