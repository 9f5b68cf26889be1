"""Tests of lrsr/experiments/report/ratios.py."""

from typing import Any

import pytest

from lrsr.experiments.report.ratios import basis_words, ratio_words

RATIO: dict[str, Any] = {
    "llr": 1.08,
    "low": 0.5,
    "high": 2.3,
    "cut": False,
    "beyond": False,
    "n_people": 1200,
    "n_genuine": 1200,
    "n_impostor": 1438800,
}


def test_a_ratio_comes_with_its_interval() -> None:
    assert ratio_words(RATIO, 0.9) == "12 [3.2, 200] (log10 +1.08 [+0.50, +2.30], 90 % over people)"


def test_without_people_there_is_no_interval() -> None:
    assert ratio_words({**RATIO, "low": None, "high": None}, 0.9) == "12 (log10 +1.08)"


@pytest.mark.parametrize(
    ("name", "says"), [("cut", "cut to what so many pairs"), ("beyond", "beyond all that")]
)
def test_limits_are_told(name: str, says: str) -> None:
    assert says in ratio_words({**RATIO, name: True}, 0.95)
    assert says not in ratio_words(RATIO, 0.95)


def test_the_basis_is_counted() -> None:
    said = "1,200 people, 1,200 genuine and 1,438,800 impostor scores"
    assert basis_words(RATIO) == said
