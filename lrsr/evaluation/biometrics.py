"""How often does recognition err at a stated threshold, and how often is the right person first?

Terms of ISO/IEC 19795-1. A comparison matches when its score is at or above the threshold.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from fractions import Fraction
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lrsr.errors import ScoreError
from lrsr.evaluation.counting import Array, Ints, check_finite, check_scores, to_common
from lrsr.evaluation.roc import trace_roc, wilson_interval
from lrsr.recognition.scores import Scores

FEW_FALSE_MATCHES = 10
"""Below so many expected false matches an FMR is too uncertain to set a threshold by."""


@dataclass(frozen=True)
class OperatingPoint:
    """FNMR at the largest FMR not above a target; every field but an infinite threshold is JSON.

    Attributes:
        target_fmr: The FMR asked for.
        fmr: The FMR reached: the largest attainable that is not above the target.
        fnmr: False-non-match rate there, the least at this FMR.
        fnmr_low: Lower end of Wilson's interval of the FNMR; the threshold is taken as given and
            the genuine pairs as independent.
        fnmr_high: Upper end of the same.
        threshold: Accept score >= threshold; +inf (accept none) and -inf (accept all) occur.
        false_matches: Impostor scores accepted.
        n_genuine: Genuine scores.
        n_impostor: Impostor scores.
        few_false_matches: Fewer than ten false matches are expected at the target: read with care.
    """

    target_fmr: float
    fmr: float
    fnmr: float
    fnmr_low: float
    fnmr_high: float
    threshold: float
    false_matches: int
    n_genuine: int
    n_impostor: int
    few_false_matches: bool

    def as_json(self) -> dict[str, Any]:
        """Return the fields as a dict; an infinite threshold becomes None."""
        fields = asdict(self)
        fields["threshold"] = self.threshold if math.isfinite(self.threshold) else None
        return fields


@dataclass(frozen=True)
class EqualErrorRate:
    """Where false-match and false-non-match rate meet.

    Attributes:
        eer: The rate, [0, 1].
        convention: ``steps`` or ``hull``; see :func:`equal_error_rate`.
    """

    eer: float
    convention: Literal["steps", "hull"]


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


def fnmr_at_fmr(
    genuine: ArrayLike, impostor: ArrayLike, target_fmr: float, level: float = 0.95
) -> OperatingPoint:
    """Measure FNMR at the largest FMR that some threshold reaches without passing the target.

    Where ties let the FMR jump across the target, the value below it counts: it is never
    interpolated, and never the nearest one.

    Args:
        genuine: ``(m,)`` scores of mated pairs, higher = more alike, m >= 1.
        impostor: ``(n,)`` scores of non-mated pairs, n >= 1.
        target_fmr: [0, 1], taken as the decimal fraction it is written as.
        level: Confidence level of the interval.

    Raises:
        ScoreError: The target lies outside [0, 1], the level outside (0, 1), a side is empty, a
            score is not finite, or a dtype is not real.

    Example:
        >>> point = fnmr_at_fmr([0.2, 0.6, 0.7, 0.9], [0.1, 0.2, 0.3, 0.8, 0.8], 0.3)
        >>> point.fmr, point.fnmr, point.few_false_matches
        (0.0, 0.75, True)
    """
    genuine, impostor = check_scores(genuine, "genuine"), check_scores(impostor, "impostor")
    check_finite(genuine, "genuine")
    check_finite(impostor, "impostor")
    genuine, impostor = to_common(genuine, impostor)
    if not 0 <= target_fmr <= 1:
        raise ScoreError(f"target FMR {target_fmr}: wanted a number from 0 to 1")
    expected = Fraction(str(float(target_fmr))) * impostor.size
    allowed = math.floor(expected)
    if allowed >= impostor.size:
        threshold, false_matches, missed = -math.inf, impostor.size, 0
    else:
        # The highest impostor score that may not be accepted; with its ties it stays outside.
        place = impostor.size - 1 - allowed
        refused = np.partition(impostor, place)[place]
        # The next number of the scores' own dtype, so that comparing with it rounds nothing.
        kind = refused.dtype.type if refused.dtype.kind == "f" else np.float64
        threshold = float(np.nextafter(kind(refused), kind(np.inf)))
        false_matches = int(np.count_nonzero(impostor > refused))
        missed = int(np.count_nonzero(genuine <= refused))
    low, high = wilson_interval(missed, genuine.size, level)
    return OperatingPoint(
        target_fmr=float(target_fmr),
        fmr=false_matches / impostor.size,
        fnmr=missed / genuine.size,
        fnmr_low=float(low),
        fnmr_high=float(high),
        threshold=threshold,
        false_matches=false_matches,
        n_genuine=genuine.size,
        n_impostor=impostor.size,
        few_false_matches=expected < FEW_FALSE_MATCHES,
    )


def equal_error_rate(
    genuine: ArrayLike,
    impostor: ArrayLike,
    convention: Literal["steps", "hull"] = "steps",
) -> EqualErrorRate:
    """Measure the rate at which FMR and FNMR are equal.

    Conventions, which differ by up to a step of either curve:

    - ``steps``: where the two step functions of the threshold cross. If both jump there (genuine
      and impostor scores tie), the rule of FVC2000 (Maio et al., IEEE TPAMI 24, 2002): of the two
      thresholds on either side, the mean of FMR and FNMR at the one where their sum is less.
    - ``hull``: where the convex hull of the ROC curve meets FMR = FNMR: the least error of a
      system that may also choose between two thresholds by lot. Without such ties it is never
      above ``steps``.

    Args:
        genuine: ``(m,)`` scores of mated pairs, higher = more alike, m >= 1.
        impostor: ``(n,)`` scores of non-mated pairs, n >= 1.
        convention: ``steps`` or ``hull``.

    Raises:
        ScoreError: An unknown convention, an empty side, a score that is not finite, or a dtype
            that is not real.

    Example:
        >>> equal_error_rate([1, 2, 3, 4], [0, 0, 0, 2.5]).eer
        0.25
    """
    curve = trace_roc(genuine, impostor)
    fmr, fnmr = curve.fmr, curve.fnmr
    if convention == "hull":
        corners = _upper_hull(curve.false_matches, curve.true_matches)
        fmr, fnmr = fmr[corners], fnmr[corners]
    elif convention != "steps":
        raise ScoreError(f"EER convention {convention!r}: wanted 'steps' or 'hull'")
    after = int(np.argmax(fmr >= fnmr))
    (x0, y0), (x1, y1) = ((float(fmr[k]), float(fnmr[k])) for k in (after - 1, after))
    if convention == "hull":
        share = (y0 - x0) / ((y0 - x0) + (x1 - y1))
        return EqualErrorRate(x0 + share * (x1 - x0), convention)
    if y0 == y1 or x1 == y1:
        return EqualErrorRate(y1, convention)
    if x0 == x1:
        return EqualErrorRate(x0, convention)
    return EqualErrorRate(min(x0 + y0, x1 + y1) / 2, convention)


def d_prime(genuine: ArrayLike, impostor: ArrayLike) -> float:
    """Measure the separation of the two score distributions in units of their mean spread.

    d' = (mean genuine - mean impostor) / sqrt((var genuine + var impostor) / 2), with sample
    variances. Unlike the AUC it changes under a rising map of the scores.

    Args:
        genuine: ``(m,)``, m >= 2.
        impostor: ``(n,)``, n >= 2.

    Raises:
        ScoreError: Fewer than two scores of a kind, both without any spread, a score that is not
            finite, or a dtype that is not real.

    Example:
        >>> round(d_prime([2, 4], [0, 2]), 4)
        1.4142
    """
    moments = []
    for scores, name in ((genuine, "genuine"), (impostor, "impostor")):
        checked = check_scores(scores, name, at_least=2)
        check_finite(checked, name)
        moments.append((checked.mean(dtype=np.float64), checked.var(dtype=np.float64, ddof=1)))
    (mean_g, var_g), (mean_i, var_i) = moments
    if var_g + var_i == 0:
        raise ScoreError("all scores of each kind are alike: d' has no unit")
    return float((mean_g - mean_i) / np.sqrt((var_g + var_i) / 2))


def rank_probes(scores: Scores) -> Ints:
    """Return the rank of each probe's person among the persons of the gallery.

    Persons are ordered by their best score. Ties count against the probe, so a constant score ranks
    last, not first. A gallery image without a score cannot outrank anyone.

    Args:
        scores: P probes × G gallery images.

    Returns:
        ``(P,)`` 1 = first; 0 where the probe or its mate was not acquired, -1 where the gallery
        holds no mate.
    """
    people, columns = np.unique(np.asarray(scores.gallery_ids), return_inverse=True)
    best = np.full((len(scores.probe_ids), people.size), -np.inf)
    order = np.argsort(columns, kind="stable")
    starts = np.searchsorted(columns[order], np.arange(people.size))
    filled = np.where(scores.acquired, scores.matrix, -np.inf)
    best = np.maximum.reduceat(filled[:, order], starts, axis=1)
    probes = np.asarray(scores.probe_ids)
    column = np.minimum(np.searchsorted(people, probes), people.size - 1)
    own = best[np.arange(probes.size), column]
    ranks = (best >= own[:, None]).sum(axis=1)
    ranks[own == -np.inf] = 0
    ranks[people[column] != probes] = -1
    return np.asarray(ranks, dtype=np.int64)


def cmc(scores: Scores, max_rank: int | None = None) -> CmcCurve:
    """Measure how often a probe's person is among the first ranks of a closed gallery.

    Args:
        scores: P probes × G gallery images.
        max_rank: Length of the curve; the number of persons in the gallery if None.

    Raises:
        ScoreError: No probe has a mate in the gallery, or ``max_rank`` is less than 1.
    """
    ranks = rank_probes(scores)
    mated = ranks[ranks >= 0]
    if mated.size == 0:
        raise ScoreError("no probe has a mate in the gallery: identification needs one")
    if max_rank is None:
        max_rank = len(set(scores.gallery_ids))
    if max_rank < 1:
        raise ScoreError(f"max_rank {max_rank}: wanted at least 1")
    hits = np.bincount(np.minimum(mated, max_rank + 1), minlength=max_rank + 2)[1:-1]
    return CmcCurve(np.cumsum(hits) / mated.size, mated.size, int(ranks.size - mated.size))


def _upper_hull(x: Ints, y: Ints) -> Array:
    """Return the indices of the corners on the upper convex hull, by exact cross products."""
    hull: list[int] = []
    points = list(zip(x.tolist(), y.tolist(), strict=True))
    for index, (px, py) in enumerate(points):
        while len(hull) > 1:
            (ax, ay), (bx, by) = points[hull[-2]], points[hull[-1]]
            if (bx - ax) * (py - ay) < (by - ay) * (px - ax):
                break
            hull.pop()
        hull.append(index)
    return np.array(hull)
