"""Tests of lrsr/evaluation/transfer.py."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike

from lrsr.errors import ScoreError
from lrsr.evaluation.pairs import PairScores
from lrsr.evaluation.scores import Scores
from lrsr.evaluation.transfer import carry_threshold

CASES = json.loads((Path(__file__).parents[1] / "data" / "hter.json").read_text())["cases"]


def pairs(genuine: ArrayLike, impostor: ArrayLike) -> PairScores:
    values = np.concatenate([genuine, impostor])
    mates = [f"p{k}" for k in range(np.size(genuine))]
    others = [f"q{k}" for k in range(np.size(impostor))]
    return PairScores(values, [*mates, *others], [*mates, *(f"r{k}" for k in range(len(others)))])


@pytest.mark.parametrize("case", CASES, ids=[case["name"] for case in CASES])
@pytest.mark.parametrize("target", [None, 0.1], ids=["eer", "fmr"])
def test_error_rates_at_anothers_threshold_are_those_of_bob(
    case: dict[str, Any], target: float | None
) -> None:
    found = carry_threshold(pairs(*case["development"]), pairs(*case["evaluation"]), target)
    told = case["bob"]["eer" if target is None else str(target)]
    for name in ("far", "frr", "hter"):
        assert getattr(found, name) == pytest.approx(told[name], abs=1e-12)
    if target is None:
        assert found.threshold == told["threshold"]


def test_failures_to_acquire_are_refused_by_everybody() -> None:
    people = ["ann", "bob", "cy", "di"]
    matrix = np.full((4, 4), 0.1) + 0.8 * np.eye(4)
    clear = Scores(matrix, people, people)
    blind = Scores(np.where(np.arange(4)[:, None] == 3, np.nan, matrix), people, people)
    found = carry_threshold(clear, blind)
    assert (found.fmr, found.fnmr, found.fta) == (0, 0, 0.25)
    assert (found.far, found.frr, found.hter) == (0, 0.25, 0.125)
    assert (found.n_genuine, found.n_impostor) == (3, 9)


def test_a_rising_map_of_all_scores_changes_no_rate() -> None:
    rng = np.random.default_rng(0)
    dev, ev = (pairs(rng.normal(1, 1, 30), rng.normal(0, 1, 90)) for _ in range(2))
    far_dev, far_ev = (PairScores(3 * s.values, s.probe_ids, s.gallery_ids) for s in (dev, ev))
    wide = carry_threshold(far_dev, far_ev)
    plain = carry_threshold(dev, ev)
    assert (wide.far, wide.frr) == (plain.far, plain.frr)


def test_a_threshold_carried_to_the_same_people_has_their_rates() -> None:
    same = pairs([0.9, 0.4, 0.7], [0.1, 0.5, 0.3])
    found = carry_threshold(same, same, 0.34)
    assert (found.fmr, found.fnmr) == (found.development_fmr, found.development_fnmr)
    assert found.fmr == pytest.approx(1 / 3)


def test_a_target_of_one_accepts_all_and_goes_to_json() -> None:
    found = carry_threshold(pairs([0.5, 0.6], [0.1, 0.2]), pairs([-9.0, 0.6], [-9.0, 0.2]), 1)
    assert (found.threshold, found.far, found.frr) == (None, 1, 0)
    assert json.loads(json.dumps(asdict(found), allow_nan=False))["hter"] == 0.5


def test_of_two_equally_good_places_the_higher_is_taken() -> None:
    same = pairs([2.0, 4.0], [1.0, 3.0])
    assert carry_threshold(same, same).threshold == 2.5  # the one place with equal rates
    tied = pairs([2.0, 4.0], [1.0, 2.0])  # at 1.5 FMR 1/2, FNMR 0; at 3 the other way round
    assert carry_threshold(tied, tied).threshold == 3.0


@pytest.mark.parametrize("whose", ["development", "evaluation"])
def test_people_without_a_genuine_score_are_refused(whose: str) -> None:
    full, empty = pairs([0.5], [0.1]), pairs([np.nan], [0.1])
    both = (empty, full) if whose == "development" else (full, empty)
    with pytest.raises(ScoreError, match=f"0 genuine and 1 impostor scores of the {whose}"):
        carry_threshold(*both)


def test_a_target_outside_zero_to_one_is_refused() -> None:
    with pytest.raises(ScoreError, match="target FMR"):
        carry_threshold(pairs([0.5], [0.1]), pairs([0.5], [0.1]), 1.5)
