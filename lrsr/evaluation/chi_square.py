"""How alike are histograms? By the chi-square distance, turned so that higher is more alike."""

from collections.abc import Sequence

import numpy as np

from lrsr.errors import ScoreError
from lrsr.evaluation.arrays import Array
from lrsr.evaluation.scores import Scores


def chi_square_scores(
    probes: Array, gallery: Array, probe_ids: Sequence[str], gallery_ids: Sequence[str]
) -> Scores:
    """Compare histograms: 1 - sum (p - g)² / (p + g) / 2, which is sum 2 p g / (p + g).

    Args:
        probes: ``(P, D)``, no number below 0, each row of sum 1; a row of NaN is a failure to
            acquire.
        gallery: ``(G, D)``, the same.
        probe_ids: P identities; text or integers.
        gallery_ids: G identities.

    Returns:
        Scores in [0, 1]: 1 for equal histograms, 0 for those that have no bin in common.

    Raises:
        ScoreError: A number is below 0, a row has another sum, the numbers of bins differ, or see
            :class:`lrsr.evaluation.scores.Scores`.

    Example:
        >>> a = np.array([[1.0, 0.0], [0.5, 0.5]])
        >>> chi_square_scores(a, a, ["ann", "bob"], ["ann", "bob"]).matrix.round(3).tolist()
        [[1.0, 0.667], [0.667, 1.0]]
    """
    rows = [_histograms(rows, name) for rows, name in ((probes, "probe"), (gallery, "gallery"))]
    if rows[0].shape[1] != rows[1].shape[1]:
        raise ScoreError(
            f"histograms of {rows[0].shape[1]} bins against {rows[1].shape[1]}: use the same"
        )
    matrix = np.empty((len(rows[0]), len(rows[1])))
    for k, probe in enumerate(rows[0]):
        both = rows[1] + probe
        shared = 2 * probe * rows[1] / np.where(both == 0, 1, both)
        matrix[k] = shared.sum(axis=1)
    return Scores(matrix, probe_ids, gallery_ids)


def _histograms(rows: Array, name: str) -> Array:
    found = np.asarray(rows, dtype=np.float64)
    whole = found[~np.isnan(found).any(axis=-1)] if found.ndim == 2 else found
    if found.ndim != 2 or (whole < 0).any() or not np.allclose(whole.sum(axis=1), 1, atol=1e-4):
        raise ScoreError(f"{name} histograms {found.shape}: wanted rows of sum 1, none below 0")
    return found
