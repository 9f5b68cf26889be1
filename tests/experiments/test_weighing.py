"""Tests of lrsr/experiments/weighing.py: normal scores, whose best calibration is known."""

import math

import numpy as np
import pytest

from lrsr.evaluation.likelihood import split_people, weigh_evidence
from lrsr.evaluation.scores import Scores
from lrsr.experiments.asked import Asked
from lrsr.experiments.weighing import CASE, REAL, weigh_case

ASKED = Asked(0.95, 0, 3, "logistic")


def normal(people: int, signal: float, seed: int, prefix: str = "p") -> Scores:
    names = [f"{prefix}{k:03d}" for k in range(people)]
    noise = np.random.default_rng(seed).normal(size=(people, people))
    return Scores(noise + signal * np.eye(people), names, names)


def test_the_case_alone_is_weighed_as_its_scores_are() -> None:
    case = normal(60, 1.5, 0)
    found = weigh_case(case, {}, None, None, ASKED)
    assert found.evidence[CASE][CASE].cllr == weigh_evidence(case, "logistic", seed=3).cllr
    assert not found.ratios
    assert not found.missing


def test_a_calibration_of_easier_pictures_costs_more_and_misleads_more() -> None:
    case, easy = normal(100, 1.0, 0), normal(100, 5.0, 1)
    some = weigh_case(case, {"good": easy}, None, None, ASKED).evidence[CASE]
    assert some["good"].cllr.value > 1.5 * some[CASE].cllr.value
    assert some["good"].misleading_genuine > 2 * some[CASE].misleading_genuine
    assert some["good"].cllr_min == some[CASE].cllr_min  # of the scores, whoever calibrates


def test_nobody_who_is_judged_was_calibrated_on_in_another_picture() -> None:
    case, generic = normal(60, 1.5, 0), normal(60, 1.5, 1)
    some = weigh_case(case, {"good": generic}, None, None, ASKED).evidence[CASE]
    assert (some["good"].n_development, some["good"].n_test) == (30, 30)
    learn, _ = split_people(case, 3)
    part = generic.restricted(learn)
    assert weigh_case(case, {"good": part}, None, None, ASKED).evidence[CASE]["good"].cllr == (
        some["good"].cllr
    )


def test_real_people_judge_every_calibration() -> None:
    case, real = normal(200, 1.5, 0), normal(60, 1.5, 2, "real")
    found = weigh_case(case, {}, real, None, ASKED)
    assert {who: [*some] for who, some in found.evidence.items()} == {
        CASE: [CASE, REAL],
        REAL: [CASE, REAL],
    }
    costs = [one.cllr.value for one in found.evidence[REAL].values()]
    assert costs[0] == pytest.approx(costs[1], abs=0.1)  # the same distributions
    assert found.evidence[REAL][CASE].n_test == 30


def test_the_score_has_the_ratio_of_the_densities() -> None:
    case = normal(400, 2.0, 0)
    ratio = weigh_case(case, {}, None, 1.5, ASKED).ratios[CASE]
    assert ratio.llr == pytest.approx((2 * 1.5 - 2) / math.log(10), abs=0.15)


def test_what_has_too_few_people_is_told_and_the_rest_is_there() -> None:
    found = weigh_case(normal(40, 1.5, 0), {}, normal(6, 1.5, 1, "r"), 1.0, ASKED)
    assert [*found.evidence[CASE]] == [CASE]
    assert [*found.ratios] == [CASE]
    assert "Calibrated on real people, judged on this case: 3 people" in found.missing[0]
    assert "The score calibrated on real people: 3 people" in found.missing[-1]
