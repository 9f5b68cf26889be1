"""What does a verification experiment report? Rows and comparisons, as in ``results.json``."""

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, fields
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from lrsr.errors import ScoreError
from lrsr.evaluation.delong import AucComparison, AucEstimate
from lrsr.evaluation.multiplicity import holm_adjusted
from lrsr.evaluation.scores import ScoreSource
from lrsr.evaluation.summary import Evaluation, Summary, summarise
from lrsr.experiments.conditions import Condition
from lrsr.experiments.design import Design
from lrsr.experiments.likeness import MEASURES
from lrsr.experiments.seen import WRONG_PLACE_IPDS
from lrsr.experiments.several import Several
from lrsr.recognition.settings import Landmarks
from lrsr.sr.upscaler import Upscaler

Record = dict[str, Any]
"""A line of ``results.json`` in plain values."""

FALSE_FACES = "false_faces"
"""A mean over the probes, as those of :data:`~lrsr.experiments.likeness.MEASURES`."""

_UNTOLD = ("wald_leaves_range", "degenerate")
_AREA = tuple(one.name for one in fields(AucEstimate) if one.name not in _UNTOLD)
_TOLD = (
    *("difference", "low", "high", "subject_low", "subject_high"),
    *("bootstrap_low", "bootstrap_high", "z", "p", "log10_p", "bootstrap_p"),
)


def evaluate(
    design: Design,
    condition: Condition,
    scores: Mapping[str, ScoreSource],
    likeness: Mapping[str, Mapping[str, Sequence[float]]],
    landmarks: Landmarks = "shared",
    errors: Mapping[str, ArrayLike] | None = None,
    rivals: Mapping[str, ScoreSource] | None = None,
) -> tuple[list[Record], list[Record], Mapping[str, Summary]]:
    """Evaluate all methods under one condition with landmarks of one source, and test pairs.

    Args:
        design: What was asked.
        condition: Of the probes.
        scores: By method.
        likeness: By method and measure, how like its reference each probe became, see
            :mod:`lrsr.experiments.likeness`, and how many false faces were found on it; empty where
            that is not known.
        landmarks: Their source.
        errors: By method, of each probe's landmarks in distances of the true eyes; NaN where no
            face was found or the true ones are not known.
        rivals: By method, the scores of the same people under the condition's rival; those that
            are there are tested against.

    Returns:
        A row a method, the paired tests, and the summary of each method. A row names experiment,
        option, its setting in words where it has one, ipd_px, pose, lighting and compression of the
        probe (empty or None where a photograph's are not known), camera, skin, detector, method,
        label, frames and landmarks; holds the numbers of
        :class:`~lrsr.evaluation.delong.AucEstimate`; psnr_y_db (mean over the probes; None where
        nothing is enlarged or a probe equals its reference), fta, eer, d_prime, rank_1; fnmr, an
        :class:`~lrsr.evaluation.rates.OperatingPoint` for each target FMR; wrong_place, the share
        of the faces found whose landmarks are more than :data:`WRONG_PLACE_IPDS` off, and
        landmark_distance_ipds, how far they are off on average, both None where that is not known;
        and :data:`FALSE_FACES` and the other :data:`~lrsr.experiments.likeness.MEASURES` as means
        over the probes for which they are known. Where faces were found on so few pictures that
        nothing can be measured, all but counts, fta, likeness and landmarks is None, fnmr is empty
        and there is no curve. A test names option, setting, ipd_px, landmarks, method, against,
        against_option and against_ipd_px, which are those of the condition or of its rival, and
        holds the numbers of :class:`~lrsr.evaluation.delong.AucComparison`, None for those that are
        infinite.

    Raises:
        ScoreError: Fewer than two genuine or impostor scores are left, although nothing failed.
    """
    here = condition.option, condition.ipd_px
    keyed = {pair: _Pair(*pair, *here) for pair in _rivals(design.upscalers)}
    others = {f"{method} of the rival": one for method, one in (rivals or {}).items()}
    keyed |= {
        (method, other): _Pair(method, method, *(condition.rival or here))
        for method, other in zip(rivals or {}, others, strict=True)
    }
    found = _measure({**scores, **others}, [*keyed], design)
    rows = []
    for method, source in scores.items():
        summary = found.summaries.get(method)
        numbers = counts_record(source) if summary is None else _numbers(summary)
        off = (errors or {}).get(method, ())
        means = {name: _mean(likeness[method].get(name, ())) for name in (*MEASURES, FALSE_FACES)}
        told = _names(design, condition, method, landmarks)
        places = {"wrong_place": _share_beyond(off), "landmark_distance_ipds": _mean(off)}
        rows.append({**told, **numbers, **places, **means})
    tests = [
        _comparison(condition, landmarks, pair, found.comparisons[key])
        for key, pair in keyed.items()
        if key in found.comparisons
    ]
    return rows, tests, {name: one for name, one in found.summaries.items() if name in scores}


