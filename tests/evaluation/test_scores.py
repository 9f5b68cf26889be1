"""Tests of lrsr.evaluation.scores.py."""

from typing import Any

import numpy as np
import pytest
import torch

from lrsr.errors import InputError, ScoreError
from lrsr.evaluation.scores import CosineScores, Scores

NAN = float("nan")


def three_people() -> Scores:
    matrix = np.array([[0.9, 0.1, 0.2], [0.3, NAN, 0.4], [NAN, NAN, NAN]], dtype=np.float32)
    return Scores(matrix, ["ann", "bob", "cy"], ["ann", "bob", "cy"])


def test_genuine_scores_are_those_of_equal_ids() -> None:
    scores = Scores(np.arange(6).reshape(2, 3), ["b", "a"], ["a", "b", "a"])
    assert scores.genuine().tolist() == [1, 3, 5]


def test_impostor_scores_are_all_others_row_by_row() -> None:
    scores = Scores(np.arange(6).reshape(2, 3), ["b", "a"], ["a", "b", "a"])
    assert scores.impostor().tolist() == [0, 2, 4]


def test_missing_scores_are_in_neither_list() -> None:
    scores = three_people()
    assert scores.genuine().tolist() == [np.float32(0.9)]
    assert scores.impostor().tolist() == np.float32([0.1, 0.2, 0.3, 0.4]).tolist()


def test_every_score_is_genuine_impostor_or_missing() -> None:
    rng = np.random.default_rng(0)
    matrix = np.where(rng.random((7, 9)) < 0.2, NAN, rng.random((7, 9)))
    scores = Scores(matrix, list("abcdefg"), list("abcabcxyz"))
    assert scores.genuine().size + scores.impostor().size + np.isnan(matrix).sum() == matrix.size


def test_dtype_of_the_matrix_is_kept() -> None:
    assert three_people().genuine().dtype == np.float32


def test_ids_become_strings() -> None:
    scores = Scores(np.eye(2), np.array([1, 2]), ["1", "2"])  # type: ignore[arg-type] # on purpose
    assert scores.genuine().tolist() == [1, 1]


def test_other_probes_are_not_the_same_pairs() -> None:
    a = three_people()
    a.check_same_pairs(Scores(np.eye(3), a.probe_ids, a.gallery_ids), "b")
    with pytest.raises(ScoreError, match="b has other probes"):
        a.check_same_pairs(Scores(a.matrix, ["ann", "bob", "dee"], a.gallery_ids), "b")


@pytest.mark.parametrize(("place", "complete"), [(None, True), (0, False), (8, False)])
def test_a_matrix_is_complete_without_a_missing_score(place: int | None, complete: bool) -> None:
    matrix = np.eye(3)
    if place is not None:
        matrix.flat[place] = NAN
    assert Scores(matrix, list("abc"), list("abc")).complete is complete


@pytest.mark.parametrize(
    ("matrix", "message"),
    [
        pytest.param(np.zeros((2, 3)), r"\(2, 3\) for 2 probes and 2 gallery", id="shape"),
        pytest.param(np.zeros((2, 2), complex), "dtype complex128", id="complex"),
        pytest.param(
            np.array([[0, 1], [np.inf, 0]]), r"probe 1 \(bob\) .* image 0 \(ann\) is inf", id="inf"
        ),
    ],
)
def test_broken_scores_are_refused(matrix: np.ndarray, message: str) -> None:
    with pytest.raises(ScoreError, match=message):
        Scores(matrix, ["ann", "bob"], ["ann", "bob"])


def test_an_empty_matrix_is_refused() -> None:
    with pytest.raises(ScoreError, match="0 probes"):
        Scores(np.zeros((0, 2)), [], ["ann", "bob"])


def test_a_score_error_is_the_users_fault_and_a_value_error() -> None:
    assert issubclass(ScoreError, InputError)
    assert issubclass(ScoreError, ValueError)


# Identities.


@pytest.mark.parametrize(
    "ids",
    [
        pytest.param([1, 2], id="integers"),
        pytest.param(np.array([1, 2], np.int16), id="array"),
        pytest.param([np.int64(1), np.uint8(2)], id="numpy-scalars"),
        pytest.param(torch.tensor([1, 2]), id="tensor"),
        pytest.param(list(torch.tensor([1, 2])), id="tensors"),
        pytest.param(np.array(["1", "2"], object), id="objects"),
        pytest.param(map(str, (1, 2)), id="iterator"),
    ],
)
def test_identities_of_any_origin_are_the_same_people(ids: Any) -> None:
    assert Scores(np.eye(2), ids, ["1", "2"]).genuine().tolist() == [1, 1]


@pytest.mark.parametrize("ids", [None, 7, {"a", "b"}], ids=["none", "number", "set"])
def test_identities_have_an_order(ids: Any) -> None:
    with pytest.raises(ScoreError, match=r"gallery_ids are .*: give a list"):
        Scores(np.eye(2), ["a", "b"], ids)


