"""What does a verification experiment report? Rows and comparisons, as in ``results.json``."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from lrsr.evaluation.delong import AucComparison, AucEstimate
from lrsr.evaluation.multiplicity import holm_adjusted
from lrsr.evaluation.scores import ScoreSource
from lrsr.evaluation.summary import Summary, summarise
from lrsr.experiments.design import Condition, Design
from lrsr.sr.upscaler import Upscaler

Record = dict[str, Any]
"""A line of ``results.json`` in plain values."""

_UNTOLD = ("wald_leaves_range", "degenerate")
_TOLD = (
    *("difference", "low", "high", "subject_low", "subject_high"),
    *("bootstrap_low", "bootstrap_high", "z", "p", "log10_p", "bootstrap_p"),
)


def evaluate(
    design: Design,
    condition: Condition,
    scores: Mapping[str, ScoreSource],
    decibels: Mapping[str, Sequence[float]],
) -> tuple[list[Record], list[Record], Mapping[str, Summary]]:
    """Evaluate all methods under one condition, and test them in pairs.

    Args:
        design: What was asked.
        condition: Of the probes.
        scores: By method.
        decibels: By method, the PSNR of each probe; empty where there is no reference.

    Returns:
        A row a method, the paired tests, and the summary of each method. A row names experiment,
        option, ipd_px, pose, lighting and compression of the probe (empty or None where a
        photograph's are not known), method, label and landmarks ("shared": the true ones, scaled);
        holds the numbers of :class:`~lrsr.evaluation.delong.AucEstimate`; psnr_y_db (mean over the
        probes; None where nothing is enlarged or a probe equals its reference), fta, eer, d_prime,
        rank_1; and fnmr, an :class:`~lrsr.evaluation.rates.OperatingPoint` for each target FMR. A
        test names option, ipd_px, method and against, and holds the numbers of
        :class:`~lrsr.evaluation.delong.AucComparison`, None for those that are infinite.

    Raises:
        ScoreError: Fewer than two genuine or impostor scores are left.
    """
    pairs = _rivals(design.upscalers)
    found = summarise(
        scores, pairs=pairs, level=design.level, bootstrap=design.bootstrap, seed=design.seed
    )
    rows = [
        _row(design, condition, method, summary, decibels[method])
        for method, summary in found.summaries.items()
    ]
    tests = [_comparison(condition, pair, found.comparisons[pair]) for pair in pairs]
    return rows, tests, found.summaries


def with_holm(tests: Sequence[Record]) -> list[Record]:
    """Return tests with ``p_holm``, adjusted for all of them together."""
    adjusted = holm_adjusted([test["p"] for test in tests])
    return [{**test, "p_holm": p} for test, p in zip(tests, adjusted, strict=True)]


def _rivals(upscalers: Mapping[str, Upscaler]) -> list[tuple[str, str]]:
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


def _row(
    design: Design,
    condition: Condition,
    method: str,
    summary: Summary,
    decibels: Sequence[float],
) -> Record:
    return {
        "experiment": design.name,
        "option": condition.option,
        "ipd_px": condition.ipd_px,
        "pose": condition.pose,
        "lighting": condition.lighting,
        "compression": condition.compression,
        "method": method,
        "label": design.upscalers[method].label,
        "landmarks": "shared",
        **area_record(summary.area),
        "psnr_y_db": _finite(float(np.mean(decibels))) if len(decibels) else None,
        **rates_record(summary),
    }


def area_record(area: AucEstimate) -> Record:
    """Return what a row says of the area under the ROC curve."""
    return {name: value for name, value in asdict(area).items() if name not in _UNTOLD}


def rates_record(summary: Summary) -> Record:
    """Return what a row says of error rates."""
    return {
        "fta": summary.fta,
        "eer": summary.eer,
        "d_prime": summary.d_prime,
        "rank_1": None if summary.cmc is None else summary.cmc.rank_1,
        "fnmr": [asdict(point) for point in summary.fnmr],
        "partial_auc": [asdict(area) for area in summary.partial],
    }


def _comparison(condition: Condition, pair: tuple[str, str], test: AucComparison) -> Record:
    method, against = pair
    names = {"option": condition.option, "ipd_px": condition.ipd_px}
    return {**names, "method": method, "against": against, **comparison_record(test)}


def comparison_record(test: AucComparison) -> Record:
    """Return the numbers of a paired test, None for those that are infinite."""
    return {name: _finite(getattr(test, name)) for name in _TOLD}


def _finite(value: float | None) -> float | None:
    """Return a number as JSON has it; None for one that is infinite."""
    return float(value) if value is not None and math.isfinite(value) else None
