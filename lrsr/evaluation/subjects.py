"""How sure is the AUC when persons, not pairs, were sampled?

Pairs share persons, so they are not independent. With one genuine pair per person DeLong's standard
error is right within a few per cent; with several images per person it is two to four times too
small. The jackknife leaves out whole persons, with all their pairs as probe and in the gallery, and
is right in either case (Fogliato et al., IJCV 2024; Poh et al., IEEE TPAMI 2007).
"""

import numpy as np
from numpy.typing import NDArray

from lrsr.errors import ScoreError
from lrsr.evaluation.arrays import Array
from lrsr.evaluation.bootstrap import Draws, Resampled
from lrsr.evaluation.placements import Classes, Ints, Placements
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
        draws: Of :func:`lrsr.evaluation.bootstrap.draw_people`; None: no bootstrap.

    Attributes:
        placements: The genuine scores that are compared, and the impostor scores so far.
        resampled: The same under every draw of people, if there are draws.

    Raises:
        ScoreError: There is no genuine score.
    """

    def __init__(
        self, source: ScoreSource, mated_scores: Array, draws: Draws | None = None
    ) -> None:
        compared = ~np.isnan(mated_scores)
        self.placements = Placements(mated_scores[compared])
        self._probes, self._gallery, people = source.codes
        self._crossed = source.crossed
        self._who = self._probes[source.mates[0][compared]]
        self.resampled: Resampled | None = None
        if draws is not None:
            self.resampled = Resampled(self.placements, self._who, source, draws)
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
        if self.resampled is not None:
            self.resampled.add(tile.rows, classes, others)
        rows, columns = np.divmod(others, classes.shape[1])
        self._add_side(self._probes[tile.rows], rows, classes, above)
        if self._crossed:
            self._add_side(self._gallery, columns, classes.T, above.T)
        else:
            self._add_side(self._gallery[tile.rows], rows, classes, above)
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
