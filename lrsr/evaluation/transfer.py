"""Does a threshold hold for people on whom it was not set? Set on some, judged on others.

As bob.bio does: the threshold comes from the development people, error rates from the evaluation
people, and their half total error rate (HTER) is one number for both. A threshold that was set on
the scores it is judged by flatters every system.
"""

import math
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from lrsr.errors import ScoreError
from lrsr.evaluation.arrays import Array
from lrsr.evaluation.roc import wilson_interval
from lrsr.evaluation.scores import ScoreSource


@dataclass(frozen=True)
class Transfer:
    """What a threshold of other people does; every field goes to JSON.

    Attributes:
        target_fmr: At which FMR of the development people it was set; None: where their FMR and
            FNMR are as near to each other as can be (EER).
        threshold: Accept score >= threshold; None: accept all.
        development_fmr: FMR of the development people there.
        development_fnmr: Their FNMR.
        fmr: False-match rate of the evaluation people, of pairs that have a score.
        fnmr: Their false-non-match rate, likewise.
        fta: Share of their probes without a score.
        far: False-accept rate: FMR (1 - FTA), as nobody accepts what has no score.
        frr: False-reject rate: FTA + FNMR (1 - FTA).
        hter: Mean of FAR and FRR.
        fmr_low: Lower end of Wilson's interval of the FMR, which takes pairs as independent.
        fmr_high: Upper end.
        fnmr_low: Lower end of that of the FNMR.
        fnmr_high: Upper end.
        n_genuine: Genuine scores of the evaluation people.
        n_impostor: Their impostor scores.
        development_impostor: Impostor scores that the threshold was set on.
    """

    target_fmr: float | None
    threshold: float | None
    development_fmr: float
    development_fnmr: float
    fmr: float
    fnmr: float
    fta: float
    far: float
    frr: float
    hter: float
    fmr_low: float
    fmr_high: float
    fnmr_low: float
    fnmr_high: float
    n_genuine: int
    n_impostor: int
    development_impostor: int


def carry_threshold(
    development: ScoreSource,
    evaluation: ScoreSource,
    target_fmr: float | None = None,
    *,
    level: float = 0.95,
) -> Transfer:
    """Set a threshold on some people and judge it on others.

    Args:
        development: On whose scores it is set.
        evaluation: On whose it is judged.
        target_fmr: Largest FMR of the development people, [0, 1]; None: their equal error rate.
        level: Of the intervals.

    Raises:
        ScoreError: One of them has no genuine or no impostor score, or the target lies outside
            [0, 1].

    Example:
        >>> from lrsr.evaluation.scores import Scores
        >>> people = ["ann", "bob"]
        >>> clear = Scores(np.array([[0.9, 0.1], [0.2, 0.8]]), people, people)
        >>> blurred = Scores(np.array([[0.7, 0.6], [0.2, 0.4]]), people, people)
        >>> judged = carry_threshold(clear, blurred)
        >>> judged.threshold, judged.fmr, judged.fnmr, judged.hter
        (0.5, 0.5, 0.5, 0.5)
    """
    genuine, impostor = _scores(development, "development")
    threshold = (
        _equal_error_threshold(genuine, impostor)
        if target_fmr is None
        else _threshold_at_fmr(impostor, target_fmr)
    )
    least = -np.inf if threshold is None else threshold
    judged, others = _scores(evaluation, "evaluation")
    missed = int(np.count_nonzero(judged < least))
    accepted = int(np.count_nonzero(others >= least))
    absent = [tile.absent.all(axis=1) for tile in evaluation.tiles()]
    fta = float(np.concatenate(absent).mean())
    fmr, fnmr = accepted / others.size, missed / judged.size
    far, frr = fmr * (1 - fta), fta + fnmr * (1 - fta)
    fmr_ends = wilson_interval(accepted, others.size, level)
    fnmr_ends = wilson_interval(missed, judged.size, level)
    return Transfer(
        target_fmr=target_fmr,
        threshold=threshold,
        development_fmr=float((impostor >= least).mean()),
        development_fnmr=float((genuine < least).mean()),
        fmr=fmr,
        fnmr=fnmr,
        fta=fta,
        far=far,
        frr=frr,
        hter=(far + frr) / 2,
        fmr_low=float(fmr_ends[0]),
        fmr_high=float(fmr_ends[1]),
        fnmr_low=float(fnmr_ends[0]),
        fnmr_high=float(fnmr_ends[1]),
        n_genuine=judged.size,
        n_impostor=others.size,
        development_impostor=impostor.size,
    )


def _equal_error_threshold(genuine: Array, impostor: Array) -> float:
    """Return where FMR and FNMR are as near to each other as can be.

    The middle between two neighbouring scores; of two such places the higher one, as bob.measure
    takes it.

    Args:
        genuine: ``(m,)``, m >= 1.
        impostor: ``(n,)``, n >= 1.

    Example:
        >>> _equal_error_threshold(np.array([0.4, 0.8]), np.array([0.1, 0.2]))
        0.30000000000000004
    """
    scores = np.unique(np.concatenate([genuine, impostor]).astype(np.float64))
    middles = (scores[:-1] + scores[1:]) / 2
    places = np.concatenate([scores[:1], middles, np.nextafter(scores[-1:], np.inf)])
    fnmr = np.searchsorted(np.sort(genuine), places, side="left") / genuine.size
    fmr = 1 - np.searchsorted(np.sort(impostor), places, side="left") / impostor.size
    apart = np.abs(fmr - fnmr)
    # rounding must not decide between two places that are equally far from the equal rate
    return float(places[np.flatnonzero(apart <= apart.min() + 1e-12)[-1]])


def _threshold_at_fmr(impostor: Array, target_fmr: float) -> float | None:
    """Return where the FMR is the largest that does not pass a target; None: at any score.

    It is the lowest impostor score that may be accepted, as bob.measure has it: on other people
    that errs on the side of refusing. Where none may, it is the next number above all.

    Args:
        impostor: ``(n,)``, n >= 1.
        target_fmr: [0, 1].

    Raises:
        ScoreError: The target lies outside [0, 1].

    Example:
        >>> _threshold_at_fmr(np.array([0.1, 0.2, 0.3, 0.4]), 0.5)
        0.3
    """
    if not 0 <= target_fmr <= 1:
        raise ScoreError(f"target FMR {target_fmr}: wanted a number from 0 to 1")
    scores = np.sort(impostor.astype(np.float64))
    allowed = math.floor(Fraction(str(target_fmr)) * scores.size)  # the decimal that is written
    if allowed == scores.size:
        return None
    refused = scores[-1 - allowed]  # with its ties it stays outside
    accepted = scores[scores > refused]
    return float(accepted[0] if accepted.size else np.nextafter(refused, np.inf))


def _scores(source: ScoreSource, whose: str) -> tuple[Array, Array]:
    """Return genuine and impostor scores.

    Raises:
        ScoreError: There are none of a kind.
    """
    genuine, impostor = source.genuine(), source.impostor()
    if not (genuine.size and impostor.size):
        raise ScoreError(
            f"{genuine.size} genuine and {impostor.size} impostor scores of the {whose} people:"
            " a threshold needs both"
        )
    return genuine, impostor
