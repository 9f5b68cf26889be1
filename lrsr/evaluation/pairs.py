"""How alike are the pairs of a list? For protocols that compare only some probes and images."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from lrsr.errors import ScoreError
from lrsr.evaluation.arrays import Array, plain_array
from lrsr.evaluation.scores import Index, ScoreSource, Tile

_TILE = 1 << 18


@dataclass(frozen=True, eq=False)
class PairScores(ScoreSource):
    """A list of pairs and their scores; a tile of it has one column, whose pictures change.

    Attributes:
        values: ``(n,)`` real scores, NaN = failure to acquire, no infinities.
        probe_ids: n identities, of each pair's probe; text or integers.
        gallery_ids: n identities, of each pair's gallery image; equal = mated.
        people_known: Equal identities of two pairs are the same person. False where only genuine
            and impostor scores came: then there is no interval over people.

    Raises:
        ScoreError: The lengths differ, there is no pair, the numbers are not plain and real, a
            score is infinite, or an identity is neither text nor an integer.

    Example:
        >>> values = np.array([0.9, 0.1, 0.2])
        >>> pairs = PairScores(values, ["ann", "ann", "bob"], ["ann", "bob", "cy"])
        >>> pairs.genuine().tolist(), pairs.impostor().tolist()
        ([0.9], [0.1, 0.2])
    """

    crossed: ClassVar[bool] = False
    values: Array
    probe_ids: Sequence[str]
    gallery_ids: Sequence[str]
    people_known: bool = True

    def __post_init__(self) -> None:
        values = plain_array(self.values, "scores of the pairs")
        super().__post_init__()
        object.__setattr__(self, "values", values)
        if (
            not values.shape == (len(self.probe_ids),) == (len(self.gallery_ids),)
            or not values.size
        ):
            raise ScoreError(
                f"{values.shape} scores for {len(self.probe_ids)} probes and "
                f"{len(self.gallery_ids)} gallery images: wanted one of each for every pair"
            )
        if np.isinf(values).any():
            first = int(np.argmax(np.isinf(values)))
            raise ScoreError(f"score of pair {first} is {values[first]}: scores must be finite")

    @cached_property
    def mates(self) -> tuple[Index, Index]:
        """Numbers (rising) of the mated pairs; all are of column 0."""
        probes, gallery, _ = self.codes
        rows = np.flatnonzero(probes == gallery)
        return rows, np.zeros_like(rows)

    def rows(self, start: int, stop: int) -> Array:
        """Return scores ``(stop - start, 1)``; a view."""
        return self.values[start:stop, None]

    def tiles(self, rows: int | None = None) -> Iterator[Tile]:
        """Yield the whole list, some pairs at a time.

        Args:
            rows: How many, >= 1.

        Raises:
            ScoreError: ``rows`` is less than 1.
        """
        rows = _TILE if rows is None else rows
        if rows < 1:
            raise ScoreError(f"tiles of {rows} rows: wanted at least 1")
        mates = self.mates[0]
        for first in range(0, self.values.size, rows):
            own = slice(*np.searchsorted(mates, (first, first + rows)))
            yield Tile(first, self.rows(first, first + rows), mates[own] - first)

    def mated_scores(self) -> Array:
        """Return the score of each of :attr:`mates`, ``(q,)``, NaN among them."""
        return self.values[self.mates[0]]

    @property
    def complete(self) -> bool:
        """Whether every pair has a score."""
        return not np.isnan(self.values).any()

    def restricted(self, people: Collection[str]) -> "PairScores":
        """Return the scores of pairs both of whose people are among these.

        Raises:
            ScoreError: There is no such pair.
        """
        probes, gallery = self._kept(people)
        kept = probes & gallery if self.people_known else probes
        ids = np.array(self.probe_ids)[kept], np.array(self.gallery_ids)[kept]
        left, right = (list(map(str, one)) for one in ids)
        return PairScores(self.values[kept], left, right, self.people_known)
