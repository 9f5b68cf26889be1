"""Where do small and large pictures of one person agree? In closed form, from covariances.

Either side is reduced by its own principal components and whitened; the singular vectors of what
both have in common then pair the directions (Hotelling, *Relations between two sets of variates*,
1936), and the singular values are the correlations that the likelihood ratio of
:mod:`lrsr.evaluation.paired_gaussians` weighs by. What pose and light do to probes is not shared
with the enrolled picture, and so discounted.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lrsr.errors import InputError
from lrsr.recognition.mixed_resolution import CommonSpace

_Floats = NDArray[np.float64]

MOST_CORRELATED = 0.999
"""No correlation is estimated higher: a ratio would be infinite."""


class Whitened(NamedTuple):
    """Rows of mean 0 and covariance 1 in their principal components, the largest first.

    Attributes:
        mean: ``(p,)`` of the rows before.
        basis: ``(p, K)``: rows less their mean, times this, are whitened.
        rows: ``(n, K)``.
    """

    mean: _Floats
    basis: _Floats
    rows: _Floats


def whiten(rows: NDArray[Any], most: int) -> Whitened:
    """Whiten rows in at most so many principal components, without those that hold nothing.

    Args:
        rows: ``(n, p)``.
        most: Components, >= 1.

    Example:
        >>> white = whiten(np.array([[1.0, 0.0], [3.0, 0.0], [5.0, 0.0]]), most=2)
        >>> white.rows.shape, float(white.rows.var().round(9))
        ((3, 1), 1.0)
    """
    mean = rows.mean(axis=0, dtype=np.float64)
    left, spread, right = np.linalg.svd(rows - mean, full_matrices=False)
    kept = min(most, int((spread > 1e-9 * max(spread[0], 1e-300)).sum()))
    length = np.sqrt(len(rows))
    return Whitened(mean, right[:kept].T * (length / spread[:kept]), left[:, :kept] * length)


def pair(
    probes: Whitened,
    people: NDArray[np.int64],
    gallery: Whitened,
    components: int,
    dimension: int,
) -> CommonSpace:
    """Find the directions in which probes and enrolled pictures go together.

    Args:
        probes: n rows.
        people: ``(n,)``, whose row of the gallery shows the same person; everybody as often.
        gallery: A row a person.
        components: How many of either side's are used, where there are so many.
        dimension: How many directions are kept, no more than there are components.

    Returns:
        The common space; correlations above :data:`MOST_CORRELATED` are taken for that.

    Raises:
        InputError: There are fewer components than directions are asked for.
    """
    x, y = probes.rows[:, :components], gallery.rows[:, :components]
    there = min(x.shape[1], y.shape[1])
    if not 1 <= dimension <= there:
        raise InputError(f"dimension={dimension}: wanted 1 to {there}, the components there are")
    left, correlations, right = np.linalg.svd(x.T @ y[people] / len(x))
    maps = (
        white.basis[:, :components] @ turn[:, :dimension]
        for white, turn in ((probes, left), (gallery, right.T))
    )
    probe_map, gallery_map = (each.astype(np.float32) for each in maps)
    return CommonSpace(
        probe_mean=probes.mean.astype(np.float32),
        probe_map=probe_map,
        gallery_mean=gallery.mean.astype(np.float32),
        gallery_map=gallery_map,
        correlations=correlations[:dimension].clip(0, MOST_CORRELATED).astype(np.float32),
    )
