"""How often does recognition err at a stated threshold, and how often is the right person first?

Terms of ISO/IEC 19795-1. A comparison matches when its score is at or above the threshold. The
functions take all scores at once; :class:`Rates` is fed tile after tile and measures the same.
"""

import math
from collections.abc import Collection
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lrsr.errors import ScoreError
from lrsr.evaluation.arrays import Array, plain_number, to_common
from lrsr.evaluation.placements import Ints
from lrsr.evaluation.roc import RocCurve, wilson_interval
from lrsr.evaluation.scores import ScoreSource, Tile

_FEW_FALSE_MATCHES = 10
"""Below so many expected false matches an FMR is too uncertain to set a threshold by."""
_TARGET = "target FMR"


@dataclass(frozen=True)
class OperatingPoint:
    """FNMR at the largest FMR not above a target; every field goes to JSON.

    Attributes:
        target_fmr: The FMR asked for.
        fmr: The FMR reached: the largest attainable that is not above the target.
        fnmr: False-non-match rate there, the least at this FMR.
        fnmr_low: Lower end of Wilson's interval of the FNMR; the threshold is taken as given and
            the genuine pairs as independent.
        fnmr_high: Upper end of the same.
        threshold: Accept score >= threshold; None: accept all.
        false_matches: Impostor scores accepted.
        n_genuine: Genuine scores.
        n_impostor: Impostor scores.
        few_false_matches: Fewer than ten false matches are expected at the target: read with care.
        bootstrap_low: Lower end of the FNMR's interval by the bootstrap over people, the threshold
            set anew in every draw; None where it was not asked for.
        bootstrap_high: Upper end of the same.
    """

    target_fmr: float
    fmr: float
    fnmr: float
    fnmr_low: float
    fnmr_high: float
    threshold: float | None
    false_matches: int
    n_genuine: int
    n_impostor: int
    few_false_matches: bool
    bootstrap_low: float | None = None
    bootstrap_high: float | None = None


@dataclass(frozen=True, eq=False)
class CmcCurve:
    """Closed-set identification.

    Attributes:
        hit_rate: ``(max_rank,)`` share of probes whose person is among the first 1, 2, ...
        n_probes: Probes with a mate in the gallery; failures to acquire are among them, as misses.
        n_without_mate: Probes left out, because nobody in the gallery is their mate.
    """

    hit_rate: NDArray[np.float64]
    n_probes: int
    n_without_mate: int

    @property
    def rank_1(self) -> float:
        """Share of probes whose person comes first."""
        return float(self.hit_rate[0])


def equal_error_rate(curve: RocCurve) -> float:
    """Read off a curve the rate at which FMR and FNMR are equal, [0, 1].

    Where the FNMR jumps past the FMR, the rule of FVC2000 (Maio et al., IEEE TPAMI 24, 2002) is
    taken, as pyeer and bob.measure do: of the two thresholds on either side, the mean of FMR and
    FNMR at the one where their sum is less. Where only the FMR passes, in steps of one impostor
    score, the FNMR is the answer, less than half such a step from that rule.

    Args:
        curve: Of :func:`lrsr.evaluation.roc.trace_roc_of`.

    Example:
        >>> from lrsr.evaluation.placements import place
        >>> from lrsr.evaluation.roc import trace_roc_of
        >>> equal_error_rate(trace_roc_of(place([1, 2, 3, 4], [0, 0, 0, 2.5])))
        0.25
    """
    after = int(np.argmax(curve.fmr >= curve.fnmr))
    (x0, y0), (x1, y1) = ((float(curve.fmr[k]), float(curve.fnmr[k])) for k in (after - 1, after))
    return y1 if y1 in (x1, y0) else min(x0 + y0, x1 + y1) / 2


