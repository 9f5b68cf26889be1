"""Is the right person on the list of candidates, and is nobody named who is not enrolled?

A list holds the images of a gallery by falling score, one of several of a person being enough, as
the protocols of TinyFace and QMUL-SurvFace have it; where the gallery has one template a person it
is a list of people. Closed set: probes with a mate, hits by rank. Open set: a threshold is set on
the highest scores of probes without a mate (FPIR), and a mate must pass it and be on the list
(TPIR). ISO/IEC 19795-1 calls 1 - TPIR the false-negative identification rate.
"""

import math
from collections.abc import Collection
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from lrsr.errors import ScoreError
from lrsr.evaluation.roc import wilson_interval
from lrsr.evaluation.scores import ScoreSource, Tile


@dataclass(frozen=True)
class HitRate:
    """How many probes have their mate among the first of the list; every field goes to JSON.

    Attributes:
        rank: Length of the list.
        rate: Share of the probes that have a mate; a failure to acquire is a miss.
        low: Lower end of Wilson's interval, which takes probes as independent.
        high: Upper end.
    """

    rank: int
    rate: float
    low: float
    high: float


@dataclass(frozen=True)
class OpenSetPoint:
    """TPIR at the largest FPIR not above a target; every field goes to JSON.

    Attributes:
        target_fpir: The FPIR asked for.
        fpir: The one reached: the largest attainable that is not above it.
        tpir: Share of the probes with a mate whose mate is on the list and at or above the
            threshold.
        low: Lower end of Wilson's interval of the TPIR; the threshold is taken as given.
        high: Upper end.
        threshold: Name somebody at a score >= threshold; None: at any.
        rank: Length of the list.
    """

    target_fpir: float
    fpir: float
    tpir: float
    low: float
    high: float
    threshold: float | None
    rank: int


@dataclass(frozen=True)
class Identification:
    """What a search of the gallery finds.

    Attributes:
        hits: At each rank.
        open_set: At each FPIR; none where every probe has a mate.
        n_mated: Probes with a mate.
        n_unmated: Probes without.
        n_gallery: Images in the gallery.
    """

    hits: tuple[HitRate, ...]
    open_set: tuple[OpenSetPoint, ...]
    n_mated: int
    n_unmated: int
    n_gallery: int


def identify(
    source: ScoreSource,
    *,
    ranks: Collection[int] = (1, 5, 10, 20),
    target_fpirs: Collection[float] = (0.3, 0.2, 0.1, 0.01),
    within: int = 20,
    level: float = 0.95,
) -> Identification:
    """Search the gallery for every probe.

    Ties count against a probe: who scores as high as its mate stands before it.

    Args:
        source: Every probe with the whole gallery.
        ranks: Lengths of the list, each >= 1.
        target_fpirs: Each in [0, 1].
        within: Length of the list of the open set.
        level: Of the intervals.

    Raises:
        ScoreError: Pairs are listed instead, no probe has a mate, a rank is less than 1, or a
            target lies outside [0, 1].

    Example:
        >>> from lrsr.evaluation.scores import Scores
        >>> matrix = np.array([[0.9, 0.1], [0.4, 0.3], [0.2, 0.5]])
        >>> found = identify(Scores(matrix, ["ann", "bob", "cy"], ["ann", "bob"]), ranks=[1, 2])
        >>> [hit.rate for hit in found.hits], found.open_set[0].threshold > 0.5
        ([0.5, 1.0], True)
    """
    if not source.crossed:
        raise ScoreError("pairs are listed: identification searches a whole gallery")
    for rank in (*ranks, within):
        if rank < 1:
            raise ScoreError(f"rank {rank}: wanted 1 or more")
    for target in target_fpirs:
        if not 0 <= target <= 1:
            raise ScoreError(f"target FPIR {target}: wanted a number from 0 to 1")
    mated = np.isin(source.probe_ids, source.gallery_ids)
    if not mated.any():
        raise ScoreError("no probe has a mate in the gallery: identification needs one")
    places, best = (
        np.concatenate(parts)
        for parts in zip(*(_search(tile, source) for tile in source.tiles()), strict=True)
    )
    own, strangers = best[mated], np.sort(best[~mated])
    found = places[mated]
    hits = [(rank, int(np.count_nonzero(found <= rank))) for rank in ranks]
    ends = [wilson_interval(number, found.size, level) for _, number in hits]
    return Identification(
        tuple(
            HitRate(rank, number / found.size, float(low), float(high))
            for (rank, number), (low, high) in zip(hits, ends, strict=True)
        ),
        tuple(
            _open_set(own[found <= within], found.size, strangers, target, within, level)
            for target in target_fpirs
            if strangers.size
        ),
        found.size,
        strangers.size,
        len(source.gallery_ids),
    )


def _search(tile: Tile, source: ScoreSource) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the place of each probe's mate on its list, and the mate's score.

    Of a probe without a mate the highest score instead, at place infinity; -inf where there is no
    score at all.
    """
    scores = tile.filled(-np.inf)
    rows, columns = np.divmod(tile.mates, scores.shape[1])
    own = np.full(len(scores), -np.inf)
    np.maximum.at(own, rows, scores[rows, columns])
    scores = np.array(scores, dtype=np.float64)
    has_mate = np.zeros(len(scores), dtype=bool)
    has_mate[rows] = True
    highest = scores.max(axis=1)
    scores[rows, columns] = -np.inf  # what is left are others
    places = 1.0 + np.count_nonzero(scores >= own[:, None], axis=1)
    places[~np.isfinite(own)] = np.inf
    return places, np.where(has_mate, own, highest)


def _open_set(
    listed: NDArray[np.float64],
    total: int,
    strangers: NDArray[np.float64],
    target: float,
    rank: int,
    level: float,
) -> OpenSetPoint:
    """Set the threshold on sorted scores of strangers, and see which listed mates pass it."""
    allowed = math.floor(Fraction(str(target)) * strangers.size)  # the decimal that is written
    threshold, named, passed = None, strangers.size, listed.size
    if allowed < strangers.size:
        refused = strangers[-1 - allowed]  # with its ties it stays outside
        threshold = float(np.nextafter(refused, np.inf)) if np.isfinite(refused) else None
        named = int(np.count_nonzero(strangers > refused))
        passed = int(np.count_nonzero(listed > refused))
    low, high = wilson_interval(passed, total, level)
    return OpenSetPoint(
        target, named / strangers.size, passed / total, float(low), float(high), threshold, rank
    )
