"""How is it told what a score is worth in a case? One page: ratio, calibration, limits."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lrsr.evaluation.score_files.system import Name
from lrsr.experiments.report.curves import draw_ece, draw_tippett
from lrsr.experiments.report.lines import condition_of, several_sources
from lrsr.experiments.report.ratios import ratio_words
from lrsr.experiments.weighing import CASE, REAL, Weighed
from lrsr.pages import encode_face, title_of, write_page

if TYPE_CHECKING:
    import torch

_DONE = (
    "Half of the people were calibrated on, the other half were judged; nobody is in both, and "
    "pairs across the halves were left out.",
    "A likelihood ratio says how many times more probable such a score is where both pictures show "
    "one person than where they show two. Ratios are cut to the bounds that so many pairs can "
    "support (ELUB). Intervals are over people: of a ratio over those who were calibrated on, of a "
    "cost over those who were judged.",
    "Misleading: genuine pairs with a ratio below 1, impostor pairs above 1.",
)
_SIMULATED = (
    "Everybody who was calibrated on or judged is simulated. That ratios hold among simulated "
    "people shows that the calibration suits the simulation, and not that the simulation suits the "
    "case: a recogniser may score photographs otherwise than renderings, and real people differ in "
    "what no model here has. Only scores of real people (case.real_scores) can show that."
)
_LIMITS = (
    "Pose, light, size and expression are as they were given, and not estimated; that they, or the "
    "camera, may be other than that is not in the intervals.",
    "The other explanation is somebody drawn at random from the simulated population. For a "
    "brother, a look-alike, or somebody whom a search of a database brought up, the ratio is too "
    "high: identities.sex, ancestry and age_years narrow the population, and nothing here makes "
    "relatives.",
    "A ratio is no probability that it is the same person: that needs what else is known of the "
    "case.",
)


def write_case(
    folder: Path,
    results: Mapping[str, Any],
    found: Mapping[Name, Weighed],
    faces: Mapping[str, Sequence["torch.Tensor"]],
) -> Path:
    """Write ``report.html``; return its path.

    Args:
        folder: Of the run.
        results: What ``results.json`` holds.
        found: By system.
        faces: Pictures of the case and of the simulation, by heading; may be empty.

    Raises:
        InputError: The folder cannot be written.
    """
    rows, config = results["rows"], results["config"]
    several = several_sources(rows)
    conditions = [condition_of({**row, "option": None}, several) for row in rows]  # there is one
    titles = [f"{told}, {row['label']}" for told, row in zip(conditions, rows, strict=True)]
    real = any(line["judged_on"] == REAL for line in results["evidence"])
    return write_page(
        folder,
        "case",
        title=title_of(config["name"]),
        question=config["question"],
        answer=list(_answer(results)),
        systems=[
            {
                "title": title,
                "row": row,
                "evidence": [
                    {**line, "basis": _basis(line)}
                    for line in results["evidence"]
                    if _same(line, row)
                ],
                "ratios": [
                    {**line, "basis": _basis(line), "words": ratio_words(line, config["level"])}
                    for line in results["ratios"]
                    if _same(line, row)
                ],
                "figures": list(_figures(one)),
            }
            for title, row, one in zip(titles, rows, found.values(), strict=True)
        ],
        columns={label: [encode_face(face) for face in some] for label, some in faces.items()},
        pair=results["pair"],
        missing=results["missing"],
        level=f"{100 * config['level']:g} %",
        calibration=config["calibration"],
        settings={**config, "recognition": results["recognition"]},
        done=_DONE,
        not_done=[*(() if real else (_SIMULATED,)), *_LIMITS],
        versions=results["versions"],
        seed=config["seed"],
    )


def _same(line: Mapping[str, Any], row: Mapping[str, Any]) -> bool:
    names = ("recogniser", "option", "ipd_px", "landmarks", "method")
    return all(line[name] == row[name] for name in names)


def _basis(line: Mapping[str, Any]) -> str:
    """Return on what was calibrated, as part of a sentence."""
    name = str(line["calibrated_on"])
    return name if name in (CASE, REAL) else f"generic pictures ({name})"


def _answer(results: Mapping[str, Any]) -> Iterator[str]:
    """Yield what the score is worth, and how good the calibrations are."""
    level = results["config"]["level"]
    for one in results["ratios"]:
        who = " ".join(filter(None, (one["recogniser"], one["label"])))
        words = ratio_words(one, level)
        if one["calibrated_on"] == CASE:
            told = f"in this case a score of {one['score']:.3f} has the likelihood ratio"
            yield f"{who}: {told} {words}."
        else:
            yield f"{who}: calibrated on {_basis(one)} it would have {words}."
    judged: dict[str, list[Mapping[str, Any]]] = {}
    for one in results["evidence"]:
        who = " ".join(filter(None, (one["recogniser"], one["label"], one["landmarks"])))
        judged.setdefault(f"{who}, judged on {one['judged_on']}", []).append(one)
    for title, some in judged.items():
        costs = ", ".join(f"{one['cllr']:.3f} by {_basis(one)}" for one in some)
        bad = "; more than 1 is worse than no evidence" if any(o["cllr"] > 1 for o in some) else ""
        yield f"{title}: ratios cost (Cllr) {costs}{bad}."
    yield from results["missing"]


def _figures(one: Weighed) -> Iterator[dict[str, str]]:
    """Yield the curves of everything that was judged."""
    for judged, some in one.evidence.items():
        if some:
            told = f"judged on {judged}, by what was calibrated on"
            yield {
                "image": draw_tippett(some),
                "alt": f"Tippett plots {told}; the costs are those of the table",
                "caption": f"Tippett plots, {told}: the share of pairs with at least that ratio. "
                "Genuine pairs left of 0 and impostor pairs right of 0 mislead.",
            }
            yield {
                "image": draw_ece(some),
                "alt": f"Cross-entropy {told}; the costs are those of the table",
                "caption": f"Cross-entropy, {told}: what remains unknown after the ratio, at every "
                "prior. Above the dotted line the ratios do harm.",
            }
