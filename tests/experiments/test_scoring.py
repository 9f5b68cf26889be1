"""Tests of lrsr/experiments/scoring.py and further.py, of the command line down."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lrsr.cli import main
from lrsr.errors import InputError
from lrsr.evaluation.pairs import PairScores
from lrsr.evaluation.score_files.reading import read_scores
from lrsr.evaluation.score_files.system import Name, System
from lrsr.evaluation.score_files.writing import score_file
from lrsr.evaluation.scores import Scores
from lrsr.experiments.asked import Asked
from lrsr.experiments.scoring import Scoring

PEOPLE = [f"p{k:02d}" for k in range(40)]


def asked(**changes: Any) -> Asked:
    return Asked(**{"level": 0.95, "bootstrap": 40, "seed": 0, "calibration": "pav", **changes})


def system(signal: float, seed: int = 0) -> System:
    noise = np.random.default_rng(0).normal(size=(40, 40))
    noise += 0.5 * np.random.default_rng(seed).normal(size=(40, 40))
    quality = np.diag(noise).tolist()
    return System(
        Scores(noise + signal * np.eye(40), PEOPLE, PEOPLE), PEOPLE, PEOPLE, {"q": quality}
    )


def files(folder: Path) -> tuple[Path, Path]:
    """Scores of two methods, and who the people are."""
    with score_file(folder) as table:
        table.add(Name("1", "8", "base", "own", "net"), system(1.5, 1))
        table.add(Name("1", "8", "sr", "own", "net"), system(2.5, 2))
    people = folder / "people.csv"
    lines = [f"{p},{'female' if k % 2 else 'male'},{20 + k}" for k, p in enumerate(PEOPLE)]
    people.write_text("\n".join(["identity_id,sex,age_years", *lines]))
    return folder / "scores.csv", people


def results_of(folder: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((folder / "results.json").read_text())
    return found


def test_everything_is_found_and_told(tmp_path: Path) -> None:
    scores, people = files(tmp_path)
    scoring = Scoring((scores,), asked(), people=people, qualities=("q",), export="bob")
    results = results_of(scoring.run(tmp_path / "run"))
    assert [row["label"] for row in results["rows"]] == ["base", "sr"]
    (test,) = results["comparisons"]
    assert (test["method"], test["against"], test["p_holm"]) == ("sr", "base", test["p"])
    assert test["bootstrap_low"] < test["difference"] < test["bootstrap_high"]
    assert [one["calibration"] for one in results["likelihood_ratios"]] == ["pav", "pav"]
    assert {(one["trait"], one["group"]) for one in results["groups"]} == {
        ("sex", "female"), ("sex", "male"), ("age", "18 to 29"), ("age", "30 to 39"),
        ("age", "40 to 49"), ("age", "50 to 59"),
    }  # fmt: skip
    for one in results["discards"]:  # the quality is what makes a genuine score
        assert one["fnmr_30"] < one["fnmr_0"]
    page = (tmp_path / "run" / "report.html").read_text()
    for word in ("Likelihood ratios", "Groups of people", "sex: female", "DET", "Tippett"):
        assert word in page
    for name in ("base", "sr"):
        (same,) = read_scores([tmp_path / "run" / f"scores-option1-8-{name}.csv"], "bob").values()
        assert same.source.genuine().size == 40


def test_the_same_seed_gives_the_same_results(tmp_path: Path) -> None:
    scores, people = files(tmp_path)
    one, same = (
        results_of(Scoring((scores,), asked(), people=people).run(tmp_path / name)) for name in "ab"
    )
    assert one == same


def test_methods_of_other_pairs_are_not_tested_against_each_other(tmp_path: Path) -> None:
    whole, fewer = system(2.0), system(2.0).source.restricted(PEOPLE[:30])
    with score_file(tmp_path) as table:
        table.add(Name(method="whole"), System(whole.source, PEOPLE, PEOPLE))
        table.add(Name(method="fewer"), System(fewer, PEOPLE[:30], PEOPLE[:30]))
    results = results_of(Scoring((tmp_path / "scores.csv",), asked()).run(tmp_path / "run"))
    assert [row["n_genuine"] for row in results["rows"]] == [40, 30]
    assert results["comparisons"] == []


def test_unnamed_pairs_have_no_interval_over_people_and_no_rank(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    for name, mean, count in (("g", 2, 30), ("i", 0, 300)):
        (tmp_path / name).write_text("\n".join(map(str, rng.normal(mean, 1, count))))
    scoring = Scoring((tmp_path / "g", tmp_path / "i"), asked(), format="genuine_impostor")
    (row,) = results_of(scoring.run(tmp_path / "run"))["rows"]
    assert row["subject_low"] is row["bootstrap_low"] is row["rank_1"] is None
    assert (row["n_genuine"], row["n_impostor"]) == (30, 300)


def test_too_few_people_have_no_likelihood_ratios(tmp_path: Path) -> None:
    few = system(2.0).source.restricted(PEOPLE[:12])
    with score_file(tmp_path) as table:
        table.add(Name(method="few"), System(few, PEOPLE[:12], PEOPLE[:12]))
    results = results_of(Scoring((tmp_path / "scores.csv",), asked()).run(tmp_path / "run"))
    assert results["likelihood_ratios"] == results["groups"] == results["discards"] == []


def test_the_command_takes_files_without_a_key(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    scores, _ = files(tmp_path)
    scores.rename(tmp_path / "my scores, (1).csv")
    monkeypatch.chdir(tmp_path)
    words = ["bootstrap=10", "name=closed_engine", "paths.run=run"]
    assert main(["score", "my scores, (1).csv", *words]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == str(tmp_path / "run")
    assert "Closed engine" in (tmp_path / "run" / "report.html").read_text()


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ([], "add files="),
        (["absent.csv"], "absent.csv: No such file"),
        (["scores.csv", "format=excel"], "format=excel: wanted null or one of native"),
        (["scores.csv", "calibration=platt"], "calibration=platt: wanted one of logistic"),
        (["scores.csv", "export=excel"], "export=excel: wanted null or bob"),
        (["scores.csv", "bootstrap=-1"], "bootstrap=-1: wanted 0 or more draws"),
        (["scores.csv", "level=2"], "level=2"),
        (["scores.csv", "quality=sharpness"], "0 columns sharpness"),
        (["scores.csv", "people=scores.csv"], "no column identity_id among"),
        (["scores.csv", "people=absent.csv"], "cannot read"),
    ],
)
def test_what_is_wrong_is_one_line(
    words: list[str],
    says: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    files(tmp_path)
    monkeypatch.chdir(tmp_path)
    assert main(["score", *words]) == 2
    lines = capsys.readouterr().err.strip().splitlines()
    assert len(lines) == 1
    assert says in lines[0]


def test_an_ipd_that_is_no_number_is_refused(tmp_path: Path) -> None:
    with score_file(tmp_path) as table:
        table.add(Name(ipd_px="wide", method="m"), System(system(1.0).source, PEOPLE, PEOPLE))
    with pytest.raises(InputError, match="ipd_px 'wide'"):
        Scoring((tmp_path / "scores.csv",), asked()).run(tmp_path / "run")


def test_listed_pairs_have_tables_without_ranks(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    source = PairScores(rng.normal(size=200), PEOPLE * 5, [*PEOPLE, *(PEOPLE[1:] * 4), *PEOPLE[:4]])
    with score_file(tmp_path) as table:
        pairs = [f"{k}" for k in range(200)]
        table.add(Name(method="m"), System(source, pairs, pairs))
    (row,) = results_of(Scoring((tmp_path / "scores.csv",), asked()).run(tmp_path / "run"))["rows"]
    assert row["rank_1"] is None
    assert row["subject_std"] is not None
