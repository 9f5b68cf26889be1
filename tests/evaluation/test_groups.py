"""Tests of lrsr/evaluation/groups.py."""

import numpy as np
import pytest

from lrsr.errors import ScoreError
from lrsr.evaluation.groups import rates_of_group
from lrsr.evaluation.scores import Scores

PEOPLE = [f"p{k:02d}" for k in range(40)]
MATRIX = np.random.default_rng(0).normal(size=(40, 40)) + 2 * np.eye(40)
SOURCE = Scores(MATRIX, PEOPLE, PEOPLE)


def test_rates_are_those_of_the_group_alone() -> None:
    found = rates_of_group(SOURCE, PEOPLE[:15], 1.0)
    part = MATRIX[:15, :15]
    assert found.fnmr == (np.diag(part) < 1.0).mean()
    assert found.fmr == (part[~np.eye(15, dtype=bool)] >= 1.0).mean()
    assert (found.people, found.n_genuine, found.n_impostor) == (15, 15, 210)


def test_interval_over_people_of_false_matches_is_wider_than_that_of_pairs() -> None:
    """Somebody who is like everybody makes many false matches at once."""
    matrix = MATRIX.copy()
    matrix[:3] += 1.5
    source = Scores(matrix, PEOPLE, PEOPLE)
    pairs = rates_of_group(source, PEOPLE, 2.0)
    people = rates_of_group(source, PEOPLE, 2.0, bootstrap=200)
    assert people.fmr_high - people.fmr_low > 1.5 * (pairs.fmr_high - pairs.fmr_low)
    assert people.fmr_low <= people.fmr <= people.fmr_high


def test_no_errors_have_an_interval_all_the_same() -> None:
    found = rates_of_group(SOURCE, PEOPLE, 99.0, bootstrap=50)
    assert (found.fmr, found.fmr_low) == (0.0, 0.0)
    assert found.fmr_high > 0


def test_a_group_without_impostors_is_refused() -> None:
    with pytest.raises(ScoreError, match="1 people without genuine or impostor scores"):
        rates_of_group(SOURCE, PEOPLE[:1], 1.0)
