"""Tests of lrsr/evaluation/subjects.py."""

import json
import math
from dataclasses import asdict

import numpy as np
import pytest
from oracles import auc as oracle

from lrsr.errors import ScoreError
from lrsr.evaluation.delong import estimate_auc
from lrsr.evaluation.scores import Scores
from lrsr.evaluation.subjects import bootstrap_aucs, jackknife_auc

NAN = float("nan")


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
    estimate = jackknife_auc(scores)
    variance = oracle.jackknife_variance(
        scores.matrix.tolist(), list(scores.probe_ids), list(scores.gallery_ids)
    )
    assert estimate.std**2 == pytest.approx(float(variance), rel=1e-12)
    assert estimate.auc == estimate_auc(scores.genuine(), scores.impostor()).auc


def test_jackknife_is_near_delong_with_one_pair_per_person() -> None:
    scores = embed(150, 1, seed=0)
    delong = estimate_auc(scores.genuine(), scores.impostor())
    assert jackknife_auc(scores).std == pytest.approx(delong.std, rel=0.2)


@pytest.mark.parametrize("images", [1, 5])
def test_jackknife_error_is_the_spread_over_samples_of_people(images: int) -> None:
    estimates = [jackknife_auc(embed(40, images, seed)) for seed in range(150)]
    true_std = np.std([estimate.auc for estimate in estimates], ddof=1)
    stated = math.sqrt(np.mean([estimate.std**2 for estimate in estimates]))
    # The spread of 150 samples is known to 1 / sqrt(300) = 6 %.
    assert stated / true_std == pytest.approx(1, abs=0.2)


def test_delong_is_too_sure_with_many_images_per_person() -> None:
    scores = embed(40, 12, seed=1)
    delong = estimate_auc(scores.genuine(), scores.impostor())
    assert jackknife_auc(scores).std > 1.5 * delong.std


def test_bootstrap_agrees_with_the_jackknife() -> None:
    scores = embed(60, 3, seed=2)
    bootstrap = bootstrap_aucs({"a": scores}, replicates=400).auc("a")
    assert bootstrap.std == pytest.approx(jackknife_auc(scores).std, rel=0.2)


def test_bootstrap_measures_what_delong_measures() -> None:
    scores = small(0)
    measured = bootstrap_aucs({"a": scores}, replicates=20).auc("a")
    assert measured.value == pytest.approx(estimate_auc(scores.genuine(), scores.impostor()).auc)
    assert measured.low <= measured.value <= measured.high


def test_bootstrap_of_a_draw_is_the_auc_of_repeated_people() -> None:
    # Weights 2, 1, 0 by hand: person a twice (its pairs doubled), c absent.
    matrix = np.array([[5, 1, 9], [4, 3, 9], [9, 9, 9]], dtype=float)
    scores = Scores(matrix, list("abc"), list("abc"))
    draws = np.random.default_rng(0)
    wanted = []
    for _ in range(50):
        times = np.bincount(draws.integers(3, size=3), minlength=3)
        genuine = [matrix[k, k] for k in range(3) for _ in range(times[k])]
        impostor = [
            matrix[r, c]
            for r in range(3)
            for c in range(3)
            if r != c
            for _ in range(times[r] * times[c])
        ]
        if impostor:
            wanted.append(float(oracle.auc(genuine, impostor)))
    result = bootstrap_aucs({"only": scores}, replicates=50, seed=0)
    assert result.replicates["only"].tolist() == pytest.approx(wanted, rel=1e-12)


def test_a_method_does_not_differ_from_itself_in_any_draw() -> None:
    scores = embed(20, 2, seed=3)
    result = bootstrap_aucs({"a": scores, "b": scores}, replicates=20).difference("a", "b")
    assert (result.value, result.std, result.low, result.high) == (0, 0, 0, 0)


def test_pairing_makes_the_difference_surer_than_its_parts() -> None:
    a = embed(50, 2, seed=4)
    noise = np.random.default_rng(0).normal(0, 0.02, a.matrix.shape)
    b = Scores(a.matrix + noise, a.probe_ids, a.gallery_ids)
    result = bootstrap_aucs({"a": a, "b": b}, replicates=100)
    assert result.difference("a", "b").std < 0.5 * result.auc("a").std


def test_the_same_seed_draws_the_same_people() -> None:
    scores = embed(20, 1, seed=5)
    a, b, c = (
        bootstrap_aucs({"a": scores}, replicates=10, seed=seed).replicates["a"].tolist()
        for seed in (1, 1, 2)
    )
    assert a == b != c


def test_intervals_go_to_json() -> None:
    interval = bootstrap_aucs({"a": small(1)}, replicates=10).auc("a")
    assert json.loads(json.dumps(asdict(interval)))["replicates"] == interval.replicates


def test_jackknife_of_one_person_is_refused() -> None:
    with pytest.raises(ScoreError, match="1 identities with a genuine score"):
        jackknife_auc(Scores(np.array([[1.0, 0.0]]), ["a"], ["a", "b"]))


def test_jackknife_of_two_people_is_refused() -> None:
    with pytest.raises(ScoreError, match="no impostor score is left"):
        jackknife_auc(Scores(np.eye(2), ["a", "b"], ["a", "b"]))


def test_jackknife_refuses_a_level_of_one() -> None:
    with pytest.raises(ScoreError, match="confidence level"):
        jackknife_auc(small(0), level=1)


@pytest.mark.parametrize(
    ("methods", "replicates", "message"),
    [
        pytest.param({}, 10, "0 methods", id="no-method"),
        pytest.param({"a": small(0)}, 1, "1 replicates", id="one-replicate"),
        pytest.param(
            {"a": small(0), "b": embed(3, 1, 0)}, 10, "b has other probes", id="other-probes"
        ),
        pytest.param(
            {"a": Scores(np.array([[1.0]]), ["a"], ["a"])}, 10, "0 impostor", id="no-impostor"
        ),
        pytest.param(
            {"a": Scores(np.array([[1.0]]), ["a"], ["b"])}, 10, "0 genuine", id="no-genuine"
        ),
    ],
)
def test_a_bootstrap_that_cannot_be_drawn_is_refused(
    methods: dict[str, Scores], replicates: int, message: str
) -> None:
    with pytest.raises(ScoreError, match=message):
        bootstrap_aucs(methods, replicates=replicates)


def test_a_bootstrap_without_usable_draws_is_refused() -> None:
    scores = Scores(np.array([[1.0, 0.0], [NAN, NAN]]), ["a", "b"], ["a", "b"])
    with pytest.raises(ScoreError, match="hardly any draw"):
        bootstrap_aucs({"a": scores}, replicates=2, seed=0)


def test_a_bootstrap_refuses_a_level_of_one() -> None:
    with pytest.raises(ScoreError, match="confidence level"):
        bootstrap_aucs({"a": small(0)}, level=1)
