"""How sure is the AUC when persons, not pairs, were sampled?

Pairs share persons, so they are not independent. With one genuine pair per person DeLong's standard
error is right within a few per cent; with several images per person it is two to four times too
small. Both ways here draw or drop whole persons, with all their pairs as probe and in the gallery,
and are right in either case (Fogliato et al., IJCV 2024; Poh et al., IEEE TPAMI 2007). The
jackknife reads the scores tile by tile; the bootstrap needs the memory of the matrix.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from lrsr.errors import ScoreError
from lrsr.evaluation.arrays import Array, plain_number
from lrsr.evaluation.placements import Classes, Ints, Placements, class_placements
from lrsr.evaluation.scores import Index, ScoreSource, Tile

_Floats = NDArray[np.float64]

_FEW = 8
"""Genuine scores of one person up to which each is compared with the person's impostor scores."""


class Tally:
    """Counts one method's impostor scores tile by tile, for all people and without each of them.

    Leaving out a person removes rows and columns: what their genuine scores beat and what beats
    their impostor scores is subtracted, and their own overlap added back.

    Args:
        source: Who is on the probes and in the gallery.
        mated_scores: ``(q,)`` of the mated pairs; NaN where one is not to be compared.

    Attributes:
        placements: The genuine scores that are compared, and the impostor scores so far.

    Raises:
        ScoreError: There is no genuine score.
    """

    def __init__(self, source: ScoreSource, mated_scores: Array) -> None:
        compared = ~np.isnan(mated_scores)
        self.placements = Placements(mated_scores[compared])
        self._probes, self._gallery, people = source.codes
        self._who = self._probes[source.mates[0][compared]]
        self._mine = np.bincount(self._who, minlength=people)
        self._theirs, self._lost, self._overlap = (np.zeros(people, np.int64) for _ in range(3))
        # Each person's genuine scores by class, every one as two halves: one above the impostor
        # scores of lower classes, the other also above those that tie.
        self._stride = self.placements.sizes.size + 1
        entries = self._who * self._stride + self.placements.own_classes
        self._entries = np.sort(np.concatenate((entries, entries + 1)))
        self._ends = 2 * np.cumsum(self._mine)

    def add(self, tile: Tile, others: Index) -> Ints:
        """Count the impostor scores of a tile.

        Args:
            tile: The rows.
            others: ``tile.others``, and the flat places of what else is not to be compared.

        Returns:
            ``(r, G)`` twice the genuine scores above each impostor score; 0 at ``others``.

        Raises:
            ScoreError: See :meth:`Placements.classes`.
        """
        classes = self.placements.classes(tile.filled(0))
        classes.reshape(-1)[others] = self.placements.sizes.size - 1  # no genuine score is above
        self.placements.count(classes)
        self.placements.sizes[-1] -= others.size
        above = self.placements.of_impostor(classes)
        rows, columns = np.divmod(others, classes.shape[1])
        self._add_side(self._probes[tile.rows], rows, classes, above)
        self._add_side(self._gallery, columns, classes.T, above.T)
        return above

    def areas(self) -> _Floats:
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
        placements, beats = self.placements, self.placements.of_genuine
        m, n = placements.genuine.size - self._mine, placements.n_impostor - self._theirs
        if (n < 1).any():
            raise ScoreError("no impostor score is left without one of the identities: add people")
        lost = self._lost.copy()
        np.add.at(lost, self._who, beats)
        areas: _Floats = (int(beats.sum()) - lost + self._overlap) / (2.0 * m * n)
        return areas[(self._mine > 0) | (self._theirs > 0)]

    def _add_side(self, codes: Index, others: Index, classes: Classes, above: Ints) -> None:
        """Book the impostor scores of each row on its person; of each column, when transposed."""
        np.add.at(self._lost, codes, above.sum(axis=1))
        paired = classes.shape[1] - np.bincount(others, minlength=codes.size)
        np.add.at(self._theirs, codes, paired)
        np.add.at(self._overlap, codes, self._own_above(codes, classes))

    def _own_above(self, codes: Index, classes: Classes) -> Ints:
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


