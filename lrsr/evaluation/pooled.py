"""Which scores has a source, and whose are they? All pairs in memory, for what weighs each one."""

import numpy as np

from lrsr.evaluation.arrays import Array
from lrsr.evaluation.scores import Index, ScoreSource


class PooledPairs:
    """All pairs of a source that have a score.

    Args:
        source: Of so many pairs as memory holds.

    Attributes:
        genuine: ``(m,)`` scores of mated pairs.
        impostor: ``(n,)`` scores of non-mated pairs.
        who: ``(m,)`` person of each genuine pair, as in ``source.codes``.
        probe: ``(m,)`` row of each genuine pair.
        left: ``(n,)`` person of each impostor pair's probe.
        right: ``(n,)`` person of its gallery image.
    """

    def __init__(self, source: ScoreSource) -> None:
        probes, gallery, _ = source.codes
        scores: list[Array] = []
        rows: list[Index] = []
        columns: list[Index] = []
        for tile in source.tiles():
            row, column = np.nonzero(~tile.absent)
            scores.append(tile.scores[row, column])
            rows.append(row + tile.first)
            columns.append(column if source.crossed else rows[-1])
        row, values = np.concatenate(rows), np.concatenate(scores)
        left, right = probes[row], gallery[np.concatenate(columns)]
        same = left == right
        self.genuine: Array = values[same]
        self.impostor: Array = values[~same]
        self.who: Index = left[same]
        self.probe: Index = row[same]
        self.left: Index = left[~same]
        self.right: Index = right[~same]
