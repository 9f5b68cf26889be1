"""Tests of lrsr/experiments/basis.py."""

from pathlib import Path

import numpy as np
import pytest

from lrsr.errors import InputError
from lrsr.evaluation.score_files.system import Name, System
from lrsr.evaluation.scores import Scores
from lrsr.experiments.basis import choose_basis, scores_file

SYSTEM = System(Scores(np.eye(2), ["a", "b"], ["a", "b"]), ["a", "b"], ["a", "b"])


def of(*names: Name) -> dict[Name, System]:
    return dict.fromkeys(names, SYSTEM)


def test_what_is_made_alike_is_chosen() -> None:
    found = of(Name("1", "8", "base", "own", "x"), Name("1", "8", "base", "own", "y"))
    chosen = choose_basis(
        Path("s.csv"), found, Name(method="base", landmarks="own", recogniser="y")
    )
    assert chosen.describe() == {
        "file": "s.csv", "option": "1", "ipd_px": "8", "method": "base", "landmarks": "own",
        "recogniser": "y",
    }  # fmt: skip


def test_what_no_system_says_does_not_matter() -> None:
    chosen = choose_basis(Path("s.csv"), of(Name()), Name(landmarks="own", recogniser="y"))
    assert chosen.name == Name()


@pytest.mark.parametrize(
    ("found", "wanted", "says"),
    [
        ([Name(recogniser="x")], Name(recogniser="y"), "no scores of recogniser=y, but of x;"),
        ([Name("1"), Name("2")], Name(), "has scores of option 1, 2: add option=1"),
        ([Name(ipd_px="8"), Name(ipd_px="9")], Name(ipd_px="7"), "ipd_px=7, but of 8, 9"),
    ],
)
def test_what_does_not_fit_or_is_not_one_is_refused(
    found: list[Name], wanted: Name, says: str
) -> None:
    with pytest.raises(InputError, match=says):
        choose_basis(Path("s.csv"), of(*found), wanted)


def test_a_run_stands_for_its_scores(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"case\.real=.* holds no scores\.csv"):
        scores_file(tmp_path, "case.real")
    (tmp_path / "scores.csv.gz").touch()
    assert scores_file(tmp_path) == tmp_path / "scores.csv.gz"
    (tmp_path / "scores.csv").touch()
    assert scores_file(tmp_path) == tmp_path / "scores.csv"
    assert scores_file(tmp_path / "other.csv") == tmp_path / "other.csv"
