"""Tests of lrsr/evaluation/summary.py."""

import math
import tracemalloc
from typing import Any

import numpy as np
import pytest
from fakes.measures import d_prime, fnmr_at_fmr, trace_roc
from oracles import auc as oracle

from lrsr.errors import ScoreError
from lrsr.evaluation.delong import _auc_interval, compare_aucs, estimate_auc, measure_auc
from lrsr.evaluation.rates import equal_error_rate
from lrsr.evaluation.scores import CosineScores, Scores
from lrsr.evaluation.summary import Summary, summarise

NAN = float("nan")


def people(count: int, images: int, seed: int) -> tuple[np.ndarray, list[str]]:
    """Embeddings of small whole numbers, so that every product is exact in any order."""
    rng = np.random.default_rng(seed)
    centres = np.random.default_rng(0).integers(-3, 4, size=(count, 1, 16))
    faces = centres + rng.integers(-3, 4, size=(count, images, 16))
    ids = np.repeat([f"p{k}" for k in range(count)], images).tolist()
    return faces.reshape(-1, 16).astype(np.float32), ids


def sources(images: int = 2, seed: int = 1) -> tuple[CosineScores, Scores]:
    """The same scores, made on the way and stored; some probes and gallery images failed."""
    (probes, probe_ids), (gallery, gallery_ids) = people(30, 2, seed), people(40, images, 2)
    probes[3 * seed], gallery[7] = NAN, NAN
    matrix = Scores(np.float64(probes) @ np.float64(gallery).T, probe_ids, gallery_ids)
    return CosineScores(probes, gallery, probe_ids, gallery_ids), matrix


def small(seed: int) -> Scores:
    """Few people, ties, missing scores, several images, distractors."""
    rng = np.random.default_rng(seed)
    matrix = rng.integers(0, 6, size=(7, 6)).astype(float)
    matrix[np.arange(7), [0, 0, 1, 2, 3, 3, 1]] += 2
    matrix[seed % 7, 4] = matrix[(seed + 3) % 7, :] = NAN
    return Scores(matrix, list("aabcddb"), list("abcdxy"))


