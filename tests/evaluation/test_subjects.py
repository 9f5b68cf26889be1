"""Tests of lrsr/evaluation/subjects.py."""

import math

import numpy as np
import pytest
from oracles import auc as oracle

from lrsr.errors import ScoreError
from lrsr.evaluation.delong import estimate_auc, measure_auc
from lrsr.evaluation.scores import Scores
from lrsr.evaluation.subjects import Tally, bootstrap_aucs, jackknife_std

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
    drawn = bootstrap_aucs({"a": scores}, replicates=400)["a"]
    assert drawn.std(ddof=1) == pytest.approx(jackknife_std(leave_out(scores)), rel=0.2)


def test_bootstrap_spreads_round_what_delong_measures() -> None:
    scores = embed(60, 3, seed=2)
    low, high = np.quantile(bootstrap_aucs({"a": scores}, replicates=100)["a"], [0.025, 0.975])
    assert low < measure_auc(scores.genuine(), scores.impostor()) < high


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
    assert result["only"].tolist() == pytest.approx(wanted, rel=1e-12)


def test_a_method_does_not_differ_from_itself_in_any_draw() -> None:
    scores = embed(20, 2, seed=3)
    drawn = bootstrap_aucs({"a": scores, "b": scores}, replicates=20)
    assert drawn["a"].tolist() == drawn["b"].tolist()


def test_pairing_makes_the_difference_surer_than_its_parts() -> None:
    a = embed(50, 2, seed=4)
    noise = np.random.default_rng(0).normal(0, 0.02, a.matrix.shape)
    b = Scores(a.matrix + noise, a.probe_ids, a.gallery_ids)
    drawn = bootstrap_aucs({"a": a, "b": b}, replicates=100)
    assert (drawn["a"] - drawn["b"]).std() < 0.5 * drawn["a"].std()


def test_the_same_seed_draws_the_same_people() -> None:
    scores = embed(20, 1, seed=5)
    a, b, c = (
        bootstrap_aucs({"a": scores}, replicates=10, seed=seed)["a"].tolist() for seed in (1, 1, 2)
    )
    assert a == b != c


def test_jackknife_of_one_person_is_refused() -> None:
    with pytest.raises(ScoreError, match="1 identities with a genuine score"):
        leave_out(Scores(np.array([[1.0, 0.0]]), ["a"], ["a", "b"]))


def test_jackknife_of_two_people_is_refused() -> None:
    with pytest.raises(ScoreError, match="no impostor score is left"):
        leave_out(Scores(np.eye(2), ["a", "b"], ["a", "b"]))


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
