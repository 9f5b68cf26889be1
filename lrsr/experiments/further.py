"""What else do the scores of one condition say? Evidence, groups, quality; with their curves."""

import logging
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field

import numpy as np

from lrsr.errors import ScoreError
from lrsr.evaluation.discard import DiscardCurve, error_against_discard
from lrsr.evaluation.groups import rates_of_group
from lrsr.evaluation.likelihood import Evidence, weigh_evidence
from lrsr.evaluation.rates import OperatingPoint
from lrsr.evaluation.score_files.system import System
from lrsr.evaluation.summary import Summary
from lrsr.experiments.asked import Asked
from lrsr.experiments.labels import Labels
from lrsr.experiments.report.curves import draw_det_and_cmc, draw_discard, draw_ece, draw_tippett
from lrsr.experiments.report.panel import Figure
from lrsr.experiments.table import Record

_FEWEST = 10
"""People below which a group is not told of."""

_FMR = 0.01
"""Of the threshold at which groups and qualities are compared, where the data suffice."""

_MOST_PAIRS = 10**8
"""Pairs from which on nothing is calibrated: a quarter of them would have to be in memory."""

_ENDS = ("", "_low", "_high")

logger = logging.getLogger(__name__)


NAMES = ("option", "setting", "ipd_px", "method", "label", "landmarks", "recogniser")
"""What names a method under a condition in every record."""


@dataclass(frozen=True)
class Further:
    """Further results of one condition.

    Attributes:
        likelihood_ratios: A record a method; none where there are too few people.
        groups: A record a method, trait and group.
        discards: A record a method and measure of quality.
        figures: For the report.
    """

    likelihood_ratios: Sequence[Record] = ()
    groups: Sequence[Record] = ()
    discards: Sequence[Record] = ()
    figures: Sequence[Figure] = field(default_factory=list)


def gather(found: Sequence[Further]) -> dict[str, list[Record]]:
    """Return the records of all conditions, as in ``results.json``."""
    return {
        "likelihood_ratios": [record for one in found for record in one.likelihood_ratios],
        "groups": [record for one in found for record in one.groups],
        "discards": [record for one in found for record in one.discards],
    }


def look_further(
    asked: Asked,
    about: Mapping[str, Record],
    systems: Mapping[str, System],
    summaries: Mapping[str, Summary],
    people: Mapping[str, Labels],
    *,
    draw: bool = True,
) -> Further:
    """Find further results of one condition.

    Args:
        asked: How.
        about: By method, what names it in a record: option, ipd_px, method, label, landmarks ...
        systems: By method.
        summaries: By method, of the same scores; of those that have none nothing is told.
        people: To which groups each belongs; may be empty.
        draw: With figures.
    """
    systems = {method: system for method, system in systems.items() if method in summaries}
    if not systems:
        return Further()
    titles = {method: str(about[method]["label"]) for method in systems}
    evidence = _evidence(asked, systems)
    curves, discards = _discards(asked, systems, summaries)
    return Further(
        [about[method] | evidence_record(found) for method, found in evidence.items()],
        [
            about[method] | record
            for method, system in systems.items()
            for record in _groups(asked, system, summaries[method], people)
        ],
        [about[record.pop("method")] | record for record in discards],
        _figures(titles, summaries, evidence, curves) if draw else (),
    )


def _evidence(asked: Asked, systems: Mapping[str, System]) -> dict[str, Evidence]:
    """Weigh every method that has people enough."""
    found = {}
    for method, system in systems.items():
        if system.source.n_pairs > _MOST_PAIRS:
            logger.info("no likelihood ratios of %s: %d pairs", method, system.source.n_pairs)
            continue
        try:
            found[method] = weigh_evidence(
                system.source,
                asked.calibration,
                bootstrap=asked.bootstrap,
                seed=asked.seed,
                level=asked.level,
            )
        except ScoreError as error:
            logger.info("no likelihood ratios of %s: %s", method, error)
    return found


def evidence_record(evidence: Evidence) -> Record:
    """Return the numbers of a record: those of curves are for pictures."""
    costs = {
        f"{name}{end}": value
        for name in ("cllr", "cllr_min", "cllr_cal")
        for end, value in zip(
            ("", "_low", "_high"), asdict(getattr(evidence, name)).values(), strict=True
        )
    }
    others = ("bound_low", "bound_high", "misleading_genuine", "misleading_impostor")
    numbers = ("n_development", "n_test", "n_genuine", "n_impostor")
    told = {name: getattr(evidence, name) for name in ("calibration", *others, *numbers)}
    return told | costs


