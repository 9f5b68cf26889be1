"""How sure is the AUC when persons, not pairs, were sampled?

Pairs share persons, so they are not independent. With one genuine pair per person DeLong's standard
error is right within a few per cent; with several images per person it is two to four times too
small. Both ways here draw or drop whole persons, with all their pairs as probe and in the gallery,
and are right in either case (Fogliato et al., IJCV 2024; Poh et al., IEEE TPAMI 2007). The
jackknife reads the scores tile by tile; the bootstrap wants the matrix.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lrsr.errors import ScoreError
from lrsr.evaluation.arrays import Array, check_scores
from lrsr.evaluation.delong import AucEstimate, auc_interval, auc_of_counts, normal_quantile
from lrsr.evaluation.placements import Genuine, Ints, class_placements
from lrsr.evaluation.scores import Index, Scores, ScoreSource, Tile

Floats = NDArray[np.float64]

_FEW = 8
"""Genuine scores of one person up to which each is compared with the person's impostor scores."""


@dataclass(frozen=True)
class BootstrapInterval:
    """What the replicates of a bootstrap say about one number; every field goes to JSON.

    Attributes:
        value: The number measured on all subjects.
        std: Standard deviation of the replicates.
        low: Lower percentile.
        high: Upper percentile.
        level: Confidence level, between the percentiles.
        replicates: How many replicates there were.
    """

    value: float
    std: float
    low: float
    high: float
    level: float
    replicates: int


@dataclass(frozen=True, eq=False)
class SubjectBootstrap:
    """AUCs of several methods, measured on the same draws of subjects.

    Attributes:
        measured: AUC of each method on all subjects.
        replicates: ``(B,)`` AUCs of each method; the same place is the same draw in all methods.
        level: Confidence level of the intervals.
    """

    measured: Mapping[str, float]
    replicates: Mapping[str, Floats]
    level: float

    def auc(self, method: str) -> BootstrapInterval:
        """Return the percentile interval of one method's AUC."""
        return self._interval(self.measured[method], self.replicates[method])

    def difference(self, a: str, b: str) -> BootstrapInterval:
        """Return the percentile interval of AUC of a minus AUC of b, paired."""
        return self._interval(
            self.measured[a] - self.measured[b], self.replicates[a] - self.replicates[b]
        )

    def _interval(self, value: float, draws: Floats) -> BootstrapInterval:
        tail = (1 - self.level) / 2
        low, high = np.quantile(draws, [tail, 1 - tail])
        return BootstrapInterval(
            value, float(draws.std(ddof=1)), float(low), float(high), self.level, draws.size
        )


class Tally:
    """Counts one method's impostor scores tile by tile, for all people and without each of them.

    Leaving out a person removes rows and columns: what their genuine scores beat and what beats
    their impostor scores is subtracted, and their own overlap added back.

    Args:
        source: Who is on the probes and in the gallery.
        mated_scores: ``(q,)`` of the mated pairs; NaN where one is not to be compared.

    Attributes:
        genuine: The genuine scores that are compared.
        counts: Of the impostor scores so far.

    Raises:
        ScoreError: There is no genuine score.
    """

    def __init__(self, source: ScoreSource, mated_scores: Array) -> None:
        compared = ~np.isnan(mated_scores)
        self.genuine = Genuine(mated_scores[compared])
        self.counts = self.genuine.no_counts()
        self._probes, self._gallery, people = source.codes
        self._who = self._probes[source.mates[0][compared]]
        self._mine = np.bincount(self._who, minlength=people)
        self._theirs, self._lost, self._overlap = (np.zeros(people, np.int64) for _ in range(3))
        # Each person's genuine scores by class, every one as two halves: one above the impostor
        # scores of lower classes, the other also above those that tie.
        self._stride = 2 * self.genuine.values.size + 2
        entries = self._who * self._stride + self.genuine.own_classes
        self._entries = np.sort(np.concatenate((entries, entries + 1)))
        self._ends = 2 * np.cumsum(self._mine)

    def add(self, tile: Tile, scores: Array, others: Index) -> Ints:
        """Count the impostor scores of a tile.

        Args:
            tile: The rows.
            scores: ``(r, G)`` those of the tile, any number in the place of NaN.
            others: Flat places of the pairs that are no impostor pairs or are not compared.

        Returns:
            ``(r, G)`` twice the genuine scores above each impostor score; 0 at ``others``.

        Raises:
            ScoreError: See :meth:`Genuine.classes`.
        """
        classes = self.genuine.classes(scores)
        none_above = 2 * self.genuine.values.size
        classes.reshape(-1)[others] = none_above
        counts = self.genuine.counts(classes)
        counts.sizes[none_above] -= others.size
        self.counts += counts
        placements = self.genuine.placements(classes)
        rows, columns = np.divmod(others, scores.shape[1])
        self._add_side(self._probes[tile.rows], rows, classes, placements)
        self._add_side(self._gallery, columns, classes.T, placements.T)
        return placements

    def areas(self) -> Floats:
        """Return the AUC without each person that has a score, by person.

        Raises:
            ScoreError: Fewer than two people have a genuine score, or too few impostor scores are
                left without one of them.
        """
        if np.count_nonzero(self._mine) < 2:
            raise ScoreError(
                f"{np.count_nonzero(self._mine)} identities with a genuine score: leaving one out "
                "needs two"
            )
        beats = self.genuine.beats(self.counts)
        lost = self._lost.copy()
        np.add.at(lost, self._who, beats)
        m, n = self.genuine.scores.size - self._mine, self.counts.n_impostor - self._theirs
        if (n < 1).any():
            raise ScoreError("no impostor score is left without one of the identities: add people")
        areas: Floats = (int(beats.sum()) - lost + self._overlap) / (2.0 * m * n)
        return areas[(self._mine > 0) | (self._theirs > 0)]

    def _add_side(
        self, codes: Index, others: Index, classes: NDArray[Any], placements: Ints
    ) -> None:
        """Book the impostor scores of each row on its person; of each column, when transposed."""
        np.add.at(self._lost, codes, placements.sum(axis=1))
        paired = classes.shape[1] - np.bincount(others, minlength=codes.size)
        np.add.at(self._theirs, codes, paired)
        np.add.at(self._overlap, codes, self._own_above(codes, classes))

    def _own_above(self, codes: Index, classes: NDArray[Any]) -> Ints:
        """Return twice the genuine scores of each row's person above the impostor scores there."""
        found = np.zeros(codes.size, dtype=np.int64)
        number, key = 2 * self._mine[codes], codes * self._stride
        few = number <= 2 * _FEW
        for which in range(int(number[few].max(initial=0))):
            rows = np.flatnonzero(few & (number > which))
            own = self._entries[self._ends[codes[rows]] - 1 - which] - key[rows]
            part = classes if rows.size == codes.size else classes[rows]
            found[rows] += np.count_nonzero(own.astype(classes.dtype)[:, None] > part, axis=1)
        rows = np.flatnonzero(~few)
        at_or_below = np.searchsorted(self._entries, key[rows, None] + classes[rows], side="right")
        found[rows] = (self._ends[codes[rows], None] - at_or_below).sum(axis=1)
        return found