@pytest.mark.parametrize(
    ("ids", "named"),
    [
        pytest.param(["a", None], "gallery_ids 1 is None", id="none"),
        pytest.param([NAN, NAN], "gallery_ids 0 is nan", id="nan"),
        pytest.param([1.0, 2.0], r"gallery_ids 0 is 1\.0", id="floats"),
        pytest.param(np.ma.masked_array([1, 2], [False, True]), "gallery_ids 1 is None", id="mask"),
    ],
)
def test_a_missing_identity_is_nobodys_mate(ids: Any, named: str) -> None:
    with pytest.raises(ScoreError, match=named):
        Scores(np.eye(2), ["a", "b"], ids)


# Tiles.


def faces(people: int, images: int, seed: int) -> tuple[np.ndarray, list[str]]:
    """Embeddings of small whole numbers, so that every product is exact in any order."""
    centres = np.random.default_rng(0).integers(-3, 4, size=(people, 1, 16))
    noise = np.random.default_rng(seed).integers(-3, 4, size=(people, images, 16))
    ids = np.repeat([f"p{k}" for k in range(people)], images).tolist()
    return (centres + noise).reshape(-1, 16).astype(np.float32), ids


@pytest.mark.parametrize("rows", [1, 7, 60, 1000, None])
def test_tiles_of_cosines_are_the_rows_of_their_matrix(rows: int | None) -> None:
    (probes, probe_ids), (gallery, gallery_ids) = faces(30, 2, 1), faces(40, 3, 2)
    probes[3], gallery[7] = NAN, NAN
    cosines = CosineScores(probes, gallery, probe_ids, gallery_ids)
    matrix = Scores(probes @ gallery.T, probe_ids, gallery_ids)
    for source in (cosines, matrix):
        tiles = list(source.tiles(rows))
        assert np.array_equal(np.vstack([t.scores for t in tiles]), matrix.matrix, equal_nan=True)
        mates = [t.first * 120 + place for t in tiles for place in t.mates.tolist()]
        mated = np.array(probe_ids)[:, None] == np.array(gallery_ids)
        assert mates == np.flatnonzero(mated).tolist()
        acquired = ~np.isnan(matrix.matrix)
        assert source.genuine().tolist() == matrix.matrix[mated & acquired].tolist()
        assert source.impostor().tolist() == matrix.matrix[~mated & acquired].tolist()
        assert not source.complete


def test_a_tile_tells_where_scores_are_absent_and_fills_them() -> None:
    (tile,) = three_people().tiles()
    assert np.flatnonzero(tile.absent).tolist() == [4, 6, 7, 8]
    assert tile.others.tolist() == [0, 4, 6, 7, 8]
    assert tile.filled(0)[1].tolist() == np.float32([0.3, 0, 0.4]).tolist()
    assert tile.rows == slice(0, 3)


def test_tiles_of_no_rows_are_refused() -> None:
    with pytest.raises(ScoreError, match="tiles of 0 rows"):
        next(three_people().tiles(0))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        pytest.param({"probe_ids": ["p0"]}, r"\(4, 16\) for 1 ids", id="ids"),
        pytest.param(
            {"probes": np.zeros(4)}, r"probe embeddings float64 \(4,\)", id="one-dimension"
        ),
        pytest.param(
            {"gallery": np.zeros((4, 16), int)},
            "gallery embeddings have dtype int64: give float32",
            id="integers",
        ),
        pytest.param({"gallery": np.zeros((4, 3))}, "of 16 numbers, gallery of 3", id="sizes"),
        pytest.param({"gallery": np.diag([1, np.nan, 1, 1])}, "gallery embedding 1", id="part-nan"),
        pytest.param({"gallery": np.diag([1, 1, np.inf, 1])}, "gallery embedding 2", id="infinite"),
        pytest.param(
            {"probes": np.ma.masked_array(np.ones((4, 16)), np.eye(4, 16) > 0)},
            "probe embeddings are masked in part",
            id="masked",
        ),
    ],
)
def test_embeddings_that_make_no_scores_are_refused(changes: dict[str, Any], message: str) -> None:
    vectors, ids = faces(4, 1, 1)
    given = {"probes": vectors, "gallery": vectors, "probe_ids": ids, "gallery_ids": ids}
    with pytest.raises(ScoreError, match=message):
        CosineScores(**{**given, **changes})


def test_embeddings_are_taken_from_tensors_that_learn() -> None:
    vectors, ids = faces(4, 1, 1)
    tensor = torch.from_numpy(vectors).requires_grad_().bfloat16()
    scores = CosineScores(tensor, tensor, ids, ids)  # type: ignore[arg-type] # duck-typed
    assert scores.genuine().tolist() == (vectors**2).sum(axis=1).tolist()
