"""How large is the AUC of a hundred million pairs, whose scores nobody wants to store?

Rows of the cosine matrix are made, counted and forgotten, block by block.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lrsr.errors import ScoreError
from lrsr.evaluation.counting import Counter, Counts
from lrsr.evaluation.delong import AucEstimate, estimate_auc_from_counts

Embeddings = NDArray[Any]


def count_cosines(
    probes: Embeddings,
    gallery: Embeddings,
    probe_ids: Sequence[str],
    gallery_ids: Sequence[str],
    *,
    block_rows: int = 200,
) -> Counts:
    """Count the cosine scores of all probes with all gallery images without storing them.

    Args:
        probes: ``(P, D)`` L2-normalised embeddings, float32 or float64; a row of NaN is a failure
            to acquire and takes part in no pair.
        gallery: ``(G, D)`` the same.
        probe_ids: P identities.
        gallery_ids: G identities.
        block_rows: Probes at once; memory over the inputs is about ``4 block_rows G`` bytes and
            a few MiB.

    Returns:
        The counts that curves and areas are made of. A score may differ in its last bit from that
        of another block size, as with any matrix product.

    Raises:
        ScoreError: Shapes that do not fit the ids or each other, a partly NaN or an infinite
            embedding, no genuine pair, or ``block_rows`` below 1.
    """
    if block_rows < 1:
        raise ScoreError(f"block_rows {block_rows}: wanted at least 1")
    probes, probe_names = _acquired(probes, probe_ids, "probe")
    gallery, gallery_names = _acquired(gallery, gallery_ids, "gallery")
    if probes.shape[1] != gallery.shape[1]:
        raise ScoreError(
            f"probe embeddings of {probes.shape[1]} numbers, gallery of {gallery.shape[1]}: "
            "use one model for both"
        )
    rows, columns = _mates(probe_names, gallery_names)
    genuine = np.empty(rows.size, dtype=np.result_type(probes, gallery))
    for start in range(0, rows.size, block_rows):
        part = slice(start, start + block_rows)
        genuine[part] = (probes[rows[part]] * gallery[columns[part]]).sum(axis=1)
    counter = Counter(genuine)
    across = np.ascontiguousarray(gallery.T)
    for start in range(0, len(probes), block_rows):
        block = probes[start : start + block_rows] @ across
        first, last = np.searchsorted(rows, (start, start + len(block)))
        mates = (rows[first:last] - start) * len(gallery) + columns[first:last]
        counter.add(_without(block.reshape(-1), mates))
    return counter.counts()


def estimate_auc_of_embeddings(
    probes: Embeddings,
    gallery: Embeddings,
    probe_ids: Sequence[str],
    gallery_ids: Sequence[str],
    *,
    block_rows: int = 200,
    level: float = 0.95,
) -> AucEstimate:
    """Estimate the AUC of cosine scores that are never stored; see :func:`count_cosines`.

    Raises:
        ScoreError: As :func:`count_cosines`; fewer than two genuine or impostor pairs; a level
            outside (0, 1).
    """
    counts = count_cosines(probes, gallery, probe_ids, gallery_ids, block_rows=block_rows)
    return estimate_auc_from_counts(counts, level)


def _acquired(
    embeddings: Embeddings, ids: Sequence[str], name: str
) -> tuple[Embeddings, NDArray[np.str_]]:
    """Check embeddings and drop the rows without one.

    Raises:
        ScoreError: The shape does not fit, or a row is infinite or partly NaN.
    """
    if embeddings.ndim != 2 or len(embeddings) != len(ids) or embeddings.dtype.kind != "f":
        raise ScoreError(
            f"{name} embeddings {embeddings.dtype} {embeddings.shape} for {len(ids)} ids: "
            "wanted (ids, D) floating point"
        )
    missing = np.isnan(embeddings).all(axis=1)
    broken = ~np.isfinite(embeddings).all(axis=1) & ~missing
    if broken.any():
        raise ScoreError(f"{name} embedding {int(np.argmax(broken))} holds a NaN or an infinity")
    names = np.asarray([str(name) for name in ids])
    if missing.any():
        return embeddings[~missing], names[~missing]
    return embeddings, names


def _mates(
    probe_names: NDArray[np.str_], gallery_names: NDArray[np.str_]
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return rows (rising) and columns of the mated pairs, without a matrix of pairs."""
    order = np.argsort(gallery_names, kind="stable")
    ordered = gallery_names[order]
    first = np.searchsorted(ordered, probe_names, side="left")
    number = np.searchsorted(ordered, probe_names, side="right") - first
    rows = np.repeat(np.arange(probe_names.size), number)
    within = np.arange(rows.size) - np.repeat(np.cumsum(number) - number, number)
    return rows, order[first[rows] + within]


def _without(scores: NDArray[Any], places: NDArray[np.intp]) -> NDArray[Any]:
    """Drop some scores of a block without copying it: survivors of the tail take their places."""
    kept = scores.size - places.size
    tail = np.ones(places.size, dtype=bool)
    tail[places[places >= kept] - kept] = False
    scores[places[places < kept]] = scores[kept:][tail]
    return scores[:kept]
