"""What would the measures be, had other people been drawn? The bootstrap over people.

Whole people are drawn with replacement, with all their pairs, as probe and in the gallery: a
genuine pair counts as often as its person was drawn, an impostor pair as often as both of its
people together, and nobody is an impostor to a copy of himself (the two-sided bootstrap of Poh et
al., IEEE TPAMI 2007, and Fogliato et al., IJCV 2024). All methods see the same draws, so that their
differences are paired. Nothing is sorted again: a draw only changes how often each class of
:mod:`lrsr.evaluation.placements` was met.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from lrsr.errors import ScoreError
from lrsr.evaluation.arrays import Array
from lrsr.evaluation.delong import check_level
from lrsr.evaluation.placements import Classes, Placements
from lrsr.evaluation.scores import Index, ScoreSource

Floats = NDArray[np.float64]
Draws = NDArray[np.float32]

_AT_ONCE = 1 << 22
"""Weights of pairs held at once: 16 MiB."""


def draw_people(source: ScoreSource, number: int, seed: int) -> Draws:
    """Draw as many people as there are, ``number`` times.

    Args:
        source: Who is on the probes and in the gallery.
        number: Draws, B >= 1.
        seed: Equal seeds, equal draws.

    Returns:
        ``(people, B)`` how often each was drawn; people as in ``source.codes``.

    Raises:
        ScoreError: There are no draws.
    """
    if number < 1:
        raise ScoreError(f"{number} draws of the bootstrap: wanted at least 1")
    people = source.codes[2]
    drawn = np.random.default_rng(seed).multinomial(people, np.full(people, 1 / people), number)
    return np.ascontiguousarray(drawn.T, dtype=np.float32)


def weigh(
    draws: Draws, classes: Index, number: int, left: Index, right: Index | None = None
) -> Floats:
    """Count pairs by class, each as often as its people were drawn.

    Args:
        draws: ``(people, B)``.
        classes: ``(n,)`` of each pair.
        number: Of classes.
        left: ``(n,)`` person of each probe.
        right: ``(n,)`` person of each gallery image; None: the same one, as the pairs are genuine.

    Returns:
        ``(number, B)``.
    """
    total = np.zeros((number, draws.shape[1]))
    for part, weights in _weights(draws, left, right):
        places = (classes[part], np.arange(len(weights)))
        ones = np.ones(len(weights), dtype=np.float32)
        total += csr_array((ones, places), shape=(number, len(weights))) @ weights
    return total


def weighted_means(
    draws: Draws, features: Array, left: Index, right: Index | None = None
) -> Floats:
    """Average numbers of pairs, each as often as its people were drawn.

    Args:
        draws: ``(people, B)``.
        features: ``(k, n)`` finite numbers.
        left: ``(n,)`` person of each probe.
        right: ``(n,)`` as of :func:`weigh`.

    Returns:
        ``(k, B)``; NaN where a draw has no pair.
    """
    sums, total = np.zeros((len(features), draws.shape[1])), np.zeros(draws.shape[1])
    for part, weights in _weights(draws, left, right):
        sums += features[:, part] @ weights
        total += weights.sum(axis=0, dtype=np.float64)
    with np.errstate(invalid="ignore"):
        means: Floats = sums / total
    return means


def _weights(draws: Draws, left: Index, right: Index | None) -> Iterator[tuple[slice, Draws]]:
    """Yield how often some pairs were drawn, ``(pairs, B)``, and which they are."""
    step = max(1, _AT_ONCE // draws.shape[1])
    for start in range(0, left.size, step):
        part = slice(start, start + step)
        weights = draws[left[part]]
        if right is not None:
            weights *= draws[right[part]]
        yield part, weights


class Resampled:
    """Counts one method's scores tile by tile, under every draw.

    Args:
        placements: Of the genuine scores.
        who: ``(m,)`` whose each of them is.
        source: Who is on the probes and in the gallery.
        draws: Of :func:`draw_people`.
    """

    def __init__(
        self, placements: Placements, who: Index, source: ScoreSource, draws: Draws
    ) -> None:
        self._probes, self._gallery, _ = source.codes
        self._crossed, self._draws = source.crossed, draws
        own = placements.own_classes >> 1
        self._ties = np.zeros((placements.ties.size, draws.shape[1]))
        np.add.at(self._ties, own, draws[who])
        self._sizes = np.zeros((placements.sizes.size, draws.shape[1]))

    def add(self, rows: slice, classes: Classes, others: Index) -> None:
        """Count the impostor scores of a tile.

        Args:
            rows: Numbers of its rows.
            classes: ``(r, G)``.
            others: Flat places of all that is no impostor score.
        """
        kept = np.delete(np.arange(classes.size), others)
        row, column = np.divmod(kept, classes.shape[1])
        right = self._gallery[column] if self._crossed else self._gallery[rows][row]
        where = classes.reshape(-1)[kept].astype(np.intp)
        left = self._probes[rows][row]
        self._sizes += weigh(self._draws, where, len(self._sizes), left, right)

    def areas(self) -> Floats:
        """Return the AUC under each draw, ``(B,)``; NaN where a draw has no pair of a kind."""
        steps = np.zeros_like(self._sizes)
        steps[1::2] = steps[2::2] = self._ties
        above = 2 * self._ties.sum(axis=0) - np.cumsum(steps, axis=0)
        pairs = self._ties.sum(axis=0) * self._sizes.sum(axis=0)
        with np.errstate(invalid="ignore"):
            areas: Floats = (above * self._sizes).sum(axis=0) / (2 * pairs)
        return areas

    def fnmr(self, target_fmr: float) -> Floats:
        """Return the FNMR at the largest FMR not above a target under each draw, ``(B,)``.

        The threshold is found anew in every draw, so that the spread is that of both rates.
        """
        # Accepting from a genuine value on accepts the impostors at it and above it.
        accepted = np.cumsum(self._sizes[::-1], axis=0)[::-1][1::2]
        n, m = self._sizes.sum(axis=0), self._ties.sum(axis=0)
        missed = np.where(accepted > target_fmr * n, self._ties, 0.0).sum(axis=0)
        with np.errstate(invalid="ignore"):
            rate: Floats = np.where(n > 0, missed, np.nan) / m
        return rate


def percentiles(values: Floats, level: float) -> tuple[float, float]:
    """Return the middle part of what the draws gave, those without a value left out.

    Args:
        values: ``(B,)``; NaN = no value.
        level: Of the interval, in (0, 1).

    Raises:
        ScoreError: No draw has a value, or the level lies outside (0, 1).

    Example:
        >>> percentiles(np.arange(101.0), 0.5)
        (25.0, 75.0)
    """
    found, tail = values[~np.isnan(values)], (1 - check_level(level)) / 2
    if not found.size:
        raise ScoreError("no draw of people has both kinds of pairs: add people")
    low, high = np.quantile(found, [tail, 1 - tail])
    return float(low), float(high)


def two_sided_p(differences: Floats) -> float:
    """Return the p value of no difference: twice the smaller share of draws beyond 0.

    One is added to count and number, so that B draws never say less than 2 / (B + 1).
    """
    found = differences[~np.isnan(differences)]
    beyond = min(int((found <= 0).sum()), int((found >= 0).sum()))
    return min(1.0, 2 * (beyond + 1) / (found.size + 1))
