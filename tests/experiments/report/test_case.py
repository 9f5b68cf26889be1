"""Tests of lrsr/experiments/report/case.py: what is said of ratios, harmful ones too."""

from pathlib import Path
from typing import Any

from lrsr.experiments.report.case import write_case

NAMES = {"recogniser": "theirs", "option": None, "ipd_px": 9.0, "landmarks": "own"}
SYSTEM = {**NAMES, "method": "base", "label": "Base"}
RATIO = {"score": 0.31, "low": None, "high": None, "cut": False, "beyond": False}
LIMITS = {"bound_low": -1.0, "bound_high": 2.0, "n_people": 20, "n_genuine": 20, "n_impostor": 380}


def line(basis: str, judged: str, cost: float) -> dict[str, Any]:
    costs = {
        f"{name}{end}": None if end else cost
        for name in ("cllr", "cllr_min", "cllr_cal")
        for end in ("", "_low", "_high")
    }
    counts = {"n_development": 20, "n_test": 20, "n_genuine": 20, "n_impostor": 380}
    rates = {"misleading_genuine": 0.1, "misleading_impostor": 0.2}
    return {**SYSTEM, "calibrated_on": basis, "judged_on": judged, **costs, **counts, **rates}


def page(folder: Path, evidence: list[dict[str, Any]]) -> str:
    area = {"auc": 0.8, "low": 0.7, "high": 0.9, "n_genuine": 40, "n_impostor": 1560, "fta": 0.05}
    results = {
        "rows": [SYSTEM | area],
        "evidence": evidence,
        "ratios": [
            {**SYSTEM, "calibrated_on": basis, "llr": llr, **RATIO, **LIMITS}
            for basis, llr in (("this case", 1.0), ("good", 3.0))
        ],
        "missing": ["The score calibrated on mixed: too few."],
        "pair": [],
        "recognition": {},
        "config": {
            "name": "case", "question": "?", "level": 0.95, "calibration": "kde", "seed": 0,
        },
        "versions": {"git": "x"},
    }  # fmt: skip
    return write_case(folder, results, {None: _Nothing()}, {}).read_text()  # type: ignore[dict-item]  # no curves


class _Nothing:
    evidence: dict[str, Any] = {}  # noqa: RUF012  # never changed


def test_the_score_is_told_first_by_every_calibration(tmp_path: Path) -> None:
    text = page(tmp_path, [line("this case", "this case", 0.5)])
    assert "theirs Base: in this case a score of 0.310 has the likelihood ratio 10" in text
    assert "calibrated on generic pictures (good) it would have 1,000" in text
    assert "The score calibrated on mixed: too few." in text


def test_ratios_that_do_harm_are_called_so(tmp_path: Path) -> None:
    some = [line("this case", "real people", 0.8), line("good", "real people", 1.7)]
    said = "theirs Base own, judged on real people: ratios cost (Cllr) 0.800 by this case, 1.700"
    text = page(tmp_path, some)
    assert f"{said} by generic pictures (good); more than 1 is worse than no evidence." in text
    assert "more than 1 is worse" not in page(tmp_path, some[:1])


def test_only_real_people_can_show_what_the_simulation_cannot(tmp_path: Path) -> None:
    said = "suits the simulation, and not that the simulation suits the case"
    assert said in page(tmp_path, [line("this case", "this case", 0.5)])
    assert said not in page(tmp_path, [line("this case", "real people", 0.5)])
