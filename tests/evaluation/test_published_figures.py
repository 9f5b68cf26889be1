"""Figures that other tools print, of scores that anybody can have."""

import json
from pathlib import Path
from typing import Any

import pytest
from fakes.measures import d_prime, fnmr_at_fmr, trace_roc

from lrsr.evaluation.calibrators import CALIBRATORS, elub
from lrsr.evaluation.delong import compare_aucs, estimate_auc
from lrsr.evaluation.likelihood import cllr, cllr_min, cross_entropy
from lrsr.evaluation.rates import equal_error_rate
from lrsr.evaluation.roc import partial_area

DATA = Path(__file__).parents[1] / "data"
ASAH = json.loads((DATA / "asah_proc.json").read_text())
LIR = json.loads((DATA / "lir.json").read_text())["cases"]
EER = json.loads((DATA / "eer.json").read_text())["cases"]
NAMES = [case["name"] for case in LIR]
CASES = list(zip(LIR, EER, strict=True))


def scores_of(marker: str) -> tuple[list[float], list[float]]:
    return ASAH["scores"][marker]["genuine"], ASAH["scores"][marker]["impostor"]


@pytest.mark.parametrize("marker", ["wfns", "ndka", "s100b"])
def test_auc_and_variance_are_those_of_proc(marker: str) -> None:
    found = estimate_auc(*scores_of(marker))
    assert found.auc == pytest.approx(ASAH["auc"][marker], abs=1e-12)
    assert found.std**2 == pytest.approx(ASAH["variance"][marker], rel=1e-12)


def test_interval_is_that_of_proc() -> None:
    found = estimate_auc(*scores_of("ndka"))
    assert [found.low, found.high] == pytest.approx(ASAH["interval_of_ndka"], abs=1e-12)


@pytest.mark.parametrize("test", ASAH["tests"], ids=lambda test: f"{test['a']}-{test['b']}")
def test_paired_test_is_that_of_proc(test: dict[str, Any]) -> None:
    found = compare_aucs(*scores_of(test["a"]), *scores_of(test["b"]))
    for name in ("z", "p", "low", "high"):
        assert getattr(found, name) == pytest.approx(test[name], abs=1e-12)


@pytest.mark.parametrize("marker", ["wfns", "ndka"])
def test_partial_area_is_that_of_proc(marker: str) -> None:
    found = partial_area(trace_roc(*scores_of(marker)), 0.1)
    assert found.area == pytest.approx(ASAH["area_to_fmr_0.1"][marker], abs=1e-12)


@pytest.mark.parametrize("case", LIR, ids=NAMES)
def test_costs_are_those_of_lir(case: dict[str, Any]) -> None:
    scores = case["genuine"], case["impostor"]
    assert cllr(*scores) == pytest.approx(case["cllr_of_scores"], abs=1e-12)
    assert cllr_min(*scores) == pytest.approx(case["cllr_min"], abs=1e-12)
    excess = cllr(*scores) - cllr_min(*scores)
    assert excess == pytest.approx(case["cllr_cal_of_scores"], abs=1e-12)


@pytest.mark.parametrize("case", LIR, ids=NAMES)
def test_cross_entropy_is_that_of_lir(case: dict[str, Any]) -> None:
    found = cross_entropy(case["genuine"], case["impostor"], case["ece_at_log10_odds"])
    assert found.tolist() == pytest.approx(case["ece_of_scores"], abs=1e-12)


@pytest.mark.parametrize(("name", "tolerance"), [("logistic", 1e-6), ("pav", 1e-12), ("kde", 1e-3)])
@pytest.mark.parametrize("case", LIR, ids=NAMES)
def test_ratios_are_those_of_lir(case: dict[str, Any], name: str, tolerance: float) -> None:
    if name not in case:
        pytest.skip("without a ridge there is no logistic fit to separated scores")
    found = CALIBRATORS[name](case["genuine"], case["impostor"])(case["at"])
    assert found.tolist() == pytest.approx(case[name], abs=tolerance)


@pytest.mark.parametrize("case", LIR, ids=NAMES)
def test_bounds_are_those_of_lir(case: dict[str, Any]) -> None:
    found = elub(case["genuine"], case["impostor"])
    assert [found.low, found.high] == pytest.approx(case["elub_of_scores"], abs=1e-9)


@pytest.mark.parametrize(("scores", "wanted"), CASES, ids=NAMES)
def test_rates_are_those_of_pyeer(scores: dict[str, Any], wanted: dict[str, Any]) -> None:
    own = scores["genuine"], scores["impostor"]
    assert equal_error_rate(trace_roc(*own)) == pytest.approx(wanted["pyeer"]["eer"], abs=1e-12)
    for target in (0.1, 0.01):
        found = fnmr_at_fmr(*own, target)
        if found.fmr == target:  # pyeer takes the nearest FMR where none is right at the target
            wish = wanted["pyeer"][f"fnmr_at_fmr_{target}"]
            assert found.fnmr == pytest.approx(wish, abs=1e-12)


@pytest.mark.parametrize(("scores", "wanted"), CASES, ids=NAMES)
def test_rates_are_those_of_bob(scores: dict[str, Any], wanted: dict[str, Any]) -> None:
    own, bob = (scores["genuine"], scores["impostor"]), wanted["bob"]
    assert equal_error_rate(trace_roc(*own)) == pytest.approx(bob["eer"], abs=1e-12)
    assert estimate_auc(*own).auc == pytest.approx(bob["roc_auc"], abs=1e-12)
    nats = [[score / 2.302585092994046 for score in side] for side in own]  # bob's are natural
    assert cllr(*nats) == pytest.approx(bob["cllr_of_scores"], abs=1e-12)


def test_d_prime_differs_from_decidability_by_the_variance_that_is_taken() -> None:
    """Pyeer divides by n, we by n - 1."""
    case = LIR[0]
    found = d_prime(case["genuine"], case["impostor"])
    assert found == pytest.approx(EER[0]["pyeer"]["d_prime"], rel=0.01)
