"""Tests of lrsr/evaluation/arranged.py."""

import numpy as np
import pytest
from numpy.typing import NDArray

from lrsr.errors import ScoreError
from lrsr.evaluation.arranged import Templates, diagonal, mean_templates
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
    cosines = CosineScores(probes, gallery, list("xyz"), list("bacab"))
    found = mean_templates(cosines, gallery=Templates(list("bacab")))
    assert found.gallery_ids == ("a", "b", "c")
    wanted = gallery[1] + gallery[3]
    np.testing.assert_allclose(found.gallery[0], wanted / np.linalg.norm(wanted))
    np.testing.assert_allclose(found.gallery[2], gallery[2])
    np.testing.assert_allclose(found.rows(0, 3), probes @ found.gallery.T)


def test_probes_are_templates_too_and_a_person_may_have_two() -> None:
    probes = faces(4)
    cosines = CosineScores(probes, faces(1, 1), list("abab"), ["a"])
    found = mean_templates(cosines, probes=Templates(["t2", "t1", "t3", "t1"]))
    assert found.probe_ids == ("b", "a", "a")
    np.testing.assert_allclose(found.probes[1:], probes[[0, 2]])
    assert found.gallery_ids == ("a",)


def test_a_medium_counts_as_one_picture_whatever_frames_of_it_have_a_face() -> None:
    gallery = faces(5)
    gallery[3] = np.nan
    cosines = CosineScores(faces(1, 1), gallery, ["a"], ["a"] * 5)
    media = ["still", "video", "video", "video", "video"]
    found = mean_templates(cosines, gallery=Templates(["t"] * 5, media))
    wanted = gallery[0] + gallery[[1, 2, 4]].mean(axis=0)
    np.testing.assert_allclose(found.gallery[0], wanted / np.linalg.norm(wanted))


def test_pictures_without_a_face_are_left_out_of_a_template() -> None:
    gallery = faces(3)
    gallery[0], gallery[2] = np.nan, np.nan
    cosines = CosineScores(faces(2, 1), gallery, ["a", "b"], ["a", "a", "b"])
    found = mean_templates(cosines, gallery=Templates(["a", "a", "b"], ["1", "2", "3"]))
    np.testing.assert_allclose(found.gallery[0], gallery[1])
    assert np.isnan(found.gallery[1]).all()


def test_a_template_of_two_people_is_refused() -> None:
    cosines = CosineScores(faces(1), faces(2), ["a"], ["a", "b"])
    with pytest.raises(ScoreError, match="template t shows two people"):
        mean_templates(cosines, gallery=Templates(["t", "t"]))


def test_templates_of_what_is_no_embedding_are_refused() -> None:
    with pytest.raises(ScoreError, match="templates are means of embeddings"):
        mean_templates(Scores(np.eye(2), ["a", "b"], ["a", "b"]))
