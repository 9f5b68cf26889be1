"""How alike is every probe to every gallery image, and who is who? What evaluation is fed with.

:class:`Scores` holds the matrix, :class:`CosineScores` only the embeddings; every measure takes
either. Both hand out rows of the matrix and the scores of the mated pairs, so that an evaluation of
ten thousand people need never hold the hundred million scores.
"""

from abc import ABC, abstractmethod
from collections.abc import Collection, Iterable, Iterator, Sequence, Set
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from lrsr.errors import ScoreError
from lrsr.evaluation.arrays import Array, plain_array

_Flags = NDArray[np.bool_]
Index = NDArray[np.intp]

_TILE = 1 << 18
"""Scores in a tile: 2 MiB of float64, and as much for each temporary."""
_COLUMNS = 2048


@dataclass(frozen=True, eq=False)
class Tile:
    """Some rows of the score matrix.

    Attributes:
        first: Number of the first row.
        scores: ``(r, G)``, NaN = failure to acquire.
        mates: ``(q,)`` flat places in ``scores`` of the mated pairs, rising.
    """

    first: int
    scores: Array
    mates: Index

    @property
    def rows(self) -> slice:
        """The rows' numbers."""
        return slice(self.first, self.first + len(self.scores))

    @cached_property
    def absent(self) -> _Flags:
        """``(r, G)`` where there is no score."""
        return np.isnan(self.scores)

    @cached_property
    def others(self) -> Index:
        """Flat places of all that is no impostor score: mates and failures; rising."""
        return np.union1d(self.mates, np.flatnonzero(self.absent))

    @cached_property
    def impostors(self) -> Array:
        """``(n,)`` the impostor scores, row by row."""
        return np.delete(self.scores, self.others)

    def filled(self, value: float) -> Array:
        """Return ``(r, G)`` scores with a number in the place of NaN."""
        return np.where(self.absent, value, self.scores) if self.absent.any() else self.scores


