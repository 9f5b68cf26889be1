"""Tests of lrsr/evaluation/identification.py."""

import json
from dataclasses import asdict

import numpy as np
import pytest

from lrsr.errors import ScoreError
from lrsr.evaluation.identification import identify
from lrsr.evaluation.pairs import PairScores
from lrsr.evaluation.rates import Rates
from lrsr.evaluation.scores import Scores

NAN = np.nan


def drawn(decimals: int, seed: int = 0) -> Scores:
    """Six enrolled people with two images each, twelve probes of them and nine strangers."""
    rng = np.random.default_rng(seed)
    gallery = [f"p{k % 6}" for k in range(12)]
    probes = [*gallery, *(f"stranger{k}" for k in range(9))]
    matrix = rng.normal(size=(21, 12)) + 1.2 * (np.array(probes)[:, None] == np.array(gallery))
    matrix = np.round(matrix, decimals)
    matrix[3], matrix[15] = NAN, NAN
    return Scores(matrix, probes, gallery)


def by_lists(scores: Scores, rank: int, threshold: float) -> tuple[float, float]:
    """Write every list down: TPIR and FPIR, hits with ties counted against the probe."""
    hits, named, mated, strangers = 0, 0, 0, 0
    for who, row in zip(scores.probe_ids, scores.matrix, strict=True):
        entries = [(s, g != who) for s, g in zip(row, scores.gallery_ids, strict=True) if s == s]
        entries.sort(key=lambda entry: (-entry[0], not entry[1]))  # others first among equals
        if who in scores.gallery_ids:
            mated += 1
            mates = [k for k, (_, other) in enumerate(entries) if not other]
            hits += bool(mates) and mates[0] < rank and entries[mates[0]][0] >= threshold
        else:
            strangers += 1
            named += bool(entries) and entries[0][0] >= threshold
    return hits / mated, named / strangers


@pytest.mark.parametrize("decimals", [0, 1, 9])
@pytest.mark.parametrize("rank", [1, 2, 5, 20])
def test_hits_are_those_of_lists_written_down(rank: int, decimals: int) -> None:
    scores = drawn(decimals)
    (hit,) = identify(scores, ranks=[rank]).hits
    assert hit.rate == pytest.approx(by_lists(scores, rank, -np.inf)[0])
    assert hit.low <= hit.rate <= hit.high


@pytest.mark.parametrize("decimals", [0, 1, 9])
@pytest.mark.parametrize("target", [0, 0.12, 0.3, 0.8])
@pytest.mark.parametrize("within", [1, 3])
def test_the_open_set_is_that_of_lists_written_down(
    within: int, target: float, decimals: int
) -> None:
    scores = drawn(decimals, seed=1)
    (point,) = identify(scores, target_fpirs=[target], within=within).open_set
    assert point.threshold is not None
    assert by_lists(scores, within, point.threshold) == pytest.approx((point.tpir, point.fpir))
    # the next lower threshold would name too many
    lower = max(s for s in scores.matrix[12:][~np.isnan(scores.matrix[12:])] if s < point.threshold)
    assert point.fpir <= target < by_lists(scores, within, lower)[1]


def test_with_one_image_a_person_a_hit_is_that_of_the_cmc() -> None:
    rng = np.random.default_rng(2)
    people = [f"p{k}" for k in range(30)]
    scores = Scores(rng.normal(size=(30, 30)) + np.eye(30), people, people)
    rates = Rates(scores)
    for tile in scores.tiles():
        rates.add(tile)
    cmc = rates.cmc()
    assert cmc is not None
    found = identify(scores)
    assert [hit.rate for hit in found.hits] == [cmc.hit_rate[hit.rank - 1] for hit in found.hits]
    assert (found.open_set, found.n_mated, found.n_unmated) == ((), 30, 0)


def test_two_images_of_somebody_else_are_two_places() -> None:
    scores = Scores(np.array([[0.5, 0.9, 0.8]]), ["ann"], ["ann", "bob", "bob"])
    assert [hit.rate for hit in identify(scores, ranks=[1, 2, 3]).hits] == [0, 0, 1]


def test_an_fpir_that_lets_all_strangers_pass_has_no_threshold() -> None:
    (point,) = identify(drawn(9), target_fpirs=[1]).open_set
    assert (point.threshold, point.fpir) == (None, 1)
    assert json.loads(json.dumps(asdict(point), allow_nan=False))["rank"] == 20


def test_tiles_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = identify(drawn(1))
    tiles = Scores.tiles
    monkeypatch.setattr(Scores, "tiles", lambda self: tiles(self, rows=2))
    assert identify(drawn(1)) == whole


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        pytest.param({"ranks": [0]}, "rank 0", id="rank"),
        pytest.param({"within": 0}, "rank 0", id="within"),
        pytest.param({"target_fpirs": [1.5]}, "target FPIR 1.5", id="fpir"),
    ],
)
def test_settings_out_of_range_are_refused(settings: dict[str, object], message: str) -> None:
    with pytest.raises(ScoreError, match=message):
        identify(drawn(9), **settings)  # type: ignore[arg-type]  # each is of one kind


def test_listed_pairs_are_no_gallery() -> None:
    with pytest.raises(ScoreError, match="pairs are listed"):
        identify(PairScores(np.array([0.1, 0.9]), ["a", "b"], ["a", "c"]))


def test_a_gallery_without_a_mate_is_refused() -> None:
    with pytest.raises(ScoreError, match="no probe has a mate"):
        identify(Scores(np.eye(2), ["a", "b"], ["c", "d"]))
