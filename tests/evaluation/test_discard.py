"""Tests of lrsr/evaluation/discard.py."""

import numpy as np
import pytest

from lrsr.errors import ScoreError
from lrsr.evaluation.discard import error_against_discard


def test_fnmr_is_that_of_what_is_left() -> None:
    rng = np.random.default_rng(0)
    scores, quality = rng.normal(size=100), rng.normal(size=100)
    found = error_against_discard(scores, quality, 0.0)
    order = np.argsort(quality)
    for share, fnmr in zip(found.discarded, found.fnmr, strict=True):
        assert fnmr == (scores[order[round(100 * share) :]] < 0).mean()
    assert found.discarded[-1] == 0.5


def test_a_quality_that_knows_all_takes_the_errors_first() -> None:
    scores = np.linspace(0, 1, 50)
    found = error_against_discard(scores, scores, 0.2)
    assert found.fnmr[found.discarded >= 0.2].max() == 0.0


def test_equal_qualities_go_at_once() -> None:
    found = error_against_discard([0.0, 1.0, 1.0, 0.0], [1, 1, 2, 2], 0.5)
    assert found.discarded.tolist() == [0.0, 0.5]


def test_failures_to_acquire_are_errors_and_go_first() -> None:
    found = error_against_discard([np.nan, 1.0, 1.0, 1.0], [np.nan, 1, 2, 3], 0.5)
    assert found.fnmr.tolist() == [0.25, 0.0, 0.0]


def test_lengths_that_differ_are_refused() -> None:
    with pytest.raises(ScoreError, match="wanted one of each a pair"):
        error_against_discard([0.0, 1.0], [1.0], 0.5)
