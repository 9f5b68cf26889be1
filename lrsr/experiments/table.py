"""What does a verification experiment report? Rows and comparisons, as in ``results.json``."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from lrsr.evaluation.delong import AucComparison
from lrsr.evaluation.rates import OperatingPoint
from lrsr.evaluation.roc import RocCurve
from lrsr.evaluation.scores import ScoreSource
from lrsr.evaluation.summary import Summary, summarise
from lrsr.experiments.design import Condition, Design
from lrsr.sr.upscaler import Upscaler

TARGET_FMRS = (1e-1, 1e-2, 1e-3)


@dataclass(frozen=True)
class Row:
    """One line of the table: a condition, a method, and how well identities are told apart.

    Attributes:
        experiment: Name.
        option: Number of the option, 1 to 6 of the paper's Table 2.
        ipd_px: Interpupillary distance of the probe before enlarging, px; None: not known.
        pose: Of the probe; empty of photographs, as the next two.
        lighting: Of the probe.
        compression: Of the probe.
        method: Name of the upscaler.
        label: Its name in tables.
        landmarks: "shared": the true ones, scaled.
        auc: Area under the ROC curve.
        std: DeLong's standard error of it.
        low: Lower end of the Wald interval.
        high: Upper end of the Wald interval.
        level: Confidence level of every interval.
        logit_low: Lower end of the interval on the logit scale; None where it does not exist.
        logit_high: Upper end of the same.
        subject_std: Standard error when people, not pairs, were sampled (jackknife); None where
            too few are left to leave one out.
        subject_low: Lower end of its interval.
        subject_high: Upper end of its interval.
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
    ipd_px: float | None
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
    subject_std: float | None
    subject_low: float | None
    subject_high: float | None
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
        subject_low: Lower end of the interval when people, not pairs, were sampled.
        subject_high: Upper end of the same.
        z: Difference over its standard error; None where that is 0.
        p: Two-sided.
        log10_p: The same, where p underflows; None for p = 0.
    """

    option: int
    ipd_px: float | None
    method: str
    against: str
    difference: float
    low: float
    high: float
    subject_low: float | None
    subject_high: float | None
    z: float | None
    p: float
    log10_p: float | None


def evaluate(
    design: Design,
    condition: Condition,
    scores: Mapping[str, ScoreSource],
    decibels: Mapping[str, Sequence[float]],
) -> tuple[tuple[Row, ...], tuple[Comparison, ...], dict[str, RocCurve]]:
    """Evaluate all methods under one condition, and test them in pairs.

    Args:
        design: What was asked.
        condition: Of the probes.
        scores: By method.
        decibels: By method, the PSNR of each probe; empty where there is no reference.

    Returns:
        A row a method, the paired tests, and the ROC curve of each method.

    Raises:
        ScoreError: Fewer than two genuine or impostor scores are left.
    """
    pairs = rivals(design.upscalers)
    found = summarise(scores, pairs=pairs, level=design.level, target_fmrs=TARGET_FMRS)
    rows = tuple(
        _row(design, condition, method, summary, mean_psnr_db(decibels[method]))
        for method, summary in found.summaries.items()
    )
    tests = tuple(_comparison(condition, pair, found.comparisons[pair]) for pair in pairs)
    return rows, tests, {method: summary.curve for method, summary in found.summaries.items()}


def rivals(upscalers: Mapping[str, Upscaler]) -> list[tuple[str, str]]:
    """Pair every method with the picture as it is, and every learned one with its bicubic.

    The bicubic of a learned method is the one that enlarges as much; what is not among the methods
    is not compared with.
    """
    plain = {upscaler.scale: name for name, upscaler in upscalers.items() if not upscaler.learned}
    return [
        (name, against)
        for name, upscaler in upscalers.items()
        for against in dict.fromkeys(
            (plain.get(1), plain.get(upscaler.scale) if upscaler.learned else None)
        )
        if against is not None and against != name
    ]


def mean_psnr_db(per_image_db: Sequence[float]) -> float | None:
    """Average per-image PSNR; None without any, or if an image equals its reference (infinite)."""
    return _finite(float(np.mean(per_image_db))) if len(per_image_db) else None


def _row(
    design: Design, condition: Condition, method: str, summary: Summary, psnr_y_db: float | None
) -> Row:
    area = summary.area
    return Row(
        experiment=design.name,
        option=condition.option,
        ipd_px=condition.ipd_px,
        pose=condition.pose,
        lighting=condition.lighting,
        compression=condition.compression,
        method=method,
        label=design.upscalers[method].label,
        landmarks="shared",
        auc=area.auc,
        std=area.std,
        low=area.low,
        high=area.high,
        level=area.level,
        logit_low=area.logit_low,
        logit_high=area.logit_high,
        subject_std=area.subject_std,
        subject_low=area.subject_low,
        subject_high=area.subject_high,
        n_genuine=area.n_genuine,
        n_impostor=area.n_impostor,
        psnr_y_db=psnr_y_db,
        fta=summary.fta,
        eer=summary.eer,
        d_prime=summary.d_prime,
        rank_1=summary.cmc.rank_1,
        fnmr=summary.fnmr,
    )


def _comparison(condition: Condition, pair: tuple[str, str], test: AucComparison) -> Comparison:
    return Comparison(
        option=condition.option,
        ipd_px=condition.ipd_px,
        method=pair[0],
        against=pair[1],
        difference=test.difference,
        low=test.low,
        high=test.high,
        subject_low=test.subject_low,
        subject_high=test.subject_high,
        z=_finite(test.z),
        p=test.p,
        log10_p=_finite(test.log10_p),
    )


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