class Rates:
    """Gathers, tile by tile, what the measures of this module need; memory for the highest scores.

    Args:
        source: Who is on the probes and in the gallery.
        target_fmrs: Where the FNMR will be asked for, each in [0, 1]; may be empty.

    Raises:
        ScoreError: A target lies outside [0, 1].
    """

    def __init__(self, source: ScoreSource, target_fmrs: Collection[float] = ()) -> None:
        self._targets = [plain_number(target, _TARGET) for target in target_fmrs]
        self._genuine = source.genuine()
        most, self._crossed = source.n_pairs - source.mates[0].size, source.crossed
        passing = max((_allowed(target, most) for target in self._targets), default=-1)
        self._highest = _Highest(min(most, passing + 1), self._genuine.dtype)
        self._moments, self._ranks, self._failed = _Moments(), list[Ints](), list[bool]()
        self._probes, gallery, _ = source.codes
        self._people, counts = np.unique(gallery, return_counts=True)
        self._order, self._starts = np.argsort(gallery, kind="stable"), np.cumsum(counts) - counts

    def add(self, tile: Tile) -> None:
        """Take the next tile of the source."""
        self._moments.add(tile.impostors)
        if self._targets:
            self._highest.add(tile.impostors)
        if self._crossed:
            self._ranks.append(self._rank(tile))
        self._failed.extend(np.atleast_1d(tile.absent.all(axis=1)))

    @property
    def fta(self) -> float:
        """Failure-to-acquire rate: the share of probes, or of listed pairs, without a score."""
        return sum(self._failed) / len(self._failed)

    def fnmr(self, level: float = 0.95) -> tuple[OperatingPoint, ...]:
        """Measure FNMR at the largest FMR that some threshold reaches without passing each target.

        Where ties let the FMR jump across a target, the value below it counts: it is never
        interpolated, and never the nearest one. The source has a genuine score.
        """
        highest, n = self._highest.scores(), self._moments.n
        return tuple(
            _operating_point(self._genuine, highest, n, target, level) for target in self._targets
        )

    def d_prime(self) -> float:
        """Measure the separation of the two score distributions in units of their mean spread.

        d' = (mean genuine - mean impostor) / sqrt((var genuine + var impostor) / 2), with sample
        variances, of two scores of a kind or more. Unlike the AUC it changes under a rising map.

        Raises:
            ScoreError: Both kinds are without any spread.
        """
        genuine = _Moments()
        genuine.add(self._genuine)
        return _separation(genuine, self._moments)

    def ranks(self) -> Ints:
        """Return the rank of each probe's person among the persons of the gallery.

        Persons are ordered by their best score. Ties count against the probe, so a constant score
        ranks last, not first. A gallery image without a score cannot outrank anyone.

        Returns:
            ``(P,)`` 1 = first; 0 where the probe or its mate was not acquired, -1 where the gallery
            holds no mate.
        """
        return np.concatenate(self._ranks)

    def cmc(self) -> CmcCurve | None:
        """Measure how often a probe's person is among the first ranks of a closed gallery.

        Returns:
            None where pairs are listed: then nobody was looked for in a gallery.

        Raises:
            ScoreError: No probe has a mate in the gallery.
        """
        if not self._crossed:
            return None
        ranks, last = self.ranks(), self._people.size
        mated = ranks[ranks >= 0]
        if mated.size == 0:
            raise ScoreError("no probe has a mate in the gallery: identification needs one")
        hits = np.bincount(mated, minlength=last + 1)[1:]
        return CmcCurve(np.cumsum(hits) / mated.size, mated.size, int(ranks.size - mated.size))

    def _rank(self, tile: Tile) -> Ints:
        best, columns = tile.filled(-np.inf), self._order
        if self._people.size < columns.size:  # some have several images
            best = np.maximum.reduceat(best[:, columns], self._starts, axis=1)
            columns = np.arange(self._people.size)
        probes = self._probes[tile.rows]
        person = np.minimum(np.searchsorted(self._people, probes), self._people.size - 1)
        own = best[np.arange(probes.size), columns[person]]
        ranks: Ints = np.count_nonzero(best >= own[:, None], axis=1)
        ranks[own == -np.inf] = 0
        ranks[self._people[person] != probes] = -1
        return ranks


