"""Tests of lrsr/evaluation/multiplicity.py."""

import pytest

from lrsr.errors import ScoreError
from lrsr.evaluation.multiplicity import holm_adjusted


def test_holm_agrees_with_r() -> None:
    # R 4.2.2: p.adjust(c(0.01, 0.02, 0.03, 0.04, 0.005, 0.5), "holm")
    wanted = [0.05, 0.08, 0.09, 0.09, 0.03, 0.5]
    assert holm_adjusted([0.01, 0.02, 0.03, 0.04, 0.005, 0.5]) == pytest.approx(wanted)


def test_one_test_needs_no_adjustment() -> None:
    assert holm_adjusted([0.03]) == [0.03]


def test_no_test_gives_nothing() -> None:
    assert holm_adjusted([]) == []


def test_no_adjusted_value_exceeds_one() -> None:
    assert holm_adjusted([0.4, 0.9, 1.0]) == [1, 1, 1]


def test_ties_stay_ties() -> None:
    assert holm_adjusted([0.02, 0.02]) == [0.04, 0.04]


@pytest.mark.parametrize("p", [-0.1, 1.1, float("nan")])
def test_what_is_no_probability_is_refused(p: float) -> None:
    with pytest.raises(ScoreError, match="p value 1 is"):
        holm_adjusted([0.5, p])