def _threshold_of(points: Sequence[OperatingPoint]) -> OperatingPoint | None:
    """Return the operating point of FMR 0.01, of a larger one where that expects too few errors."""
    sure = (
        one
        for one in points
        if not one.few_false_matches and one.threshold is not None and one.target_fmr >= _FMR
    )
    return min(sure, key=lambda point: point.target_fmr, default=None)


def _groups(
    asked: Asked, system: System, summary: Summary, people: Mapping[str, Labels]
) -> list[Record]:
    point = _threshold_of(summary.fnmr)
    if point is None or point.threshold is None or not people:
        return []
    members: dict[tuple[str, str], set[str]] = {}
    for person in {*system.source.probe_ids}:
        for trait, group in people.get(person, {}).items():
            members.setdefault((trait, group), set()).add(person)
    records = []
    for (trait, group), some in sorted(members.items()):
        if len(some) < _FEWEST:
            continue
        try:
            rates = rates_of_group(
                system.source,
                some,
                point.threshold,
                bootstrap=asked.bootstrap,
                seed=asked.seed,
                level=asked.level,
            )
        except ScoreError as error:
            logger.info("no rates of %s %s: %s", trait, group, error)
            continue
        names = {"trait": trait, "group": group, "target_fmr": point.target_fmr}
        records.append(names | asdict(rates))
    return records


def _discards(
    asked: Asked, systems: Mapping[str, System], summaries: Mapping[str, Summary]
) -> tuple[dict[str, dict[str, DiscardCurve]], list[Record]]:
    curves: dict[str, dict[str, DiscardCurve]] = {}
    records = []
    for method, system in systems.items():
        point, source = _threshold_of(summaries[method].fnmr), system.source
        for measure, worth in system.qualities.items():
            known = np.asarray(worth, dtype=np.float64)
            if (
                point is None
                or point.threshold is None
                or np.unique(known[known == known]).size < 2
            ):
                continue
            curve = error_against_discard(
                source.mated_scores(), known[source.mates[0]], point.threshold, level=asked.level
            )
            curves.setdefault(measure, {})[method] = curve
            at = {share: _at(curve, share) for share in (0.0, 0.1, 0.2, 0.3)}
            records.append(
                {
                    "method": method,
                    "quality": measure,
                    "target_fmr": point.target_fmr,
                    **{f"fnmr_{round(100 * share)}": fnmr for share, fnmr in at.items()},
                }
            )
    return curves, records


def _at(curve: DiscardCurve, share: float) -> float:
    return float(curve.fnmr[np.searchsorted(curve.discarded, share, side="right") - 1])


def _figures(
    titles: Mapping[str, str],
    summaries: Mapping[str, Summary],
    evidence: Mapping[str, Evidence],
    curves: Mapping[str, Mapping[str, DiscardCurve]],
) -> list[Figure]:
    roc = {titles[method]: summary.curve for method, summary in summaries.items()}
    ranks = {
        titles[method]: summary.cmc
        for method, summary in summaries.items()
        if summary.cmc is not None
    }
    figures = [
        Figure(
            draw_det_and_cmc(roc, ranks),
            "DET curves of every method" + (" and its hits by rank" if ranks else ""),
            "DET: both error rates on normal-deviate axes, nearer to the lower left is better; an "
            "error rate of 0 is drawn as half an error."
            + (" CMC: closed gallery; a failure to acquire is a miss." if ranks else ""),
        )
    ]
    if evidence:
        named = {titles[method]: one for method, one in evidence.items()}
        figures += [
            Figure(
                draw_tippett(named),
                "Tippett plots of every method; the costs are those of the table",
                "Tippett plots of the people who were not calibrated on: the share of pairs with "
                "at least that likelihood ratio. Genuine pairs left of 0 and impostor pairs right "
                "of 0 mislead. Bands are over people.",
            ),
            Figure(
                draw_ece(named),
                "Empirical cross-entropy of every method; the costs are those of the table",
                "Cross-entropy: what remains unknown after the ratio, at every prior; Cllr is its "
                "value at odds 0. Above the dotted line the ratios do harm; down to the dashed "
                "line a better calibration could bring them.",
            ),
        ]
    if curves:
        by_label = {
            measure: {titles[method]: curve for method, curve in found.items()}
            for measure, found in curves.items()
        }
        figures.append(
            Figure(
                draw_discard(by_label),
                "FNMR against the share of probes discarded, for each measure of quality",
                "Error against discard: the FNMR of what is left when the probes of the lowest "
                "quality are refused; the threshold stays. Failures to acquire count as errors.",
            )
        )
    return figures