def _allowed(target_fmr: float, n_impostor: int) -> int:
    """Return how many false matches a target lets pass: the decimal that is written, rounded down.

    Raises:
        ScoreError: The target lies outside [0, 1].
    """
    if not 0 <= target_fmr <= 1:
        raise ScoreError(f"target FMR {target_fmr}: wanted a number from 0 to 1")
    return math.floor(Fraction(str(target_fmr)) * n_impostor)


def _operating_point(
    genuine: Array, highest: Array, n_impostor: int, target_fmr: float, level: float
) -> OperatingPoint:
    """Measure, knowing of n scores those that the target lets pass and the next, or more."""
    genuine, highest = to_common(genuine, highest)
    allowed = _allowed(target_fmr, n_impostor)
    threshold, false_matches, missed = None, n_impostor, 0
    if allowed < n_impostor:
        # The highest impostor score that may not be accepted; with its ties it stays outside.
        place = highest.size - 1 - allowed
        refused = np.partition(highest, place)[place]
        # The next number of the scores' own dtype, so that comparing with it rounds nothing.
        kind = refused.dtype.type if refused.dtype.kind == "f" else np.float64
        threshold = float(np.nextafter(kind(refused), kind(np.inf)))
        false_matches = int(np.count_nonzero(highest > refused))
        missed = int(np.count_nonzero(genuine <= refused))
    low, high = wilson_interval(missed, genuine.size, level)
    return OperatingPoint(
        target_fmr=target_fmr,
        fmr=false_matches / n_impostor,
        fnmr=missed / genuine.size,
        fnmr_low=float(low),
        fnmr_high=float(high),
        threshold=threshold,
        false_matches=false_matches,
        n_genuine=genuine.size,
        n_impostor=n_impostor,
        few_false_matches=Fraction(str(target_fmr)) * n_impostor < _FEW_FALSE_MATCHES,
    )


class _Highest:
    """Keeps the highest ``count`` of many scores, in memory for an eighth more than those."""

    def __init__(self, count: int, dtype: np.dtype[Any]) -> None:
        self._kept = np.empty(count + count // 8 + 1, dtype)
        self._count, self._start = count, self._kept.size  # filled from the end downwards
        self._least: Array | None = None

    def add(self, scores: Array) -> None:
        if self._least is not None:
            scores = scores[scores > self._least]
        while scores.size:
            part, scores = scores[: self._start], scores[self._start :]
            self._kept[self._start - part.size : self._start] = part
            self._start -= part.size
            if self._start == 0:
                self._start = self._kept.size - self._count
                self._kept.partition(self._start)
                self._least = self._kept[self._start]

    def scores(self) -> Array:
        return self._kept[self._start :]


@dataclass
class _Moments:
    """Number, mean and squared deviations of scores that come in parts (Chan et al., 1979)."""

    n: int = 0
    mean: float = 0.0
    squares: float = 0.0

    def add(self, scores: Array) -> None:
        if scores.size:
            mean, n = float(scores.mean(dtype=np.float64)), self.n + scores.size
            apart = scores.astype(np.float64)
            apart -= mean
            shift = mean - self.mean
            self.squares += float(np.dot(apart, apart)) + shift**2 * self.n * scores.size / n
            self.mean += shift * scores.size / n
            self.n = n


def _separation(genuine: _Moments, impostor: _Moments) -> float:
    spread = genuine.squares / (genuine.n - 1) + impostor.squares / (impostor.n - 1)
    if spread == 0:
        raise ScoreError(
            "all scores of each kind are alike, so d' has no unit: give scores of more digits"
        )
    return (genuine.mean - impostor.mean) / math.sqrt(spread / 2)
