"""Do errors go away when the worst pictures are refused? Error against discarded share.

The error-versus-discard characteristic of Grother and Tabassi (IEEE TPAMI 29, 2007; ISO/IEC
29794-1): at a fixed threshold, the FNMR of what is left after discarding the pairs whose probe has
the lowest quality. A measure of quality that knows nothing leaves it level.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lrsr.errors import ScoreError
from lrsr.evaluation.arrays import plain_array
from lrsr.evaluation.roc import wilson_interval

_Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class DiscardCurve:
    """FNMR against the share of pairs that were discarded.

    Attributes:
        discarded: ``(k,)`` share of genuine pairs discarded, rising from 0; where several have the
            same quality, all of them go at once.
        fnmr: ``(k,)`` of those left.
        low: ``(k,)`` lower end of Wilson's interval.
        high: ``(k,)`` upper end.
    """

    discarded: _Floats
    fnmr: _Floats
    low: _Floats
    high: _Floats


def error_against_discard(
    genuine: ArrayLike,
    quality: ArrayLike,
    threshold: float,
    *,
    largest: float = 0.5,
    level: float = 0.95,
) -> DiscardCurve:
    """Trace the FNMR while pairs of low quality are discarded.

    Args:
        genuine: ``(m,)`` scores of mated pairs; NaN (a failure to acquire) is a non-match here.
        quality: ``(m,)`` of their probes, higher = better; NaN is worse than any.
        threshold: Match: score >= threshold.
        largest: Share up to which pairs are discarded, [0, 1).
        level: Of Wilson's intervals.

    Raises:
        ScoreError: The lengths differ, or there is no pair.

    Example:
        >>> error_against_discard([0.1, 0.9, 0.8, 0.7], [1, 2, 3, 4], 0.5).fnmr.tolist()
        [0.25, 0.0, 0.0]
    """
    scores = plain_array(genuine, "genuine scores").astype(np.float64)
    worth = plain_array(quality, "qualities").astype(np.float64)
    if scores.shape != worth.shape or scores.ndim != 1 or not scores.size:
        raise ScoreError(
            f"{scores.shape} genuine scores and {worth.shape} qualities: wanted one of each a pair"
        )
    worth = np.where(np.isnan(worth), -np.inf, worth)
    values, where = np.unique(worth, return_inverse=True)
    gone = np.append(0, np.cumsum(np.bincount(where)))[: values.size]
    missed = np.bincount(where, ~(scores >= threshold), minlength=values.size)
    left = np.cumsum(missed[::-1])[::-1]
    kept = gone <= largest * scores.size
    gone, left = gone[kept], left[kept]
    rest = scores.size - gone
    limits = [wilson_interval(int(k), int(n), level) for k, n in zip(left, rest, strict=True)]
    low, high = (np.array([float(one[end]) for one in limits]) for end in (0, 1))
    return DiscardCurve(gone / scores.size, left / rest, low, high)
