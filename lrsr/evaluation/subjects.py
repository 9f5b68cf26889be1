"""How sure is the AUC when persons, not pairs, were sampled?

Pairs share persons, so they are not independent. With one genuine pair per person DeLong's standard
error is right within a few per cent; with several images per person it is two to four times too
small. Both ways here draw or drop whole persons, with all their pairs as probe and in the gallery,
and are right in either case (Fogliato et al., IJCV 2024; Poh et al., IEEE TPAMI 2007).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lrsr.errors import ScoreError
from lrsr.evaluation.counting import Array, Counter, Ints, class_placements
from lrsr.evaluation.delong import AucEstimate, auc_interval, normal_quantile
from lrsr.recognition.scores import Scores

Floats = NDArray[np.float64]


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

    def as_json(self) -> dict[str, Any]:
        """Return the fields as a dict."""
        return asdict(self)


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


def jackknife_auc(scores: Scores, level: float = 0.95) -> AucEstimate:
    """Estimate the AUC with a standard error that leaves out one identity at a time.

    Leaving out a person removes rows and columns, in one counting pass: what their genuine scores
    beat and what beats their impostor scores is subtracted, and their own overlap added back.

    Args:
        scores: Probes × gallery, NaN = failure to acquire.
        level: Confidence level of the Wald and logit intervals.

    Raises:
        ScoreError: Fewer than two identities with a genuine score, too few impostor scores to
            leave one identity out, or a level outside (0, 1).
    """
    normal_quantile(level)
    genuine, impostor = scores.genuine(), scores.impostor()
    probe_codes, gallery_codes, size = _identity_codes(scores)
    genuine_rows, _ = np.nonzero(scores.mated & scores.acquired)
    impostor_rows, impostor_columns = np.nonzero(~scores.mated & scores.acquired)
    who = probe_codes[genuine_rows]
    who_a, who_b = probe_codes[impostor_rows], gallery_codes[impostor_columns]
    if np.unique(who).size < 2:
        raise ScoreError(
            f"{np.unique(who).size} identities with a genuine score: leaving one out needs two"
        )
    counter = Counter(genuine)
    beaten_by = counter.place(impostor)
    counts = counter.counts()
    beats = counts.genuine_placements[np.searchsorted(counts.values, genuine)]
    total = int(beats.sum())
    lost = _sums(who, beats, size) + _sums(who_a, beaten_by, size) + _sums(who_b, beaten_by, size)
    m = genuine.size - _sums(who, np.ones_like(beats), size)
    ones = np.ones_like(beaten_by)
    n = impostor.size - _sums(who_a, ones, size) - _sums(who_b, ones, size)
    if (n < 1).any():
        raise ScoreError("no impostor score is left without one of the identities: add people")
    present = (m < genuine.size) | (n < impostor.size)
    remaining = total - lost + _own_overlaps(scores, probe_codes, gallery_codes, size)
    areas = (remaining / (2.0 * m * n))[present]
    variance = (areas.size - 1) / areas.size * float(((areas - areas.mean()) ** 2).sum())
    area = total / (2 * genuine.size * impostor.size)
    return auc_interval(area, float(np.sqrt(variance)), genuine.size, impostor.size, level)


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
        if (scores.probe_ids, scores.gallery_ids) != (first.probe_ids, first.gallery_ids):
            raise ScoreError(
                f"{name} has other probes or another gallery: a pairing needs the same"
            )
    probe_codes, gallery_codes, size = _identity_codes(first)
    prepared = {name: _Weighted(scores, probe_codes) for name, scores in methods.items()}
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

    def __init__(self, scores: Scores, probe_codes: Ints) -> None:
        genuine = scores.genuine()
        counter = Counter(genuine)
        impostor = scores.impostor()
        placements = counter.place(impostor)
        if impostor.size == 0:
            raise ScoreError("0 impostor scores, wanted at least 1: give more pairs")
        # Placements fall strictly with the class, so they name it.
        self.classes = np.searchsorted(-class_placements(counter.ties), -placements)
        self.is_impostor = ~scores.mated & scores.acquired
        self.value_of = np.searchsorted(counter.counts().values, genuine)
        self.who = probe_codes[np.nonzero(scores.mated & scores.acquired)[0]]
        self.n_values = counter.ties.size

    def auc(self, weights: Ints, pairs: Floats) -> float:
        """Measure the AUC with a weight for each identity; NaN where nothing has weight."""
        ties = np.bincount(self.value_of, weights[self.who], minlength=self.n_values)
        per_class = np.bincount(
            self.classes, pairs[self.is_impostor], minlength=2 * self.n_values + 1
        )
        whole = ties.sum() * per_class.sum()
        above = class_placements(ties.astype(np.int64))
        return float((per_class * above).sum() / (2 * whole)) if whole else float("nan")


def _identity_codes(scores: Scores) -> tuple[Ints, Ints, int]:
    """Number the identities; return the codes of the rows, of the columns, and how many."""
    people, codes = np.unique([*scores.probe_ids, *scores.gallery_ids], return_inverse=True)
    split = len(scores.probe_ids)
    return codes[:split], codes[split:], people.size


def _sums(who: Ints, values: Ints, size: int) -> Ints:
    """Add integers up by identity, exactly."""
    sums = np.zeros(size, dtype=np.int64)
    np.add.at(sums, who, values)
    return sums


def _own_overlaps(scores: Scores, probe_codes: Ints, gallery_codes: Ints, size: int) -> Ints:
    """Return twice what each identity's genuine scores beat among its own impostor scores."""
    overlaps = np.zeros(size, dtype=np.int64)
    is_impostor = ~scores.mated & scores.acquired
    is_genuine = scores.mated & scores.acquired
    for identity in np.unique(probe_codes):
        rows, columns = probe_codes == identity, gallery_codes == identity
        own: Array = scores.matrix[rows][is_genuine[rows]]
        against = np.concatenate(
            (
                scores.matrix[rows][is_impostor[rows]],
                scores.matrix[:, columns][is_impostor[:, columns]],
            )
        )
        against.sort()
        overlaps[identity] = np.searchsorted(against, own, side="left").sum()
        overlaps[identity] += np.searchsorted(against, own, side="right").sum()
    return overlaps