def pair(a: Scores, b: Scores) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Genuine and impostor scores of the pairs that both methods scored."""
    fails = np.isnan(a.matrix) | np.isnan(b.matrix)
    one, two = (
        Scores(np.where(fails, NAN, each.matrix), a.probe_ids, a.gallery_ids) for each in (a, b)
    )
    return one.genuine(), one.impostor(), two.genuine(), two.impostor()


def rank_1(scores: Scores) -> float:
    """How often the mate's best score is above everybody else's, in plain loops."""
    hits = []
    for row, probe in zip(scores.matrix, scores.probe_ids, strict=True):
        best = {name: -math.inf for name in scores.gallery_ids}
        for score, name in zip(row, scores.gallery_ids, strict=True):
            best[name] = max(best[name], -math.inf if math.isnan(score) else score)
        if probe in best:
            others = [score for name, score in best.items() if name != probe]
            hits.append(best[probe] > max(others))
    return sum(hits) / len(hits)


def leave_out_std(scores: Scores) -> float:
    """Leave each person out of the matrix, and measure what remains."""
    probes, gallery = np.array(scores.probe_ids), np.array(scores.gallery_ids)
    areas = []
    for person in {*scores.probe_ids, *scores.gallery_ids}:
        rest = scores.matrix[probes != person][:, gallery != person]
        left = Scores(rest, probes[probes != person], gallery[gallery != person])  # type: ignore[arg-type] # arrays do
        areas.append(measure_auc(left.genuine(), left.impostor()))
    return math.sqrt((len(areas) - 1) * np.var(areas))


def check(summary: Summary, scores: Scores) -> None:
    genuine, impostor = scores.genuine(), scores.impostor()
    area = estimate_auc(genuine, impostor)
    assert (summary.area.auc, summary.area.std) == (area.auc, area.std)
    assert (summary.area.low, summary.area.high) == (area.low, area.high)
    assert (summary.area.logit_low, summary.area.logit_high) == (area.logit_low, area.logit_high)
    assert (summary.area.n_genuine, summary.area.n_impostor) == (genuine.size, impostor.size)
    std = leave_out_std(scores)
    interval = _auc_interval(area.auc, std, genuine.size, impostor.size)
    assert summary.area.subject_std == pytest.approx(std, rel=1e-12)
    assert summary.area.subject_low == pytest.approx(interval.low, rel=1e-12)
    assert summary.area.subject_high == pytest.approx(interval.high, rel=1e-12)
    curve = trace_roc(genuine, impostor)
    assert summary.curve.thresholds.tolist() == curve.thresholds.tolist()
    assert summary.curve.false_matches.tolist() == curve.false_matches.tolist()
    assert summary.curve.true_matches.tolist() == curve.true_matches.tolist()
    assert summary.eer == equal_error_rate(curve)
    assert summary.d_prime == pytest.approx(d_prime(genuine, impostor), rel=1e-12)
    assert summary.fta == np.isnan(scores.matrix).all(axis=1).mean()
    assert summary.cmc.rank_1 == rank_1(scores)
    assert summary.fnmr == tuple(fnmr_at_fmr(genuine, impostor, x) for x in (0.1, 0.01, 0.001))


# Values from elsewhere.


@pytest.mark.parametrize("seed", range(5))
def test_subject_interval_of_a_difference_is_that_of_leaving_each_person_out(seed: int) -> None:
    a, b = small(seed), small(seed + 1)
    test = summarise({"b": b, "a": a}).comparisons["a", "b"]
    both = np.isnan(a.matrix) | np.isnan(b.matrix)
    areas = [
        oracle.areas_without_each(
            np.where(both, NAN, each.matrix).tolist(), list(a.probe_ids), list(a.gallery_ids)
        )
        for each in (a, b)
    ]
    variance = oracle.spread_of_jackknife([x - y for x, y in zip(*areas, strict=True)])
    assert test.subject_std is not None
    assert test.subject_std**2 == pytest.approx(float(variance), rel=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_methods_are_compared_on_what_both_acquired(seed: int) -> None:
    a, b = small(seed), small(seed + 1)
    test = summarise({"a": a, "b": b}, pairs=[("a", "b")]).comparisons["a", "b"]
    scores = pair(a, b)
    wanted = oracle.auc(*scores[:2]) - oracle.auc(*scores[2:])
    assert test.difference == float(wanted)
    assert test.std == math.sqrt(oracle.variance_of_difference(*scores))
    assert (test.z, test.p) == (compare_aucs(*scores).z, compare_aucs(*scores).p)


# Laws.


@pytest.mark.parametrize("tile", [1, 500, 1 << 19])
@pytest.mark.parametrize("images", [1, 2, 12])
def test_streamed_and_stored_scores_measure_the_same(
    images: int, tile: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    streamed, stored = sources(images)
    monkeypatch.setattr("lrsr.evaluation.scores._TILE", tile)
    check(summarise({"a": streamed}).summaries["a"], stored)
    check(summarise({"a": stored}).summaries["a"], stored)


@pytest.mark.parametrize("tile", [1, 500, 1 << 19])
def test_streamed_and_stored_methods_compare_the_same(
    tile: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("lrsr.evaluation.scores._TILE", tile)
    (a, stored_a), (b, stored_b) = sources(seed=1), sources(seed=3)
    streamed = summarise({"b": b, "a": a}).comparisons["a", "b"]
    assert streamed == summarise({"b": stored_b, "a": stored_a}).comparisons["a", "b"]
    wanted = compare_aucs(*pair(stored_a, stored_b))
    assert (streamed.difference, streamed.std, streamed.p) == (
        wanted.difference,
        wanted.std,
        wanted.p,
    )


@pytest.mark.parametrize("dtype", [np.float32, np.int16, np.float64])
def test_complete_matrices_share_their_counts_and_compare_the_same(dtype: type) -> None:
    rng = np.random.default_rng(0)
    ids = [f"p{k}" for k in range(25)]
    base, better = (
        Scores((10 * (rng.normal(size=(25, 25)) + k * np.eye(25))).astype(dtype), ids, ids)
        for k in (1, 2)
    )
    found = summarise({"base": base, "better": better})
    check(found.summaries["better"], better)
    test, wanted = found.comparisons["better", "base"], compare_aucs(*pair(better, base))
    assert (test.difference, test.std, test.low) == (wanted.difference, wanted.std, wanted.low)
    assert test.subject_std is not None
    assert test.subject_std == pytest.approx(test.std, rel=0.5)


def test_a_method_does_not_differ_from_itself_for_any_person() -> None:
    test = summarise({"a": small(1), "b": small(1)}).comparisons["b", "a"]
    assert (test.difference, test.p, test.subject_std, test.subject_low) == (0, 1, 0, 0)


def test_a_gallery_in_any_order_gives_the_same() -> None:
    (probes, probe_ids), (gallery, gallery_ids) = people(30, 2, 1), people(30, 2, 2)
    order = np.random.default_rng(0).permutation(len(gallery))
    shuffled = [gallery_ids[k] for k in order]
    a = summarise({"a": CosineScores(probes, gallery, probe_ids, gallery_ids)}).summaries["a"]
    b = summarise({"a": CosineScores(probes, gallery[order], probe_ids, shuffled)}).summaries["a"]
    assert (a.area, a.fnmr, a.eer) == (b.area, b.fnmr, b.eer)


def test_the_person_with_most_pictures_is_counted_as_exactly(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # One person beyond the number that is compared one by one, others below it.
    rng = np.random.default_rng(4)
    probe_ids, gallery_ids = ["x"] * 6 + list("abcabc"), list("axbxcx")
    matrix = rng.integers(0, 9, (12, 6)).astype(float)
    scores = Scores(matrix, probe_ids, gallery_ids)
    variance = oracle.jackknife_variance(matrix.tolist(), probe_ids, gallery_ids)
    for few in (0, 1, 8, 100):
        monkeypatch.setattr("lrsr.evaluation.subjects._FEW", few)
        std = summarise({"a": scores}).summaries["a"].area.subject_std
        assert std is not None
        assert std**2 == pytest.approx(float(variance), rel=1e-12)


def test_every_method_meets_all_before_it_where_no_pairs_are_given() -> None:
    scores = small(0)
    found = summarise({"base": scores, "b": scores, "c": scores})
    assert list(found.comparisons) == [("b", "base"), ("c", "base"), ("c", "b")]
    assert not summarise({"base": scores, "b": scores}, pairs=()).comparisons


def test_memory_does_not_grow_with_the_number_of_probes() -> None:
    def peak(count: int) -> int:
        (probes, probe_ids), (gallery, gallery_ids) = people(count, 1, 1), people(500, 1, 2)
        source = CosineScores(probes, gallery, probe_ids, gallery_ids)
        tracemalloc.start()
        summarise({"a": source}, target_fmrs=[0.01])
        return tracemalloc.get_traced_memory()[1]

    small_peak, large_peak = peak(5000), peak(20_000)
    tracemalloc.stop()
    assert large_peak < small_peak + 5_000_000 < 8 * 20_000 * 500


# Edges.


def test_without_enough_people_there_is_no_subject_interval() -> None:
    scores = Scores(np.array([[1.0, 0.0, 2], [3.0, 1, 0]]), ["a", "a"], ["a", "x", "y"])
    area = summarise({"a": scores}).summaries["a"].area
    assert (area.n_genuine, area.subject_std, area.subject_low) == (2, None, None)


def test_no_targets_give_no_operating_points() -> None:
    assert summarise({"a": small(0)}, target_fmrs=[]).summaries["a"].fnmr == ()


def test_a_target_of_one_accepts_all() -> None:
    (point,) = summarise({"a": small(0)}, target_fmrs=[1]).summaries["a"].fnmr
    assert (point.fmr, point.fnmr, point.threshold) == (1, 0, None)


# Errors.


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        pytest.param({"methods": {}}, "no method to evaluate", id="none"),
        pytest.param({"pairs": [("a", "z")]}, "no method 'z' to compare: choose of a", id="pair"),
        pytest.param({"level": 1.0}, "confidence level", id="level"),
        pytest.param({"target_fmrs": [2.0]}, "target FMR 2.0", id="target"),
        pytest.param(
            {"methods": {"a": small(0), "b": sources()[1]}}, "b has other probes", id="probes"
        ),
        pytest.param(
            {"methods": {"a": Scores(np.eye(2), list("ab"), list("cd"))}},
            "a: 0 genuine scores",
            id="no-mates",
        ),
        pytest.param(
            {"methods": {"a": Scores(np.eye(2), list("ab"), list("ac"))}},
            "a: 1 genuine and 3 impostor scores: a variance needs two",
            id="one-mate",
        ),
        pytest.param(
            {"methods": {"flat": Scores(np.ones((2, 2)), list("ab"), list("ab"))}},
            "flat: all scores of each kind are alike",
            id="flat",
        ),
        pytest.param(
            {
                "methods": {
                    "a": Scores(np.diag([1, 1, NAN, NAN]) + np.eye(4), list("abcd"), list("abcd")),
                    "b": Scores(np.diag([NAN, NAN, 1, 1]) + np.eye(4), list("abcd"), list("abcd")),
                }
            },
            "b against a: 0 genuine",
            id="nothing-in-common",
        ),
    ],
)
def test_what_cannot_be_evaluated_is_refused(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ScoreError, match=message):
        summarise(**{"methods": {"a": small(0)}, **changes})
