"""Tests of lrsr/evaluation/score_files/writing.py."""

import gzip
from pathlib import Path

import numpy as np
import pytest

from lrsr.evaluation.pairs import PairScores
from lrsr.evaluation.score_files.reading import FURTHER, NATIVE, read_scores
from lrsr.evaluation.score_files.system import Name, System
from lrsr.evaluation.score_files.writing import score_file, write_bob
from lrsr.evaluation.scores import Scores

NAMES = [Name("6", "8", "base", "shared", "net"), Name("6", "8", "sr 2x2", "shared", "net")]


def system(seed: int = 0) -> System:
    matrix = np.random.default_rng(seed).normal(size=(4, 3))
    matrix[1] = np.nan
    source = Scores(matrix, list("abca"), list("abc"))
    probes = ['a "1", left.png', "b.png", "c.png", "a2.png"]
    return System(source, probes, ["a.png", "b.png", "c.png"])


def written(folder: Path, **settings: int) -> list[System]:
    systems = [system(0), system(1)]
    with score_file(folder, **settings) as table:
        for name, one in zip(NAMES, systems, strict=True):
            table.add(name, one)
    return systems


@pytest.mark.parametrize(("large", "file"), [(1 << 20, "scores.csv"), (100, "scores.csv.gz")])
def test_what_is_written_is_read_to_the_last_digit(large: int, file: str, tmp_path: Path) -> None:
    systems = written(tmp_path, large=large)
    assert [path.name for path in tmp_path.iterdir()] == [file]
    found = read_scores([tmp_path / file])
    assert list(found) == NAMES
    for one, same in zip(systems, found.values(), strict=True):
        np.testing.assert_array_equal(same.source.rows(0, 4), one.source.rows(0, 4))
        assert same.source.probe_ids == one.source.probe_ids
        assert (same.probes, same.gallery) == (one.probes, one.gallery)


def test_columns_are_named_and_failures_are_nan(tmp_path: Path) -> None:
    written(tmp_path)
    lines = (tmp_path / "scores.csv").read_text().splitlines()
    assert lines[0] == ",".join((*NATIVE, *FURTHER))
    assert lines[4] == "b.png,a.png,0,base,shared,net,NaN,6,8,b,a"


def test_equal_scores_are_equal_bytes_and_an_earlier_kind_goes(tmp_path: Path) -> None:
    written(tmp_path)
    written(tmp_path, large=100)
    first = (tmp_path / "scores.csv.gz").read_bytes()
    assert not (tmp_path / "scores.csv").exists()
    written(tmp_path, large=100)
    assert (tmp_path / "scores.csv.gz").read_bytes() == first
    assert len(gzip.decompress(first).splitlines()) == 1 + 2 * 12


def test_a_run_that_fails_leaves_nothing(tmp_path: Path) -> None:
    def fail() -> None:
        with score_file(tmp_path, 10) as table:
            table.add(NAMES[0], system())
            raise RuntimeError("midway")

    with pytest.raises(RuntimeError, match="midway"):
        fail()
    assert list(tmp_path.iterdir()) == []


def test_qualities_are_further_columns_of_all_systems(tmp_path: Path) -> None:
    one = system()
    measured = System(one.source, one.probes, one.gallery, {"norm": [1.0, 2.0, 3.0, 4.5]})
    with score_file(tmp_path) as table:
        table.add(NAMES[0], measured)
        with pytest.raises(ValueError, match="wanted those of the first"):
            table.add(NAMES[1], one)
    (found,) = read_scores([tmp_path / "scores.csv"], qualities=["norm"]).values()
    assert found.qualities == {"norm": [1.0, 2.0, 3.0, 4.5]}


def test_bobs_file_says_who_is_who(tmp_path: Path) -> None:
    path, one = tmp_path / "bob.csv", system()
    write_bob(path, one)
    head = "probe_subject_id,probe_template_id,bio_ref_subject_id,bio_ref_template_id,score"
    assert path.read_text().splitlines()[0] == head
    (same,) = read_scores([path]).values()
    np.testing.assert_array_equal(same.source.rows(0, 4), one.source.rows(0, 4))


def test_listed_pairs_are_written_one_by_one(tmp_path: Path) -> None:
    source = PairScores(np.array([0.5, -1.0, 0.25]), list("aab"), list("abc"))
    pairs = System(source, ["a1", "a1", "b1"], ["a2", "b2", "c2"])
    with score_file(tmp_path) as table:
        table.add(NAMES[0], pairs)
    write_bob(tmp_path / "bob.csv", pairs)
    for file in ("scores.csv", "bob.csv"):
        (same,) = read_scores([tmp_path / file]).values()
        assert same.source.genuine().tolist() == [0.5]
        assert same.source.impostor().tolist() == [-1.0, 0.25]
