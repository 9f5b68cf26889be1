"""What does a verification experiment report? Rows, comparisons, and ``results.json``."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from lrsr.evaluation.delong import compare_aucs, estimate_auc
from lrsr.evaluation.rates import (
    OperatingPoint,
    cmc,
    d_prime,
    equal_error_rate,
    fnmr_at_fmr,
)
from lrsr.evaluation.roc import trace_roc
from lrsr.evaluation.scores import Scores
from lrsr.experiments.settings import Condition

BICUBIC_OF = {"srcnn2": "bicubic2", "srcnn2x2": "bicubic4", "srcnn4": "bicubic4"}
"""What each learned method must beat: the bicubic enlargement by the same factor."""

TARGET_FMRS = (1e-1, 1e-2, 1e-3)


@dataclass(frozen=True)
class Row:
    """One line of the table: a condition, a method, and how well identities are told apart.

    Attributes:
        experiment: Name.
        option: Number of the option, 1 to 6 of the paper's Table 2.
        ipd_px: Interpupillary distance of the probe before enlarging, px.
        pose: Of the probe.
        lighting: Of the probe.
        compression: Of the probe.
        method: Key of :data:`lrsr.sr.upscaling.METHODS`.
        label: Its name in tables.
        landmarks: "shared": the renderer's true ones, scaled.
        auc: Area under the ROC curve.
        std: DeLong's standard error of it.
        low: Lower end of the Wald interval.
        high: Upper end of the Wald interval.
        level: Confidence level of every interval.
        logit_low: Lower end of the interval on the logit scale; None where it does not exist.
        logit_high: Upper end of the same.
        n_genuine: Genuine scores.
        n_impostor: Impostor scores.
        psnr_y_db: Mean over the probes, against the true reference; None where nothing is enlarged.
        fta: Share of the probes without a score.
        eer: Equal error rate.
        d_prime: Distance of the means over the pooled deviation.
        rank_1: Share of the probes whose own gallery picture is the most alike of all.
        fnmr: FNMR at each of :data:`TARGET_FMRS`, with the FMR that was achieved.
    """

    experiment: str
    option: int
    ipd_px: float
    pose: str
    lighting: str
    compression: str
    method: str
    label: str
    landmarks: str
    auc: float
    std: float
    low: float
    high: float
    level: float
    logit_low: float | None
    logit_high: float | None
    n_genuine: int
    n_impostor: int
    psnr_y_db: float | None
    fta: float
    eer: float
    d_prime: float
    rank_1: float
    fnmr: tuple[OperatingPoint, ...]


@dataclass(frozen=True)
class Comparison:
    """A paired DeLong test between two methods on the same pairs.

    Attributes:
        option: Number of the option.
        ipd_px: Of the probe, px.
        method: The one that a positive difference favours.
        against: The other one.
        difference: AUC of ``method`` less that of ``against``.
        low: Lower end of its interval.
        high: Upper end of its interval.
        z: Difference over its standard error; None where that is 0.
        p: Two-sided.
        log10_p: The same, where p underflows; None for p = 0.
    """

    option: int
    ipd_px: float
    method: str
    against: str
    difference: float
    low: float
    high: float
    z: float | None
    p: float
    log10_p: float | None


def make_row(
    experiment: str,
    condition: Condition,
    method: tuple[str, str],
    scores: Scores,
    psnr_y_db: float | None,
    level: float,
) -> Row:
    """Evaluate one method under one condition.

    Args:
        experiment: Name.
        condition: Of the probes.
        method: Key and label.
        scores: Of the probes against the gallery.
        psnr_y_db: See :class:`Row`.
        level: Of the interval, (0, 1).

    Raises:
        ScoreError: Fewer than two genuine or impostor scores are left.
    """
    genuine, impostor = scores.genuine(), scores.impostor()
    area = estimate_auc(genuine, impostor, level)
    return Row(
        experiment=experiment,
        **asdict(condition),
        method=method[0],
        label=method[1],
        landmarks="shared",
        auc=area.auc,
        std=area.std,
        low=area.low,
        high=area.high,
        level=level,
        logit_low=area.logit_low,
        logit_high=area.logit_high,
        n_genuine=area.n_genuine,
        n_impostor=area.n_impostor,
        psnr_y_db=_finite(psnr_y_db),
        fta=scores.fta,
        eer=equal_error_rate(trace_roc(genuine, impostor)),
        d_prime=d_prime(genuine, impostor),
        rank_1=cmc(scores, max_rank=1).rank_1,
        fnmr=tuple(fnmr_at_fmr(genuine, impostor, fmr, level) for fmr in TARGET_FMRS),
    )


def compare_methods(
    condition: Condition, scores: Mapping[str, Scores], level: float
) -> Iterator[Comparison]:
    """Test every method against Base, and every learned one against its bicubic, where present."""
    for method, own in scores.items():
        for against in ("base", BICUBIC_OF.get(method)):
            if against is None or against == method or against not in scores:
                continue
            test = compare_aucs(*own.pair_with(scores[against]), level=level)
            yield Comparison(
                option=condition.option,
                ipd_px=condition.ipd_px,
                method=method,
                against=against,
                difference=test.difference,
                low=test.low,
                high=test.high,
                z=_finite(test.z),
                p=test.p,
                log10_p=_finite(test.log10_p),
            )


def mean_psnr_db(per_image_db: NDArray[np.float64]) -> float | None:
    """Average per-image PSNR; None if an image equals its reference (infinite)."""
    return _finite(float(np.mean(per_image_db)))


def _finite(value: float | None) -> float | None:
    return None if value is None or not math.isfinite(value) else float(value)
