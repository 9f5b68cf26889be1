"""Where do small and large pictures of one person agree? In closed form, from covariances.

Either side is reduced by its own principal components and whitened; the singular vectors of what
both have in common then pair the directions (Hotelling, *Relations between two sets of variates*,
1936), and the singular values are the correlations that the likelihood ratio of
:mod:`lrsr.evaluation.paired_gaussians` weighs by. What pose and light do to probes is not shared
with the enrolled picture, and so discounted.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lrsr.errors import InputError
from lrsr.recognition.mixed_resolution import CommonSpace

_Floats = NDArray[np.float64]

_MOST_CORRELATED = 0.999
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


class Sides(NamedTuple):
    """What is learned from.

    Attributes:
        probes: n rows.
        people: ``(n,)``, whose row of the gallery shows the same person; everybody as often.
        gallery: A row a person.
    """

    probes: Whitened
    people: NDArray[np.int64]
    gallery: Whitened

    @property
    def components(self) -> int:
        """How many both sides have."""
        return int(min(self.probes.rows.shape[1], self.gallery.rows.shape[1]))


class Part(NamedTuple):
    """Most of the people, and the pictures of the others: a probe and whom it shows, row by row."""

    sides: Sides
    probes: NDArray[np.float32]
    gallery: NDArray[np.float32]


def parted(
    probes: NDArray[np.float32],
    people: NDArray[np.int64],
    gallery: NDArray[np.float32],
    most: int,
    parts: int,
) -> list[Part]:
    """Leave a part of the people out in turn, each once.

    Args:
        probes: ``(n, p)``.
        people: ``(n,)``, whose row of the gallery shows the same person.
        gallery: ``(people, q)``.
        most: Components, >= 1; see :func:`whiten`.
        parts: How many, >= 2; everybody is left out alone where there are fewer people.
    """
    found = []
    for number in range(min(parts, len(gallery))):
        out = np.arange(len(gallery)) % parts == number
        row, left = np.cumsum(~out) - 1, out[people]
        sides = Sides(whiten(probes[~left], most), row[people[~left]], whiten(gallery[~out], most))
        found.append(Part(sides, probes[left], gallery[people[left]]))
    return found


def pair(sides: Sides, components: int, dimension: int) -> CommonSpace:
    """Find the directions in which probes and enrolled pictures go together.

    Args:
        sides: What is learned from.
        components: How many of either side's are used, where there are so many.
        dimension: How many directions are kept, no more than there are components.

    Returns:
        The common space; correlations above :data:`_MOST_CORRELATED` are taken for that.

    Raises:
        InputError: There are fewer components than directions are asked for.
    """
    probes, people, gallery = sides
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
        correlations=correlations[:dimension].clip(0, _MOST_CORRELATED).astype(np.float32),
    )


def judged_by_others(space: CommonSpace, parts: Sequence[Part], components: int) -> CommonSpace:
    """Take each direction's variances and correlation from people who were not learned from.

    Fitted directions look better than they are: with few people nearly every correlation is 1, and
    the ratio says with certainty what is chance. So each part of the people is seen through the
    directions that the others give, and all parts together say how far to trust each.

    Args:
        space: Of all people, by :func:`pair`.
        parts: The same people, by :func:`parted`.
        components: As for ``space``.

    Returns:
        The same directions, of variance 1 for people not learned from, with their correlations.
    """
    moments = np.zeros((3, len(space.correlations)))
    for part in parts:
        others = pair(part.sides, components, len(space.correlations))
        x, y = others.of_probes(part.probes), others.of_gallery(part.gallery)
        moments += [(a * b).sum(axis=0, dtype=np.float64) for a, b in ((x, x), (y, y), (x, y))]
    count = sum(len(part.probes) for part in parts)
    spread = np.sqrt(moments[:2] / count)
    correlations = (moments[2] / count / spread.prod(axis=0)).clip(0, _MOST_CORRELATED)
    return replace(
        space,
        probe_map=(space.probe_map / spread[0]).astype(np.float32),
        gallery_map=(space.gallery_map / spread[1]).astype(np.float32),
        correlations=correlations.astype(np.float32),
    )
