"""One verification experiment, from settings to ``results.json`` and ``report.html``."""

import logging
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from tqdm import tqdm

from lrsr.camera import Camera
from lrsr.data.cache import RenderCache
from lrsr.data.maker import Maker
from lrsr.evaluation.roc import trace_roc
from lrsr.experiments.contact_sheet import write_contact_sheet
from lrsr.experiments.report import Panel, Report, write_report
from lrsr.experiments.settings import VerificationSettings
from lrsr.experiments.table import Row
from lrsr.experiments.verification import Outcome, Verification
from lrsr.files import write_json
from lrsr.provenance import versions
from lrsr.recognition import Engine

logger = logging.getLogger(__name__)

DONE = (
    "Every probe and every gallery picture shows a synthetic person, rendered by Mitsuba as light "
    "would make it; nobody shown was used in training.",
    "The true references are the same scene on a finer film: nothing was resampled or registered.",
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


def verify(
    settings: VerificationSettings,
    folder: Path,
    *,
    cache: Path,
    camera: Camera,
    model: Path | None = None,
    maker: Maker | None = None,
    progress: bool = True,
) -> Path:
    """Run a verification experiment and write its results and its report.

    Args:
        settings: What is asked.
        folder: Of the run; receives ``results.json``, ``report.html`` and ``faces_1.png``, ...
        cache: Folder of the render cache.
        camera: Takes the probes; see :class:`lrsr.experiments.verification.Verification`.
        model: ONNX embedder with its contract beside it; None: the one that ships.
        maker: Renders; Mitsuba when None.
        progress: Show bars on stderr.

    Returns:
        ``folder``.

    Raises:
        InputError: A setting, a file or a folder is wrong; nothing has been rendered by then.
    """
    engine = Engine(model)
    experiment = Verification(settings, RenderCache(cache), engine, camera, maker)
    experiment.render(progress=progress)
    outcomes = list(
        tqdm(
            experiment.outcomes(),
            total=len(settings.conditions),
            desc="scoring",
            unit="condition",
            disable=not progress,
        )
    )
    write_json(folder / "results.json", results(settings, engine, outcomes))
    write_report(folder, report(settings, engine, outcomes, flawless=camera.flawless))
    for number, outcome in enumerate(outcomes, start=1):
        write_contact_sheet(folder / f"faces_{number}.png", outcome.pictures)
        for row in outcome.rows:
            logger.info("%s", _line(row))
    return folder


def results(
    settings: VerificationSettings, engine: Engine, outcomes: Sequence[Outcome]
) -> Mapping[str, Any]:
    """Return what ``results.json`` holds: rows, comparisons, configuration, versions."""
    return {
        "rows": [asdict(row) for outcome in outcomes for row in outcome.rows],
        "comparisons": [asdict(test) for outcome in outcomes for test in outcome.comparisons],
        "config": asdict(settings),
        "recognition": engine.describe(),
        "versions": versions(),
    }


def report(
    settings: VerificationSettings,
    engine: Engine,
    outcomes: Sequence[Outcome],
    *,
    flawless: bool = True,
) -> Report:
    """Return what ``report.html`` says; a camera without flaws is named among what was not done."""
    made_by = versions()
    return Report(
        title=settings.name.replace("_", " ").capitalize(),
        question=settings.question,
        settings={**asdict(settings), "recognition": engine.describe()},
        rows=[asdict(row) for outcome in outcomes for row in outcome.rows],
        comparisons=[asdict(test) for outcome in outcomes for test in outcome.comparisons],
        panels=[_panel(outcome) for outcome in outcomes],
        done=DONE,
        not_done=(*NOT_DONE, FLAWLESS) if flawless else NOT_DONE,
        versions=made_by,
        commit=made_by["git"],
        seed=settings.seed,
    )


def _panel(outcome: Outcome) -> Panel:
    condition, people = outcome.condition, next(iter(outcome.scores.values())).probe_ids
    shown = len(next(iter(outcome.pictures.values())))
    return Panel(
        title=(
            f"Option {condition.option}, IPD {condition.ipd_px:g} px: pose {condition.pose}, light "
            f"{condition.lighting}, compression {condition.compression}"
        ),
        curves={
            row.label: trace_roc(scores.genuine(), scores.impostor())
            for row, scores in zip(outcome.rows, outcome.scores.values(), strict=True)
        },
        pictures={name: images.numpy() for name, images in outcome.pictures.items()},
        people=people[:shown],
    )


def _line(row: Row) -> str:
    psnr = "" if row.psnr_y_db is None else f"  PSNR-Y {row.psnr_y_db:.2f} dB"
    return (
        f"option {row.option}  IPD {row.ipd_px:g} px  {row.label:<9}"
        f"  AUC {row.auc:.4f} [{row.low:.4f}, {row.high:.4f}]{psnr}"
    )