class ScoreSource(ABC):
    """Scores of P probes with G gallery images, higher = more alike, NaN = failure to acquire.

    A failure to acquire says that one of two images gave no embedding: never compared, but counted.

    Attributes:
        crossed: Every probe is compared with the whole gallery; else row and column k are pair k.
        people_known: The identities are those of people; else of unnamed pairs.
        probe_ids: P identities, one a row.
        gallery_ids: G identities, one a column.
    """

    crossed: ClassVar[bool] = True
    people_known: bool = True
    probe_ids: Sequence[str]
    gallery_ids: Sequence[str]

    def __post_init__(self) -> None:
        for field in ("probe_ids", "gallery_ids"):
            object.__setattr__(self, field, _identities(getattr(self, field), field))

    @abstractmethod
    def rows(self, start: int, stop: int) -> Array:
        """Return rows of the score matrix, ``(stop - start, G)``."""

    @abstractmethod
    def mated_scores(self) -> Array:
        """Return the score of each of :attr:`mates`, ``(q,)``, NaN among them."""

    @property
    @abstractmethod
    def complete(self) -> bool:
        """Whether every pair has a score."""

    @abstractmethod
    def restricted(self, people: Collection[str]) -> Self:
        """Return the scores of pairs both of whose people are among these."""

    def _kept(self, people: Collection[str]) -> tuple[_Flags, _Flags]:
        """Return which rows and columns show these people."""
        chosen = list(people)
        return np.isin(self.probe_ids, chosen), np.isin(self.gallery_ids, chosen)

    @property
    def n_pairs(self) -> int:
        """How many pairs there are, failures among them."""
        return len(self.probe_ids) * (len(self.gallery_ids) if self.crossed else 1)

    @cached_property
    def codes(self) -> tuple[Index, Index, int]:
        """The identities as numbers: of the rows, of the columns, and how many there are."""
        people, codes = np.unique([*self.probe_ids, *self.gallery_ids], return_inverse=True)
        return codes[: len(self.probe_ids)], codes[len(self.probe_ids) :], people.size

    @cached_property
    def mates(self) -> tuple[Index, Index]:
        """Rows (rising) and columns of the mated pairs."""
        probes, gallery, _ = self.codes
        order = np.argsort(gallery, kind="stable")
        first = np.searchsorted(gallery[order], probes, side="left")
        number = np.searchsorted(gallery[order], probes, side="right") - first
        rows = np.repeat(np.arange(probes.size), number)
        within = np.arange(rows.size) - np.repeat(np.cumsum(number) - number, number)
        return rows, order[first[rows] + within]

    def tiles(self, rows: int | None = None) -> Iterator[Tile]:
        """Yield the whole matrix, some rows at a time.

        Args:
            rows: How many, >= 1; None: as many as make ``_TILE`` scores.

        Raises:
            ScoreError: ``rows`` is less than 1.
        """
        width = len(self.gallery_ids)
        rows = max(1, _TILE // width) if rows is None else rows
        if rows < 1:
            raise ScoreError(f"tiles of {rows} rows: wanted at least 1")
        mate_rows, mate_columns = self.mates
        for first in range(0, len(self.probe_ids), rows):
            scores = self.rows(first, min(first + rows, len(self.probe_ids)))
            own = slice(*np.searchsorted(mate_rows, (first, first + rows)))
            yield Tile(first, scores, (mate_rows[own] - first) * width + mate_columns[own])

    def genuine(self) -> Array:
        """Return the scores of mated pairs ``(m,)``, row by row, without failures."""
        scores = self.mated_scores()
        return scores[~np.isnan(scores)]

    def impostor(self) -> Array:
        """Return the scores of non-mated pairs ``(n,)``, row by row, without failures."""
        return np.concatenate([tile.impostors for tile in self.tiles()])

    def check_same_pairs(self, other: "ScoreSource", name: str) -> None:
        """Refuse another method's scores of other probes or another gallery.

        Raises:
            ScoreError: The message calls the other method ``name``.
        """
        if (self.probe_ids, self.gallery_ids) != (other.probe_ids, other.gallery_ids):
            raise ScoreError(
                f"{name} has other probes or another gallery: a paired test wants the same pairs "
                "in the same order"
            )


@dataclass(frozen=True, eq=False)
class Scores(ScoreSource):
    """A matrix of scores.

    Attributes:
        matrix: ``(P, G)`` real scores, NaN = failure to acquire, no infinities.
        probe_ids: P identities, one per row; text or integers.
        gallery_ids: G identities, one per column.

    Raises:
        ScoreError: The shape does not fit the ids, the numbers are not plain and real, a score is
            infinite, or an identity is neither text nor an integer.

    Example:
        >>> people = ["ann", "bob"]
        >>> scores = Scores(np.array([[0.9, 0.1], [np.nan, np.nan]]), people, people)
        >>> scores.genuine().tolist(), scores.impostor().tolist(), scores.complete
        ([0.9], [0.1], False)
    """

    matrix: Array
    probe_ids: Sequence[str]
    gallery_ids: Sequence[str]

    def __post_init__(self) -> None:
        matrix = plain_array(self.matrix, "scores of the matrix")
        super().__post_init__()
        object.__setattr__(self, "matrix", matrix)
        if matrix.shape != (len(self.probe_ids), len(self.gallery_ids)) or matrix.size == 0:
            raise ScoreError(
                f"score matrix {matrix.shape} for {len(self.probe_ids)} probes and "
                f"{len(self.gallery_ids)} gallery images: wanted one row and one column each"
            )
        infinite = np.isinf(matrix)
        if infinite.any():
            row, column = (int(index) for index in np.argwhere(infinite)[0])
            raise ScoreError(
                f"score of probe {row} ({self.probe_ids[row]}) and gallery image {column} "
                f"({self.gallery_ids[column]}) is {matrix[row, column]}: scores must be finite"
            )

    def rows(self, start: int, stop: int) -> Array:
        """Return rows of the score matrix, ``(stop - start, G)``; a view."""
        return self.matrix[start:stop]

    def mated_scores(self) -> Array:
        """Return the score of each of :attr:`mates`, ``(q,)``, NaN among them."""
        return self.matrix[self.mates]

    def restricted(self, people: Collection[str]) -> "Scores":
        """Return the scores of pairs both of whose people are among these.

        Raises:
            ScoreError: There is no such pair.
        """
        rows, columns = self._kept(people)
        ids = np.array(self.probe_ids)[rows], np.array(self.gallery_ids)[columns]
        return Scores(self.matrix[np.ix_(rows, columns)], *(list(map(str, one)) for one in ids))

    @property
    def complete(self) -> bool:
        """Whether every pair has a score."""
        return not np.isnan(self.matrix).any()


@dataclass(frozen=True, eq=False)
class CosineScores(ScoreSource):
    """Cosines of embeddings, or any inner products, made when asked for and never kept.

    The product is taken in float64, whatever the embeddings' dtype: a score differs from that of
    another size of tile by a rounding of float64 at most.

    Attributes:
        probes: ``(P, D)`` embeddings, of length 1 for cosines; a row of NaN is a failure to
            acquire.
        gallery: ``(G, D)`` the same.
        probe_ids: P identities; text or integers.
        gallery_ids: G identities.

    Raises:
        ScoreError: The shapes do not fit the ids or each other, the numbers are not plain floating
            point, an embedding is infinite or partly NaN, or an identity is neither text nor an
            integer.

    Example:
        >>> faces = np.eye(2, dtype=np.float32)
        >>> scores = CosineScores(faces, faces, ["ann", "bob"], ["ann", "bob"])
        >>> [tile.scores.tolist() for tile in scores.tiles(rows=1)]
        [[[1.0, 0.0]], [[0.0, 1.0]]]
    """

    probes: Array
    gallery: Array
    probe_ids: Sequence[str]
    gallery_ids: Sequence[str]

    def __post_init__(self) -> None:
        super().__post_init__()
        probes = _embeddings(self.probes, "probe", len(self.probe_ids))
        gallery = _embeddings(self.gallery, "gallery", len(self.gallery_ids))
        object.__setattr__(self, "probes", probes)
        object.__setattr__(self, "gallery", gallery)
        if self.probes.shape[1] != self.gallery.shape[1]:
            raise ScoreError(
                f"probe embeddings of {self.probes.shape[1]} numbers, gallery of "
                f"{self.gallery.shape[1]}: use one model for both"
            )

    def rows(self, start: int, stop: int) -> Array:
        """Return rows of the score matrix, ``(stop - start, G)``, float64."""
        probes = self.probes[start:stop].astype(np.float64)
        scores = np.empty((len(probes), len(self.gallery)))
        for first in range(0, len(self.gallery), _COLUMNS):
            part = self.gallery[first : first + _COLUMNS].astype(np.float64, copy=False)
            np.matmul(probes, part.T, out=scores[:, first : first + _COLUMNS])
        return scores

    def mated_scores(self) -> Array:
        """Return the score of each of :attr:`mates`, ``(q,)``, NaN among them."""
        rows, columns = self.mates
        scores = np.empty(rows.size)
        for start in range(0, rows.size, _COLUMNS):
            part = slice(start, start + _COLUMNS)
            pairs = self.probes[rows[part]].astype(np.float64) * self.gallery[columns[part]]
            scores[part] = pairs.sum(axis=1)
        return scores

    def restricted(self, people: Collection[str]) -> "CosineScores":
        """Return the scores of pairs both of whose people are among these.

        Raises:
            ScoreError: There is no such pair.
        """
        rows, columns = self._kept(people)
        ids = np.array(self.probe_ids)[rows], np.array(self.gallery_ids)[columns]
        names = (list(map(str, one)) for one in ids)
        return CosineScores(self.probes[rows], self.gallery[columns], *names)

    @property
    def complete(self) -> bool:
        """Whether every pair has a score."""
        return not (np.isnan(self.probes[:, 0]).any() or np.isnan(self.gallery[:, 0]).any())


def _identities(ids: Any, field: str) -> tuple[str, ...]:
    """Return identities as text; of anything but text and integers it is unclear who is equal.

    Raises:
        ScoreError: An identity is something else, e.g. a missing value (NaN, None) of a table, or
            they have no order.
    """
    if not isinstance(ids, Iterable) or isinstance(ids, Set):
        raise ScoreError(f"{field} are {ids!r}: give a list, in the order of the scores")
    names = ids.tolist() if hasattr(ids, "tolist") else list(ids)
    names = [name.tolist() if hasattr(name, "tolist") else name for name in names]
    for index, name in enumerate(names):
        if not isinstance(name, (str, int)):
            raise ScoreError(f"{field} {index} is {name!r}: give every identity as text or integer")
    return tuple(map(str, names))


def _embeddings(values: Any, name: str, count: int) -> Array:
    """Check embeddings; an integer is none, and a row is NaN as a whole or not at all.

    Raises:
        ScoreError: The shape does not fit, or a row is infinite or partly NaN.
    """
    array = plain_array(values, f"{name} embeddings", kinds="f", wanted="float32 or float64")
    if array.ndim != 2 or len(array) != count or array.size == 0:
        raise ScoreError(
            f"{name} embeddings {array.dtype} {array.shape} for {count} ids: wanted (ids, D)"
        )
    broken = ~np.isfinite(array).all(axis=1) & ~np.isnan(array).all(axis=1)
    if broken.any():
        raise ScoreError(f"{name} embedding {int(np.argmax(broken))} holds a NaN or an infinity")
    return array
