"""Tests of lrsr/evaluation/subjects.py."""

import math

import numpy as np
import pytest
from oracles import auc as oracle

from lrsr.errors import ScoreError
from lrsr.evaluation.delong import estimate_auc, measure_auc
from lrsr.evaluation.scores import Scores
from lrsr.evaluation.subjects import Tally, jackknife_std

NAN = float("nan")


def leave_out(scores: Scores, rows: int | None = None) -> np.ndarray:
    """The AUC without each person."""
    tally = Tally(scores, scores.mated_scores())
    for tile in scores.tiles(rows):
        tally.add(tile, tile.others)
    return tally.areas()


def embed(people: int, images: int, seed: int, *, noise: float = 1.6) -> Scores:
    """Cosines of noisy images of people who differ in how recognisable they are."""
    rng = np.random.default_rng(seed)
    centres = rng.normal(size=(people, 12))
    blur = noise * rng.lognormal(0, 0.4, size=(people, 1, 1))
    ids = np.repeat([f"p{k}" for k in range(people)], images).tolist()

    def take(count: int) -> np.ndarray:
        faces = centres[:, None] + blur * rng.normal(size=(people, count, 12))
        faces /= np.linalg.norm(faces, axis=-1, keepdims=True)
        return faces.reshape(people * count, 12)

    return Scores(take(images) @ take(1).T, ids, [f"p{k}" for k in range(people)])


def drawn_auc(scores: Scores, people: np.ndarray) -> float:
    """The AUC with each person as often as drawn, never an impostor to a copy of itself."""
    times = np.bincount(people, minlength=len(people))
    rows, columns = (
        np.array([int(name[1:]) for name in ids]) for ids in (scores.probe_ids, scores.gallery_ids)
    )
    mated = rows[:, None] == columns
    pairs = np.multiply.outer(times[rows], times[columns])
    genuine = np.repeat(scores.matrix[mated], times[rows])  # a person has one gallery picture
    return measure_auc(genuine, np.repeat(scores.matrix[~mated], pairs[~mated]))


def small(seed: int) -> Scores:
    """Few people, ties, missing scores, several images, distractors."""
    rng = np.random.default_rng(seed)
    matrix = rng.integers(0, 6, size=(7, 6)).astype(float)
    matrix[np.arange(7), [0, 0, 1, 2, 3, 3, 1]] += 2
    matrix[2, 4] = matrix[5, :] = NAN
    return Scores(matrix, list("aabcddb"), list("abcdxy"))


@pytest.mark.parametrize("seed", range(4))
def test_jackknife_agrees_with_leaving_each_person_out(seed: int) -> None:
    scores = small(seed)
    std = jackknife_std(leave_out(scores, rows=3))
    variance = oracle.jackknife_variance(
        scores.matrix.tolist(), list(scores.probe_ids), list(scores.gallery_ids)
    )
    assert std**2 == pytest.approx(float(variance), rel=1e-12)


def test_jackknife_is_near_delong_with_one_pair_per_person() -> None:
    scores = embed(150, 1, seed=0)
    delong = estimate_auc(scores.genuine(), scores.impostor())
    assert jackknife_std(leave_out(scores)) == pytest.approx(delong.std, rel=0.2)


@pytest.mark.parametrize("images", [1, 5])
def test_jackknife_error_is_the_spread_over_samples_of_people(images: int) -> None:
    samples = [embed(40, images, seed) for seed in range(150)]
    true_std = np.std([measure_auc(s.genuine(), s.impostor()) for s in samples], ddof=1)
    stated = math.sqrt(np.mean([jackknife_std(leave_out(sample)) ** 2 for sample in samples]))
    # The spread of 150 samples is known to 1 / sqrt(300) = 6 %.
    assert stated / true_std == pytest.approx(1, abs=0.2)


def test_delong_is_too_sure_with_many_images_per_person() -> None:
    scores = embed(40, 12, seed=1)
    delong = estimate_auc(scores.genuine(), scores.impostor())
    assert jackknife_std(leave_out(scores)) > 1.5 * delong.std


def test_bootstrap_agrees_with_the_jackknife() -> None:
    scores = embed(60, 3, seed=2)
    draws = np.random.default_rng(0)
    drawn = [drawn_auc(scores, draws.integers(60, size=60)) for _ in range(400)]
    assert np.std(drawn, ddof=1) == pytest.approx(jackknife_std(leave_out(scores)), rel=0.2)


def test_jackknife_of_one_person_is_refused() -> None:
    with pytest.raises(ScoreError, match="1 identities with a genuine score"):
        leave_out(Scores(np.array([[1.0, 0.0]]), ["a"], ["a", "b"]))


def test_jackknife_of_two_people_is_refused() -> None:
    with pytest.raises(ScoreError, match="no impostor score is left"):
        leave_out(Scores(np.eye(2), ["a", "b"], ["a", "b"]))
