"""From settings to a folder with ``results.json`` and ``report.html``: one verification experiment."""

import logging
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from tqdm import tqdm

from lrsr.camera import Camera
from lrsr.data.cache import RenderCache
from lrsr.data.maker import Maker
from lrsr.experiments.settings import VerificationSettings
from lrsr.experiments.table import Row
from lrsr.experiments.verification import Outcome, Verification
from lrsr.files import write_json
from lrsr.provenance import versions
from lrsr.recognition import Engine

logger = logging.getLogger(__name__)


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
        folder: Of the run; receives ``results.json`` and ``report.html``.
        cache: Folder of the render cache.
        camera: Takes every picture.
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
    for outcome in outcomes:
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


def _line(row: Row) -> str:
    psnr = "" if row.psnr_y_db is None else f"  PSNR-Y {row.psnr_y_db:.2f} dB"
    return (
        f"option {row.option}  IPD {row.ipd_px:g} px  {row.label:<9}"
        f"  AUC {row.auc:.4f} [{row.low:.4f}, {row.high:.4f}]{psnr}"
    )
