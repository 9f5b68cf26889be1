import numpy as np
import pytest

from lrsr.errors import ScoreError
from lrsr.evaluation.chi_square import chi_square_scores


def histograms(count: int, seed: int = 0) -> np.ndarray:
    rows = np.random.default_rng(seed).random((count, 9))
    rows[:, :3] *= np.random.default_rng(seed + 1).random((count, 3)) > 0.5  # some bins are empty
    return rows / rows.sum(axis=1, keepdims=True)


def test_a_score_is_that_of_the_definition() -> None:
    probes, gallery = histograms(3), histograms(2, 5)
    found = chi_square_scores(probes, gallery, list("abc"), list("ab")).matrix
    for row, p in enumerate(probes):
        for column, g in enumerate(gallery):
            terms = [(x - y) ** 2 / (x + y) for x, y in zip(p, g, strict=True) if x + y > 0]
            assert found[row, column] == pytest.approx(1 - sum(terms) / 2)


def test_who_is_equal_scores_one_and_who_shares_nothing_zero() -> None:
    rows = np.array([[1.0, 0.0], [0.0, 1.0]])
    assert chi_square_scores(rows, rows, "ab", "ab").matrix.tolist() == [[1, 0], [0, 1]]


def test_swapping_probes_and_gallery_turns_the_matrix() -> None:
    a, b = histograms(3), histograms(4, 5)
    forth = chi_square_scores(a, b, list("abc"), list("abcd")).matrix
    np.testing.assert_allclose(forth.T, chi_square_scores(b, a, list("abcd"), list("abc")).matrix)


def test_no_face_is_no_score() -> None:
    rows = histograms(2).astype(np.float32)
    rows[1] = np.nan
    scores = chi_square_scores(rows, rows, "ab", "ab")
    assert np.isnan(scores.matrix).tolist() == [[False, True], [True, True]]
    assert not scores.complete


@pytest.mark.parametrize(
    "rows", [np.ones((2, 3)), np.array([[-0.5, 1.5], [0.5, 0.5]]), np.ones(2) / 2]
)
def test_what_is_no_histogram_is_refused(rows: np.ndarray) -> None:
    with pytest.raises(ScoreError, match="wanted rows of sum 1"):
        chi_square_scores(rows, rows, "ab", "ab")


def test_other_bins_are_refused() -> None:
    with pytest.raises(ScoreError, match="histograms of 2 bins against 4"):
        chi_square_scores(np.ones((1, 2)) / 2, np.ones((1, 4)) / 4, "a", "a")