def jackknife_std(areas: _Floats) -> float:
    """Return the standard error of a number from its values without each of the people.

    Args:
        areas: Of :meth:`Tally.areas`, or the difference of those of two methods.
    """
    return float(np.sqrt((areas.size - 1) / areas.size * ((areas - areas.mean()) ** 2).sum()))


def bootstrap_aucs(
    methods: Mapping[str, ScoreSource], *, replicates: int = 1000, seed: int = 0
) -> dict[str, _Floats]:
    """Draw subjects with replacement, the same draws for every method, and measure each AUC.

    A subject drawn k times counts its genuine pairs k times and a pair of two subjects the product
    of their numbers; a subject is never compared with its own copy as an impostor. Needs the memory
    of the matrix.

    Args:
        methods: Scores by method, for the same probes and gallery; a failure to acquire in one
            method is missing from that method alone.
        replicates: How many draws, >= 2; a draw without any genuine or impostor pair of some
            method is left out.
        seed: Of the draws.

    Returns:
        ``(B,)`` AUCs of each method; the same place is the same draw in all. Their percentiles, and
        those of the difference of two methods, are intervals.

    Raises:
        ScoreError: No method, methods with different probes or gallery, fewer than two replicates
            (asked for or usable), or no genuine or impostor score.

    Example:
        >>> from lrsr.evaluation.scores import Scores
        >>> people = [f"p{k}" for k in range(30)]
        >>> noise = np.random.default_rng(0).normal(size=(30, 30))
        >>> drawn = bootstrap_aucs({"a": Scores(noise + np.eye(30), people, people)})["a"]
        >>> np.quantile(drawn, [0.025, 0.975]).round(2).tolist()
        [0.73, 0.88]
    """
    replicates = int(plain_number(replicates, "replicates"))
    if not methods or replicates < 2:
        raise ScoreError(f"{len(methods)} methods, {replicates} replicates: wanted >= 1 and >= 2")
    first = next(iter(methods.values()))
    for name, source in methods.items():
        first.check_same_pairs(source, name)
    probes, gallery, size = first.codes
    prepared = [_Weighted(source) for source in methods.values()]
    generator = np.random.default_rng(seed)
    draws = np.empty((len(prepared), replicates))
    for column in range(replicates):
        weights = np.bincount(generator.integers(size, size=size), minlength=size)
        pairs = np.multiply.outer(weights[probes], weights[gallery]).reshape(-1)
        draws[:, column] = [method.auc(weights, pairs) for method in prepared]
    usable = draws[:, np.isfinite(draws).all(axis=0)]
    if usable.shape[1] < 2:
        raise ScoreError("hardly any draw of subjects has genuine and impostor pairs: add people")
    return dict(zip(methods, usable, strict=True))


class _Weighted:
    """One method's scores, classed once, so that a draw costs one weighted histogram."""

    def __init__(self, source: ScoreSource) -> None:
        mated = source.mated_scores()
        placements = Placements(mated[~np.isnan(mated)])
        self.who = source.codes[0][source.mates[0][~np.isnan(mated)]]
        self.value_of, self.n_classes = placements.own_classes >> 1, placements.sizes.size
        parts = []
        for tile in source.tiles():
            parts.append(placements.classes(tile.filled(0)).reshape(-1))
            parts[-1][tile.others] = self.n_classes  # a class of its own, that is not read
        self.classes = np.concatenate(parts)
        if (self.classes == self.n_classes).all():
            raise ScoreError("0 impostor scores, wanted at least 1: give more pairs")

    def auc(self, weights: Ints, pairs: Ints) -> float:
        """Measure the AUC with a weight for each identity; NaN where nothing has weight."""
        ties = np.bincount(self.value_of, weights[self.who], minlength=self.n_classes // 2)
        sizes = np.bincount(self.classes, pairs, minlength=self.n_classes + 1)[:-1]
        whole = ties.sum() * sizes.sum()
        above = class_placements(ties.astype(np.int64))
        return float((sizes * above).sum() / (2 * whole)) if whole else float("nan")
