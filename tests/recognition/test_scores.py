"""Tests of lrsr/recognition/scores.py."""

import numpy as np
import pytest

from lrsr.errors import InputError, ScoreError
from lrsr.recognition.scores import Scores

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


def test_a_probe_without_any_score_is_a_failure_to_acquire() -> None:
    assert three_people().n_fta == 1
    assert three_people().fta == pytest.approx(1 / 3)


def test_one_missing_pair_is_no_failure_to_acquire_but_is_counted() -> None:
    scores = three_people()
    assert (scores.n_missing_genuine, scores.n_missing_impostor) == (2, 2)


def test_a_gallery_image_without_any_score_is_a_failure_to_enrol() -> None:
    scores = Scores(np.array([[0.9, NAN], [0.3, NAN]]), ["ann", "bob"], ["ann", "bob"])
    assert (scores.n_fte, scores.n_fta) == (1, 0)


def test_every_score_is_genuine_impostor_or_missing() -> None:
    rng = np.random.default_rng(0)
    matrix = np.where(rng.random((7, 9)) < 0.2, NAN, rng.random((7, 9)))
    scores = Scores(matrix, list("abcdefg"), list("abcabcxyz"))
    missing = scores.n_missing_genuine + scores.n_missing_impostor
    assert scores.genuine().size + scores.impostor().size + missing == matrix.size


def test_dtype_of_the_matrix_is_kept() -> None:
    assert three_people().genuine().dtype == np.float32


def test_ids_become_strings() -> None:
    scores = Scores(np.eye(2), np.array([1, 2]), ["1", "2"])  # type: ignore[arg-type] # on purpose
    assert scores.genuine().tolist() == [1, 1]


def test_pairing_keeps_only_what_both_methods_scored() -> None:
    a = three_people()
    b = Scores(np.array([[NAN, 1, 2], [3, 4, 5], [6, 7, 8]]), a.probe_ids, a.gallery_ids)
    genuine_a, impostor_a, genuine_b, impostor_b = a.pair_with(b)
    assert genuine_a.size == genuine_b.size == 0
    assert impostor_a.tolist() == np.float32([0.1, 0.2, 0.3, 0.4]).tolist()
    assert impostor_b.tolist() == [1, 2, 3, 5]


def test_pairing_refuses_other_probes() -> None:
    a = three_people()
    b = Scores(a.matrix, ["ann", "bob", "dee"], a.gallery_ids)
    with pytest.raises(ScoreError, match="different probes"):
        a.pair_with(b)


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
