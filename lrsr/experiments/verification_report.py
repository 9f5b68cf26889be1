"""What does a verification experiment leave behind? ``results.json``, a report, contact sheets."""

import logging
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from lrsr.experiments.design import Design
from lrsr.experiments.report.page import Panel, Report, write_report
from lrsr.experiments.report.sheets import draw_contact_sheet
from lrsr.experiments.table import Row
from lrsr.experiments.trial import Outcome
from lrsr.files import write_bytes, write_json
from lrsr.provenance import versions
from lrsr.recognition import Engine

logger = logging.getLogger(__name__)

RENDERED = (
    "Every probe and every gallery picture shows a synthetic person, rendered by Mitsuba as light "
    "would make it; nobody shown was used in training.",
    "The true references are the same scene on a finer film: nothing was resampled or registered.",
)
DONE = (
    "Bicubic is the a = -0.5 kernel; SRCNN works on BT.601 luminance, chroma goes up bicubically.",
    "PSNR is that of BT.601 studio luminance, with as many pixels shaved as the factor, averaged "
    "over images.",
    "All methods share the renderer's true landmarks, so differences are not the detector's. Base "
    "is not free of interpolation: alignment enlarges it bilinearly to 112 pixels.",
    "Intervals are DeLong's; tests are paired, on the same pairs of pictures.",
)
NOT_DONE = (
    "No face detector was run: a detector's failures on such small faces come on top.",
    "The embedder was trained on rendered faces; figures for real faces will differ.",
)
FLAWLESS = "The camera has no colour filter mosaic, lens aberration or sensor noise."


def write_results(
    folder: Path, design: Design, engine: Engine, outcomes: Sequence[Outcome]
) -> Path:
    """Write everything into the folder of the run; return it.

    Args:
        folder: Receives ``results.json``, ``report.html`` and ``faces_1.png``, ...
        design: What was asked.
        engine: What recognised.
        outcomes: One for each condition.

    Raises:
        InputError: The folder cannot be written.
    """
    write_json(folder / "results.json", results(design, engine, outcomes))
    write_report(folder, report(design, engine, outcomes))
    for number, outcome in enumerate(outcomes, start=1):
        if outcome.pictures:
            sheet = draw_contact_sheet(outcome.pictures)
            write_bytes(folder / f"faces_{number}.png", sheet)
        for row in outcome.rows:
            logger.info("%s", _line(row))
    return folder


def results(design: Design, engine: Engine, outcomes: Sequence[Outcome]) -> Mapping[str, Any]:
    """Return what ``results.json`` holds: rows, comparisons, configuration, versions."""
    return {
        "rows": [asdict(row) for outcome in outcomes for row in outcome.rows],
        "comparisons": [asdict(test) for outcome in outcomes for test in outcome.comparisons],
        "config": design.describe(),
        "recognition": engine.describe(),
        "versions": versions(),
    }


def report(design: Design, engine: Engine, outcomes: Sequence[Outcome]) -> Report:
    """Return what ``report.html`` says; a camera without flaws is named among what was not done."""
    made_by = versions()
    rendered = design.probes_folder is None and design.gallery_folder is None
    flawless = design.camera.flawless and design.probes_folder is None
    return Report(
        title=design.name.replace("_", " ").capitalize(),
        question=design.question,
        settings={**design.describe(), "recognition": engine.describe()},
        rows=[asdict(row) for outcome in outcomes for row in outcome.rows],
        comparisons=[asdict(test) for outcome in outcomes for test in outcome.comparisons],
        panels=[_panel(outcome) for outcome in outcomes],
        done=(*(RENDERED if rendered else ()), *DONE),
        not_done=(*NOT_DONE, FLAWLESS) if flawless else NOT_DONE,
        versions=made_by,
        commit=made_by["git"],
        seed=design.seed,
    )


def _panel(outcome: Outcome) -> Panel:
    condition = outcome.condition
    words = [f"Option {condition.option}"]
    words += [] if condition.ipd_px is None else [f"IPD {condition.ipd_px:g} px"]
    if condition.scene is not None:
        words[-1] += f": pose {condition.pose}"
        words += [f"light {condition.lighting}", f"compression {condition.compression}"]
    return Panel(
        title=", ".join(words),
        curves={row.label: outcome.curves[row.method] for row in outcome.rows},
        pictures={name: images.numpy() for name, images in outcome.pictures.items()},
        people=outcome.people,
    )


def _line(row: Row) -> str:
    psnr = "" if row.psnr_y_db is None else f"  PSNR-Y {row.psnr_y_db:.2f} dB"
    size = "" if row.ipd_px is None else f"  IPD {row.ipd_px:g} px"
    return (
        f"option {row.option}{size}  {row.label:<9}"
        f"  AUC {row.auc:.4f} [{row.low:.4f}, {row.high:.4f}]{psnr}"
    )
