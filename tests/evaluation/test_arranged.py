"""Tests of lrsr/evaluation/arranged.py."""

import numpy as np
import pytest
from numpy.typing import NDArray

from lrsr.errors import ScoreError
from lrsr.evaluation.arranged import diagonal, mean_templates
from lrsr.evaluation.scores import CosineScores, Scores


def faces(count: int, seed: int = 0) -> NDArray[np.float64]:
    rows = np.random.default_rng(seed).normal(size=(count, 16))
    unit: NDArray[np.float64] = rows / np.linalg.norm(rows, axis=1, keepdims=True)
    return unit


@pytest.mark.parametrize("count", [1, 700])
def test_listed_pairs_are_the_diagonal(count: int) -> None:
    probes, gallery = faces(count), faces(count, 1)
    left, right = [f"p{k}" for k in range(count)], [f"p{k - k % 2}" for k in range(count)]
    found = diagonal(CosineScores(probes, gallery, left, right))
    np.testing.assert_allclose(found.values, (probes * gallery).sum(axis=1), atol=1e-12)
    assert found.mates[0].tolist() == [k for k in range(count) if k % 2 == 0]


def test_a_template_is_the_mean_and_as_long() -> None:
    gallery, probes = faces(5), faces(3, 1)
    found = mean_templates(CosineScores(probes, gallery, list("xyz"), list("bacab")))
    assert found.gallery_ids == ("a", "b", "c")
    wanted = gallery[1] + gallery[3]
    np.testing.assert_allclose(found.gallery[0], wanted / np.linalg.norm(wanted))
    np.testing.assert_allclose(found.gallery[2], gallery[2])
    np.testing.assert_allclose(found.rows(0, 3), probes @ found.gallery.T)


def test_pictures_without_a_face_are_left_out_of_a_template() -> None:
    gallery = faces(3)
    gallery[0], gallery[2] = np.nan, np.nan
    found = mean_templates(CosineScores(faces(2, 1), gallery, ["a", "b"], ["a", "a", "b"]))
    np.testing.assert_allclose(found.gallery[0], gallery[1])
    assert np.isnan(found.gallery[1]).all()


def test_templates_of_what_is_no_embedding_are_refused() -> None:
    with pytest.raises(ScoreError, match="templates are means of embeddings"):
        mean_templates(Scores(np.eye(2), ["a", "b"], ["a", "b"]))