def jackknife_std(areas: Floats) -> float:
    """Return the standard error of a number from its values without each of the people.

    Args:
        areas: Of :meth:`Tally.areas`, or the difference of those of two methods.
    """
    return float(np.sqrt((areas.size - 1) / areas.size * ((areas - areas.mean()) ** 2).sum()))


def jackknife_auc(source: ScoreSource, level: float = 0.95) -> AucEstimate:
    """Estimate the AUC with a standard error that leaves out one identity at a time.

    Args:
        source: Probes × gallery.
        level: Confidence level of the Wald and logit intervals.

    Raises:
        ScoreError: Fewer than two identities with a genuine score, too few impostor scores to
            leave one identity out, or a level outside (0, 1).
    """
    normal_quantile(level)
    tally = Tally(source, source.mated_scores())
    for tile in source.tiles():
        tally.add(tile, tile.filled, np.union1d(tile.mates, tile.absent))
    std, counts = jackknife_std(tally.areas()), tally.counts
    return auc_interval(auc_of_counts(counts), std, counts.n_genuine, counts.n_impostor, level)


def bootstrap_aucs(
    methods: Mapping[str, Scores], *, replicates: int = 1000, seed: int = 0, level: float = 0.95
) -> SubjectBootstrap:
    """Draw subjects with replacement, the same draws for every method, and measure each AUC.

    A subject drawn k times counts its genuine pairs k times and a pair of two subjects the product
    of their numbers; a subject is never compared with its own copy as an impostor.

    Args:
        methods: Scores by method, for the same probes and gallery; a failure to acquire in one
            method is missing from that method alone.
        replicates: How many draws, >= 2; a draw without any genuine or impostor pair of some
            method is left out.
        seed: Of the draws.
        level: Confidence level of the intervals.

    Raises:
        ScoreError: No method, methods with different probes or gallery, fewer than two replicates
            (asked for or usable), no genuine or impostor score, or a level outside (0, 1).
    """
    normal_quantile(level)
    if not methods or replicates < 2:
        raise ScoreError(f"{len(methods)} methods, {replicates} replicates: wanted >= 1 and >= 2")
    first = next(iter(methods.values()))
    for name, scores in methods.items():
        first.check_same_pairs(scores, name)
    probe_codes, gallery_codes, size = first.codes
    prepared = {name: _Weighted(scores) for name, scores in methods.items()}
    generator = np.random.default_rng(seed)
    draws = np.empty((len(prepared), replicates))
    for column in range(replicates):
        weights = np.bincount(generator.integers(size, size=size), minlength=size)
        pairs = np.multiply.outer(weights[probe_codes], weights[gallery_codes]).astype(np.float64)
        for row, method in enumerate(prepared.values()):
            draws[row, column] = method.auc(weights, pairs)
    usable = draws[:, np.isfinite(draws).all(axis=0)]
    if usable.shape[1] < 2:
        raise ScoreError("hardly any draw of subjects has genuine and impostor pairs: add people")
    everyone = np.ones(size, dtype=np.int64)
    whole = np.ones(first.matrix.shape)
    measured = {name: method.auc(everyone, whole) for name, method in prepared.items()}
    return SubjectBootstrap(measured, dict(zip(prepared, usable, strict=True)), level)


class _Weighted:
    """One method's scores, classed once, so that a draw costs one weighted histogram."""

    def __init__(self, scores: Scores) -> None:
        genuine = Genuine(scores.genuine())
        self.classes = genuine.classes(check_scores(scores.impostor(), "impostor"))
        acquired = ~np.isnan(scores.matrix)
        self.is_impostor = ~scores.mated & acquired
        self.value_of = genuine.own_classes >> 1
        self.who = scores.codes[0][np.nonzero(scores.mated & acquired)[0]]
        self.n_values = genuine.values.size

    def auc(self, weights: Ints, pairs: Floats) -> float:
        """Measure the AUC with a weight for each identity; NaN where nothing has weight."""
        ties = np.bincount(self.value_of, weights[self.who], minlength=self.n_values)
        per_class = np.bincount(
            self.classes, pairs[self.is_impostor], minlength=2 * self.n_values + 1
        )
        whole = ties.sum() * per_class.sum()
        above = class_placements(ties.astype(np.int64))
        return float((per_class * above).sum() / (2 * whole)) if whole else float("nan")
