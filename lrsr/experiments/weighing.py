"""How far do likelihood ratios depend on whose scores they were learned from?

One recogniser's scores of the people of a case are parted into two halves. Calibrations that were
learned on one half, on the same people pictured otherwise, or on real people, are judged on the
other half, and on real people, if there are any.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from lrsr.errors import ScoreError
from lrsr.evaluation.likelihood import Evidence, judge_evidence, split_people
from lrsr.evaluation.ratio import Ratio, ratio_of
from lrsr.evaluation.scores import ScoreSource
from lrsr.experiments.asked import Asked

CASE, REAL = "this case", "real people"
"""What reports call scores of the simulated case, and of real people."""


@dataclass(frozen=True, eq=False)
class Weighed:
    """What was found of one recogniser and method.

    Attributes:
        evidence: By who was judged (:data:`CASE`, :data:`REAL`), then by what was calibrated on.
        ratios: Of the case's score, by what was calibrated on; empty where there is no score.
        missing: Why something of that is not there.
    """

    evidence: Mapping[str, Mapping[str, Evidence]]
    ratios: Mapping[str, Ratio]
    missing: tuple[str, ...] = ()


def weigh_case(
    case: ScoreSource,
    generic: Mapping[str, ScoreSource],
    real: ScoreSource | None,
    score: float | None,
    asked: Asked,
) -> Weighed:
    """Calibrate on several sets of scores and judge each calibration on people who are in none.

    Args:
        case: Scores of people pictured as in the case.
        generic: By name, of people pictured otherwise; those who are judged are left out.
        real: Of real people pictured as in the case.
        score: Whose ratio is asked for.
        asked: How.
    """
    learn, judge = split_people(case, asked.seed)
    bases = {CASE: case.restricted(learn)}
    for name, source in generic.items():
        others = {*source.probe_ids, *source.gallery_ids} - {*judge}
        bases[name] = source.restricted(sorted(others))
    judged = {CASE: case.restricted(judge)}
    if real is not None:
        learn, judge = split_people(real, asked.seed)
        bases[REAL], judged[REAL] = real.restricted(learn), real.restricted(judge)
    missing: list[str] = []
    evidence: dict[str, dict[str, Evidence]] = {}
    how = {"bootstrap": asked.bootstrap, "seed": asked.seed}
    for people, test in judged.items():
        evidence[people] = {}
        for name, basis in bases.items():
            try:
                found = judge_evidence(basis, test, asked.calibration, **how, level=asked.level)
                evidence[people][name] = found
            except ScoreError as error:
                missing.append(f"Calibrated on {name}, judged on {people}: {error}.")
    ratios: dict[str, Ratio] = {}
    for name, basis in bases.items() if score is not None else ():
        try:
            ratios[name] = ratio_of(
                score or 0.0, basis, asked.calibration, **how, level=asked.level
            )
        except ScoreError as error:
            missing.append(f"The score calibrated on {name}: {error}.")
    return Weighed(evidence, ratios, tuple(dict.fromkeys(missing)))
