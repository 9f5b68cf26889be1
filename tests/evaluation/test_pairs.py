"""Tests of lrsr/evaluation/pairs.py."""

import numpy as np
import pytest

from lrsr.errors import ScoreError
from lrsr.evaluation.pairs import PairScores
from lrsr.evaluation.pooled import PooledPairs
from lrsr.evaluation.scores import CosineScores, Scores
from lrsr.evaluation.summary import summarise

NAN = float("nan")


def matrix(seed: int = 0) -> Scores:
    rng = np.random.default_rng(seed)
    people = [f"p{k % 9}" for k in range(12)]
    scores = rng.normal(size=(12, 9)) + 2 * (np.arange(12)[:, None] % 9 == np.arange(9))
    scores[3] = scores[5, 5] = NAN
    return Scores(scores, people, [f"p{k}" for k in range(9)])


def listed(source: Scores) -> PairScores:
    left = np.repeat(source.probe_ids, len(source.gallery_ids)).tolist()
    right = list(source.gallery_ids) * len(source.probe_ids)
    return PairScores(source.matrix.ravel(), left, right)


def test_a_list_of_all_pairs_measures_what_the_matrix_measures() -> None:
    methods = [{"a": matrix(0), "b": matrix(1)}, {"a": listed(matrix(0)), "b": listed(matrix(1))}]
    one, other = (summarise(method, bootstrap=30) for method in methods)
    for name in ("a", "b"):
        assert other.summaries[name].area == one.summaries[name].area
        assert other.summaries[name].fnmr == one.summaries[name].fnmr
        assert other.summaries[name].cmc is None
    assert other.comparisons == one.comparisons


def test_any_size_of_tile_gives_the_same_scores() -> None:
    source = listed(matrix())
    parts = [tile.impostors for tile in source.tiles(7)]
    assert np.concatenate(parts).tolist() == source.impostor().tolist()


@pytest.mark.parametrize("kind", ["matrix", "list", "cosines"])
def test_restricted_scores_are_those_of_both_people(kind: str) -> None:
    source = matrix()
    people = {"p1", "p5", "p7"}
    rng = np.random.default_rng(0)
    faces = [rng.normal(size=(len(ids), 4)) for ids in (source.probe_ids, source.gallery_ids)]
    sources = {
        "matrix": source,
        "list": listed(source),
        "cosines": CosineScores(*faces, source.probe_ids, source.gallery_ids),
    }
    part = sources[kind].restricted(people)
    assert {*part.probe_ids} | {*part.gallery_ids} == people
    whole = sources[kind]
    wanted = []
    for tile in whole.tiles():
        for row, column in np.ndindex(tile.scores.shape):
            place = column if whole.crossed else row + tile.first
            if {whole.probe_ids[row + tile.first], whole.gallery_ids[place]} <= people:
                wanted.append(tile.scores[row, column])
    found = np.concatenate([tile.scores.ravel() for tile in part.tiles()])
    assert found == pytest.approx(np.array(wanted), nan_ok=True)


def test_pooled_pairs_are_all_scores_with_their_people() -> None:
    source = matrix()
    for kind in (source, listed(source)):
        pooled = PooledPairs(kind)
        assert sorted(pooled.genuine) == sorted(source.genuine())
        assert sorted(pooled.impostor) == sorted(source.impostor())
        assert (pooled.left != pooled.right).all()


def test_lengths_that_differ_are_refused() -> None:
    with pytest.raises(ScoreError, match="wanted one of each for every pair"):
        PairScores(np.zeros(2), ["a"], ["b", "c"])


def test_an_infinite_score_is_refused() -> None:
    with pytest.raises(ScoreError, match="score of pair 1 is inf"):
        PairScores(np.array([0.0, np.inf]), ["a", "b"], ["a", "c"])


def test_tiles_of_nothing_are_refused() -> None:
    with pytest.raises(ScoreError, match="tiles of 0 rows"):
        next(listed(matrix()).tiles(0))