def with_holm(tests: Sequence[Record]) -> list[Record]:
    """Return tests with ``p_holm``, adjusted for all of them together."""
    adjusted = holm_adjusted([test["p"] for test in tests])
    return [{**test, "p_holm": p} for test, p in zip(tests, adjusted, strict=True)]


def _measure(
    scores: Mapping[str, ScoreSource], pairs: Sequence[tuple[str, str]], design: Design
) -> Evaluation:
    """Summarise all methods, or those of which enough was acquired.

    Raises:
        ScoreError: Nothing failed to be acquired, and there are too few scores all the same.
    """
    measure = partial(summarise, level=design.level, bootstrap=design.bootstrap, seed=design.seed)
    try:
        return measure(scores, pairs=pairs)
    except ScoreError:
        if all(source.complete for source in scores.values()):
            raise
    summaries: dict[str, Summary] = {}
    comparisons: dict[tuple[str, str], AucComparison] = {}
    for method, source in scores.items():
        with suppress(ScoreError):
            summaries |= measure({method: source}, pairs=()).summaries
    for pair in pairs:
        both = {method: scores[method] for method in pair if method in summaries}
        with suppress(ScoreError):
            comparisons |= measure(both, pairs=[pair]).comparisons
    return Evaluation(summaries, comparisons)


def _rivals(upscalers: Mapping[str, Upscaler | Several]) -> list[tuple[str, str]]:
    """Pair every method with the picture as it is, and every learned one with its bicubic.

    One that takes several frames is paired with itself on one. The bicubic of a learned method is
    the one that enlarges as much; what is not among the methods is not compared with.
    """
    plain = {
        upscaler.scale: name
        for name, upscaler in upscalers.items()
        if not (upscaler.learned or isinstance(upscaler, Several))
    }
    return [
        (name, against)
        for name, upscaler in upscalers.items()
        for against in dict.fromkeys(
            (
                plain.get(1),
                plain.get(upscaler.scale) if upscaler.learned else None,
                upscaler.alone if isinstance(upscaler, Several) else None,
            )
        )
        if against is not None and against in upscalers and against != name
    ]


class _Pair(NamedTuple):
    """A method, and which it is tested against under which option and at which size."""

    method: str
    against: str
    option: int
    ipd_px: float | None


def _names(design: Design, condition: Condition, method: str, landmarks: Landmarks) -> Record:
    return {
        "experiment": design.name,
        "option": condition.option,
        "setting": condition.setting,
        "ipd_px": condition.ipd_px,
        "pose": condition.pose,
        "lighting": condition.lighting,
        "compression": condition.compression,
        **design.means_of(condition),
        "method": method,
        "label": design.upscalers[method].label,
        "frames": getattr(design.upscalers[method], "frames", 1),
        "landmarks": landmarks,
    }


def _numbers(summary: Summary) -> Record:
    return {**area_record(summary.area), "psnr_y_db": None, **rates_record(summary)}


def area_record(area: AucEstimate) -> Record:
    """Return what a row says of the area under the ROC curve."""
    return {name: getattr(area, name) for name in _AREA}


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


def counts_record(source: ScoreSource) -> Record:
    """Return a row's numbers where too little was acquired to measure anything else."""
    failed = [tile.absent.all(axis=1) for tile in source.tiles()]
    return {
        **dict.fromkeys(_AREA),
        "n_genuine": source.genuine().size,
        "n_impostor": source.impostor().size,
        "psnr_y_db": None,
        "fta": float(np.concatenate(failed).mean()),
        **dict.fromkeys(("eer", "d_prime", "rank_1")),
        "fnmr": [],
        "partial_auc": [],
    }


def _mean(values: ArrayLike) -> float | None:
    """Return the mean of what is known; None where that is nothing, or infinite."""
    given = np.asarray(values, dtype=np.float64)
    known = given[~np.isnan(given)]
    return _finite(float(known.mean())) if known.size else None


def _share_beyond(errors: ArrayLike) -> float | None:
    """Return the share of the errors that are known and too large."""
    known = np.asarray(errors, dtype=np.float64)
    known = known[np.isfinite(known)]
    return float((known > WRONG_PLACE_IPDS).mean()) if known.size else None


def _comparison(
    condition: Condition, landmarks: Landmarks, pair: _Pair, test: AucComparison
) -> Record:
    return {
        "option": condition.option,
        "setting": condition.setting,
        "ipd_px": condition.ipd_px,
        "landmarks": landmarks,
        "method": pair.method,
        "against": pair.against,
        "against_option": pair.option,
        "against_ipd_px": pair.ipd_px,
        **comparison_record(test),
    }


def comparison_record(test: AucComparison) -> Record:
    """Return the numbers of a paired test, None for those that are infinite."""
    return {name: _finite(getattr(test, name)) for name in _TOLD}


def _finite(value: float | None) -> float | None:
    """Return a number as JSON has it; None for one that is infinite."""
    return float(value) if value is not None and math.isfinite(value) else None
