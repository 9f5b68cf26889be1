"""Tests of lrsr/evaluation/bootstrap.py."""

import numpy as np
import pytest
from fakes.measures import fnmr_at_fmr

from lrsr.errors import ScoreError
from lrsr.evaluation.bootstrap import (
    draw_people,
    percentiles,
    two_sided_p,
    weigh,
    weighted_means,
)
from lrsr.evaluation.delong import estimate_auc, measure_auc
from lrsr.evaluation.pairs import PairScores
from lrsr.evaluation.scores import Scores, ScoreSource
from lrsr.evaluation.subjects import Tally
from lrsr.evaluation.summary import summarise

NAN = float("nan")


def small(seed: int) -> Scores:
    """Few people, ties, missing scores, several images, distractors."""
    rng = np.random.default_rng(seed)
    matrix = rng.integers(0, 6, size=(7, 6)).astype(float)
    matrix[np.arange(7), [0, 0, 1, 2, 3, 3, 1]] += 2
    matrix[2, 4] = matrix[5, :] = NAN
    return Scores(matrix, list("aabcddb"), list("abcdxy"))


def listed(source: Scores) -> PairScores:
    """The same scores as a list of pairs."""
    left = np.repeat(source.probe_ids, len(source.gallery_ids)).tolist()
    right = list(source.gallery_ids) * len(source.probe_ids)
    return PairScores(source.matrix.ravel(), left, right)


def scored(people: int, signal: float = 1.5, seed: int = 0) -> Scores:
    names = [f"p{k:03d}" for k in range(people)]
    noise = np.random.default_rng(seed).normal(size=(people, people))
    return Scores(noise + signal * np.eye(people), names, names)


def repeated(source: Scores, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Genuine and impostor scores, each as often as its people were drawn."""
    probes, gallery, _ = source.codes
    same = probes[:, None] == gallery
    there = ~np.isnan(source.matrix)
    pairs = np.multiply.outer(times[probes], times[gallery]).astype(int)
    own = np.broadcast_to(times[probes][:, None], pairs.shape).astype(int)
    genuine = np.repeat(source.matrix[same & there], own[same & there])
    return genuine, np.repeat(source.matrix[~same & there], pairs[~same & there])


def tally_of(source: ScoreSource, draws: np.ndarray) -> Tally:
    tally = Tally(source, source.mated_scores(), draws)
    for tile in source.tiles(3):
        tally.add(tile, tile.others)
    return tally


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("as_list", [False, True], ids=["matrix", "list"])
def test_areas_are_those_of_scores_repeated_as_often_as_drawn(seed: int, as_list: bool) -> None:
    source = small(seed)
    draws = draw_people(source, 20, seed)
    found = tally_of(listed(source) if as_list else source, draws).resampled
    assert found is not None
    for area, times in zip(found.areas(), draws.T, strict=True):
        genuine, impostor = repeated(source, times)
        wanted = measure_auc(genuine, impostor) if genuine.size and impostor.size else NAN
        assert area == pytest.approx(wanted, abs=1e-12, nan_ok=True)


@pytest.mark.parametrize("target", [0.3, 0.05])
def test_fnmr_is_that_of_scores_repeated_as_often_as_drawn(target: float) -> None:
    source = scored(12)
    draws = draw_people(source, 20, 0)
    found = tally_of(source, draws).resampled
    assert found is not None
    for fnmr, times in zip(found.fnmr(target), draws.T, strict=True):
        assert fnmr == pytest.approx(fnmr_at_fmr(*repeated(source, times), target).fnmr, abs=1e-12)


def test_spread_of_the_draws_is_delongs_error_with_one_pair_each() -> None:
    source = scored(150)
    found = tally_of(source, draw_people(source, 400, 1)).resampled
    assert found is not None
    delong = estimate_auc(source.genuine(), source.impostor())
    assert np.std(found.areas()) == pytest.approx(delong.std, rel=0.2)


def test_methods_share_the_draws() -> None:
    """A rising map changes no area under any draw: the interval of the difference is 0 to 0."""
    one = scored(20)
    other = Scores(np.exp(one.matrix), one.probe_ids, one.gallery_ids)
    found = summarise({"a": one, "b": other}, bootstrap=50).comparisons["b", "a"]
    assert (found.bootstrap_low, found.bootstrap_high, found.bootstrap_p) == (0.0, 0.0, 1.0)


def test_a_method_that_is_better_for_everybody_is_told_from_the_other() -> None:
    worse = scored(60, 0.5)
    better = Scores(worse.matrix + 2 * np.eye(60), worse.probe_ids, worse.gallery_ids)
    found = summarise({"a": worse, "b": better}, bootstrap=199).comparisons["b", "a"]
    assert found.bootstrap_low is not None
    assert found.bootstrap_low > 0
    assert found.bootstrap_p == pytest.approx(2 / 200)


def test_seed_decides_and_intervals_hold_the_value() -> None:
    source = {"a": scored(30)}
    one, same, other = (summarise(source, bootstrap=60, seed=s).summaries["a"] for s in (1, 1, 2))
    assert one.area == same.area != other.area
    assert one.fnmr == same.fnmr
    assert one.area.bootstrap_low is not None
    assert one.area.bootstrap_high is not None
    assert one.area.bootstrap_low < one.area.auc < one.area.bootstrap_high


def test_without_draws_or_known_people_there_is_no_interval() -> None:
    assert summarise({"a": scored(10)}).summaries["a"].area.bootstrap_low is None
    unknown = listed(small(0))
    unnamed = PairScores(unknown.values, unknown.probe_ids, unknown.gallery_ids, people_known=False)
    area = summarise({"a": unnamed}, bootstrap=20).summaries["a"].area
    assert area.bootstrap_low is area.subject_std is None


def test_weights_are_products_over_two_people_and_single_over_one() -> None:
    draws = np.array([[2, 0], [1, 3]], dtype=np.float32)
    left, right = np.array([0, 1, 1]), np.array([1, 1, 0])
    assert weigh(draws, np.array([0, 1, 1]), 2, left, right).tolist() == [[2, 0], [3, 9]]
    assert weigh(draws, np.array([0, 0, 1]), 2, left).tolist() == [[3, 3], [1, 3]]


def test_means_are_weighted() -> None:
    draws = np.array([[2, 0], [1, 3]], dtype=np.float32)
    features = np.array([[1.0, 0.0], [0.0, 1.0]])
    found = weighted_means(draws, features, np.array([0, 1]))
    assert found == pytest.approx(np.array([[2 / 3, 0], [1 / 3, 1]]))


def test_draws_without_a_value_are_left_out() -> None:
    assert percentiles(np.array([1.0, NAN, 1.0]), 0.5) == (1.0, 1.0)
    with pytest.raises(ScoreError, match="no draw of people"):
        percentiles(np.array([NAN]), 0.5)


def test_p_is_never_less_than_the_draws_can_say() -> None:
    assert two_sided_p(np.ones(99)) == 2 / 100
    assert two_sided_p(np.array([-1.0, 1.0])) == 1.0


def test_no_draws_are_refused() -> None:
    with pytest.raises(ScoreError, match="0 draws of the bootstrap"):
        draw_people(scored(3), 0, 0)
