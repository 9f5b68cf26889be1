"""How much likelier are two rows of numbers if both are of one person? The ratio of two Gaussians.

In a space where both sides are whitened and number k of a probe's row goes with number k of the
gallery's alone (canonical correlation analysis finds it), the two hypotheses differ in the
correlations only, and the logarithm of their ratio is a sum over the numbers.
"""

from collections.abc import Sequence

import numpy as np

from lrsr.errors import ScoreError
from lrsr.evaluation.arrays import Array
from lrsr.evaluation.scores import CosineScores


def paired_log_ratios(
    probes: Array,
    gallery: Array,
    correlations: Array,
    probe_ids: Sequence[str],
    gallery_ids: Sequence[str],
) -> CosineScores:
    """Compare rows by ln p(x, y | one person) − ln p(x) p(y), all Gaussian with mean 0, variance 1.

    For a number x of the probe, y of the gallery and their correlation ρ under the first hypothesis
    it is −ln(1 − ρ²) / 2 − (ρ² (x² + y²) − 2 ρ x y) / (2 (1 − ρ²)), and the sum of these over a row
    is one inner product of rows with two more numbers: no matrix of scores is ever held.

    Args:
        probes: ``(P, D)``; a row of NaN is a failure to acquire.
        gallery: ``(G, D)``, the same.
        correlations: ``(D,)``, 0 <= ρ < 1.
        probe_ids: P identities; text or integers.
        gallery_ids: G identities.

    Returns:
        Natural logarithms; 0 where the pair says nothing.

    Raises:
        ScoreError: A correlation is out of its range, the numbers of columns differ, or see
            :class:`lrsr.evaluation.scores.CosineScores`.

    Example:
        >>> one = np.array([[2.0]])
        >>> scores = paired_log_ratios(one, np.array([[2.0], [-2.0]]), np.array([0.5]), "a", "ab")
        >>> scores.rows(0, 1).round(3).tolist()     # 0.144 + 2 / 1.5 and 0.144 - 6 / 1.5
        [[1.477, -3.856]]
    """
    rho = np.asarray(correlations, dtype=np.float64)
    widths = np.shape(probes)[1:], np.shape(gallery)[1:], rho.shape
    if rho.ndim != 1 or len(set(widths)) > 1:
        raise ScoreError(f"probes, gallery and correlations have {widths} numbers: wanted as many")
    if not ((rho >= 0) & (rho < 1)).all():
        raise ScoreError(f"correlations {rho.min():.4g} to {rho.max():.4g}: wanted 0 <= ρ < 1")
    left = 1 - rho**2
    x, y = (np.asarray(rows, dtype=np.float64) for rows in (probes, gallery))
    alone = [-np.square(rows) @ (rho**2 / left / 2) for rows in (x, y)]
    alone[0] = alone[0] - np.log(left).sum() / 2
    ones = [np.where(np.isnan(one), np.nan, 1.0) for one in alone]
    return CosineScores(
        np.column_stack([x * (rho / left), alone[0], ones[0]]),
        np.column_stack([y, ones[1], alone[1]]),
        probe_ids,
        gallery_ids,
    )
