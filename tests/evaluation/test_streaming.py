"""Tests of lrsr/evaluation/streaming.py."""

import tracemalloc

import numpy as np
import pytest

from lrsr.errors import ScoreError
from lrsr.evaluation.delong import estimate_auc
from lrsr.evaluation.roc import trace_roc, trace_roc_from_counts
from lrsr.evaluation.streaming import count_cosines, estimate_auc_of_embeddings
from lrsr.recognition.scores import Scores


def people(count: int, images: int, seed: int) -> tuple[np.ndarray, list[str]]:
    """Embeddings of small whole numbers, so that every product is exact in any order."""
    rng = np.random.default_rng(seed)
    centres = np.random.default_rng(0).integers(-3, 4, size=(count, 1, 16))
    faces = centres + rng.integers(-3, 4, size=(count, images, 16))
    ids = np.repeat([f"p{k}" for k in range(count)], images).tolist()
    return faces.reshape(-1, 16).astype(np.float32), ids


@pytest.mark.parametrize("block_rows", [1, 7, 200])
@pytest.mark.parametrize("images", [1, 3])
def test_streamed_estimate_is_that_of_the_stored_matrix(images: int, block_rows: int) -> None:
    (probes, probe_ids), (gallery, gallery_ids) = people(30, 2, 1), people(40, images, 2)
    scores = Scores(probes @ gallery.T, probe_ids, gallery_ids)
    streamed = estimate_auc_of_embeddings(
        probes, gallery, probe_ids, gallery_ids, block_rows=block_rows
    )
    assert streamed == estimate_auc(scores.genuine(), scores.impostor())


def test_streamed_counts_trace_the_same_curve() -> None:
    (probes, probe_ids), (gallery, gallery_ids) = people(30, 2, 1), people(30, 2, 2)
    scores = Scores(probes @ gallery.T, probe_ids, gallery_ids)
    streamed = trace_roc_from_counts(count_cosines(probes, gallery, probe_ids, gallery_ids))
    stored = trace_roc(scores.genuine(), scores.impostor())
    assert (streamed.false_matches == stored.false_matches).all()
    assert (streamed.true_matches == stored.true_matches).all()


def test_a_gallery_in_any_order_gives_the_same() -> None:
    (probes, probe_ids), (gallery, gallery_ids) = people(30, 2, 1), people(30, 2, 2)
    order = np.random.default_rng(0).permutation(len(gallery))
    shuffled = [gallery_ids[k] for k in order]
    a = estimate_auc_of_embeddings(probes, gallery, probe_ids, gallery_ids)
    assert a == estimate_auc_of_embeddings(probes, gallery[order], probe_ids, shuffled)


def test_failures_to_acquire_take_part_in_no_pair() -> None:
    (probes, probe_ids), (gallery, gallery_ids) = people(30, 2, 1), people(30, 1, 2)
    probes[3], gallery[7] = np.nan, np.nan
    scores = Scores(probes @ gallery.T, probe_ids, gallery_ids)
    streamed = estimate_auc_of_embeddings(probes, gallery, probe_ids, gallery_ids)
    assert streamed == estimate_auc(scores.genuine(), scores.impostor())


def test_memory_does_not_grow_with_the_number_of_probes() -> None:
    def peak(count: int) -> int:
        (probes, probe_ids), (gallery, gallery_ids) = people(count, 1, 1), people(500, 1, 2)
        tracemalloc.start()
        count_cosines(probes, gallery, probe_ids, gallery_ids, block_rows=50)
        return tracemalloc.get_traced_memory()[1]

    small, large = peak(500), peak(4000)
    tracemalloc.stop()
    assert large < small + 3_000_000 < 4 * 4000 * 500


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        pytest.param({"probe_ids": ["p0"]}, r"\(4, 16\) for 1 ids", id="ids"),
        pytest.param(
            {"probes": np.zeros(4)}, r"probe embeddings float64 \(4,\)", id="one-dimension"
        ),
        pytest.param(
            {"gallery": np.zeros((4, 16), int)}, "gallery embeddings int64", id="integers"
        ),
        pytest.param({"gallery": np.zeros((4, 3))}, "of 16 numbers, gallery of 3", id="sizes"),
        pytest.param({"gallery": np.diag([1, np.nan, 1, 1])}, "gallery embedding 1", id="part-nan"),
        pytest.param({"gallery_ids": list("wxyz")}, "0 genuine scores", id="no-mates"),
        pytest.param({"block_rows": 0}, "block_rows 0", id="no-rows"),
        pytest.param({"level": 2.0}, "confidence level", id="level"),
    ],
)
def test_what_cannot_be_streamed_is_refused(changes: dict[str, object], message: str) -> None:
    faces, ids = people(4, 1, 1)
    given = {"probes": faces, "gallery": faces, "probe_ids": ids, "gallery_ids": ids}
    with pytest.raises(ScoreError, match=message):
        estimate_auc_of_embeddings(**{**given, **changes})  # type: ignore[arg-type] # on purpose


def test_one_genuine_pair_is_counted_but_has_no_variance() -> None:
    faces, ids = people(3, 1, 1)
    mates = [ids[0], "x", "y"]
    assert count_cosines(faces, faces, ids, mates).n_genuine == 1
    with pytest.raises(ScoreError, match="a variance needs two"):
        estimate_auc_of_embeddings(faces, faces, ids, mates)
