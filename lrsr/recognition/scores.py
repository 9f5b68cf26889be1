"""How alike is every probe to every gallery image, and who is who? What evaluation is fed with."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lrsr.errors import ScoreError

Matrix = NDArray[Any]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Scores:
    """Similarities of probes and gallery images, higher = more alike.

    A NaN says that one of the two images gave no embedding. It is never compared; it is counted.

    Attributes:
        matrix: ``(P, G)`` real scores, NaN = failure to acquire, no infinities.
        probe_ids: P identities, one per row.
        gallery_ids: G identities, one per column.

    Raises:
        ScoreError: The shape does not fit the ids, the dtype is not real, or a score is infinite.

    Example:
        >>> people = ["ann", "bob"]
        >>> scores = Scores(np.array([[0.9, 0.1], [np.nan, np.nan]]), people, people)
        >>> scores.genuine().tolist(), scores.impostor().tolist(), scores.n_fta, scores.fta
        ([0.9], [0.1], 1, 0.5)
    """

    matrix: Matrix
    probe_ids: Sequence[str]
    gallery_ids: Sequence[str]

    def __post_init__(self) -> None:
        matrix = np.asarray(self.matrix)
        if matrix.shape != (len(self.probe_ids), len(self.gallery_ids)) or matrix.size == 0:
            raise ScoreError(
                f"score matrix {matrix.shape} for {len(self.probe_ids)} probes and "
                f"{len(self.gallery_ids)} gallery images: wanted one row and one column each"
            )
        if matrix.dtype.kind not in "iuf":
            raise ScoreError(f"score matrix has dtype {matrix.dtype}: give real numbers")
        infinite = np.isinf(matrix)
        if infinite.any():
            row, column = (int(index) for index in np.argwhere(infinite)[0])
            raise ScoreError(
                f"score of probe {row} ({self.probe_ids[row]}) and gallery image {column} "
                f"({self.gallery_ids[column]}) is {matrix[row, column]}: scores must be finite"
            )
        object.__setattr__(self, "matrix", matrix)
        object.__setattr__(self, "probe_ids", tuple(map(str, self.probe_ids)))
        object.__setattr__(self, "gallery_ids", tuple(map(str, self.gallery_ids)))

    @cached_property
    def mated(self) -> Flags:
        """``(P, G)`` whether probe and gallery image show the same person."""
        _, codes = np.unique([*self.probe_ids, *self.gallery_ids], return_inverse=True)
        probes = codes[: len(self.probe_ids)]
        return np.asarray(probes[:, None] == codes[None, len(self.probe_ids) :])

    @cached_property
    def acquired(self) -> Flags:
        """``(P, G)`` whether there is a score at all."""
        return ~np.isnan(self.matrix)

    def genuine(self) -> Matrix:
        """Return the scores of mated pairs ``(m,)``, row by row, without failures."""
        return self.matrix[self.mated & self.acquired]

    def impostor(self) -> Matrix:
        """Return the scores of non-mated pairs ``(n,)``, row by row, without failures."""
        return self.matrix[~self.mated & self.acquired]

    @cached_property
    def n_fta(self) -> int:
        """How many probes have no score with any gallery image: failures to acquire."""
        return int((~self.acquired.any(axis=1)).sum())

    @property
    def fta(self) -> float:
        """Failure-to-acquire rate: the share of such probes, [0, 1]."""
        return self.n_fta / len(self.probe_ids)

    @cached_property
    def n_fte(self) -> int:
        """How many gallery images have no score with any probe: failures to enrol."""
        return int((~self.acquired.any(axis=0)).sum())

    @property
    def n_missing_genuine(self) -> int:
        """How many mated pairs have no score."""
        return int((self.mated & ~self.acquired).sum())

    @property
    def n_missing_impostor(self) -> int:
        """How many non-mated pairs have no score."""
        return int((~self.mated & ~self.acquired).sum())

    def pair_with(self, other: Scores) -> tuple[Matrix, Matrix, Matrix, Matrix]:
        """Return genuine and impostor scores of the pairs that both methods scored, in one order.

        Args:
            other: Scores of another method for the same probes and gallery.

        Returns:
            ``genuine, impostor`` of this method and ``genuine, impostor`` of the other: the four
            arguments of :func:`lrsr.evaluation.delong.compare_aucs`.

        Raises:
            ScoreError: The two were made from different probes or another gallery.
        """
        if (self.probe_ids, self.gallery_ids) != (other.probe_ids, other.gallery_ids):
            raise ScoreError(
                "the two score matrices have different probes or gallery images: "
                "a paired test wants the same pairs in the same order"
            )
        both = self.acquired & other.acquired
        genuine, impostor = self.mated & both, ~self.mated & both
        return (
            self.matrix[genuine],
            self.matrix[impostor],
            other.matrix[genuine],
            other.matrix[impostor],
        )
