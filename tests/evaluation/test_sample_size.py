"""Tests of lrsr/evaluation/sample_size.py."""

import pytest

from lrsr.errors import ScoreError
from lrsr.evaluation.roc import wilson_interval
from lrsr.evaluation.sample_size import (
    pairs_for_precision,
    pairs_without_error,
    rate_without_error,
)


def test_rule_of_three() -> None:
    assert pairs_without_error(0.001) == 2995  # Hanley and Lippman-Hand: about 3 / 0.001
    assert rate_without_error(3000) == pytest.approx(1e-3, rel=0.01)


@pytest.mark.parametrize("rate", [0.0, 0.02, 0.5])
def test_so_many_pairs_are_enough_and_one_less_is_not(rate: float) -> None:
    number = pairs_for_precision(rate, 0.03)
    width = [
        float(high - low)
        for low, high in (wilson_interval(rate * n, n) for n in (number, number - 1))
    ]
    assert width[0] <= 0.06 < width[1]


def test_no_error_in_so_many_pairs_hides_no_more_than_asked() -> None:
    number = pairs_without_error(0.02, level=0.9)
    assert rate_without_error(number, level=0.9) <= 0.02 < rate_without_error(number - 1, level=0.9)


@pytest.mark.parametrize(("rate", "half_width"), [(1.5, 0.1), (0.1, 0.0), (0.1, 0.7)])
def test_numbers_out_of_range_are_refused(rate: float, half_width: float) -> None:
    with pytest.raises(ScoreError, match="wanted 0 to 1"):
        pairs_for_precision(rate, half_width)


def test_rates_and_numbers_that_cannot_be_are_refused() -> None:
    with pytest.raises(ScoreError, match="rate 0"):
        pairs_without_error(0)
    with pytest.raises(ScoreError, match="0 pairs"):
        rate_without_error(0)
