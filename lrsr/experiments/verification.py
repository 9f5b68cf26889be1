"""Does this way of enlarging help to tell people apart, and under which conditions?"""

import logging
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from tqdm import tqdm

from lrsr.experiments.design import Design
from lrsr.experiments.report.page import write_report
from lrsr.experiments.report.sheets import draw_contact_sheet
from lrsr.experiments.table import Record
from lrsr.experiments.trial import Outcome, Trial
from lrsr.files import write_bytes, write_json
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.maker import Maker
from lrsr.provenance import versions
from lrsr.recognition.recognisers import load_recognisers

_RENDERED = (
    "Every probe and every gallery picture shows a synthetic person, rendered by Mitsuba as light "
    "would make it; nobody shown was used in training.",
    "The true references are the same scene on a finer film: nothing was resampled or registered.",
)
_DONE = (
    "Bicubic is the a = -0.5 kernel; SRCNN works on BT.601 luminance, chroma goes up bicubically.",
    "PSNR is that of BT.601 studio luminance, with as many pixels shaved as the factor, averaged "
    "over images.",
    "All methods share the renderer's true landmarks, so differences are not the detector's. Base "
    "is not free of interpolation: alignment enlarges it bilinearly to 112 pixels.",
    "Intervals are DeLong's; tests are paired, on the same pairs of pictures.",
)
_NOT_DONE = (
    "No face detector was run: a detector's failures on such small faces come on top.",
    "The embedder was trained on rendered faces; figures for real faces will differ.",
)
_FLAWLESS = "The camera has no colour filter mosaic, lens aberration or sensor noise."

logger = logging.getLogger(__name__)


class Verification(Design):
    """Compares everybody with everybody, under each condition, after each way of enlarging."""

    def run(
        self,
        folder: Path,
        cache: RenderCache,
        *,
        maker: Maker | None = None,
        progress: bool = True,
    ) -> Path:
        """Write ``results.json``, ``report.html`` and ``faces_1.png``, ... into ``folder``.

        Args:
            folder: Of the run.
            cache: Where renderings are kept.
            maker: Renders; Mitsuba when None.
            progress: Show bars on stderr.

        Raises:
            InputError: A file or a folder is wrong; nothing has been rendered by then.
        """
        engines = load_recognisers(self.recognisers, self.model, device=self.device)
        outcomes: list[Outcome] = []
        for name, engine in engines.items():
            trial = Trial(self, cache, engine, maker, name=name, progress=progress)
            trial.render()
            scored, total = trial.outcomes(), len(self.conditions)
            bar = tqdm(scored, f"scoring, {name}", total, unit="condition", disable=not progress)
            outcomes += bar if len(engines) == 1 else (_told_by(name, bar, faces=not outcomes))
        results: dict[str, Any] = {
            "rows": [row for outcome in outcomes for row in outcome.rows],
            "comparisons": [test for outcome in outcomes for test in outcome.comparisons],
            "config": self.describe(),
            "recognition": {name: dict(engine.describe()) for name, engine in engines.items()},
            "versions": versions(),
        }
        write_json(folder / "results.json", results)
        self._write_report(folder, results, outcomes)
        for row in results["rows"]:
            logger.info("%s", _line(row))
        return folder

    def _write_report(self, folder: Path, results: dict[str, Any], outcomes: list[Outcome]) -> None:
        """Write page and contact sheets; a camera without flaws is among what was not done."""
        panels = [outcome.panel for outcome in outcomes]
        rendered = self.probes_folder is None and self.gallery_folder is None
        flawless = self.camera.flawless and self.probes_folder is None
        done = (*(_RENDERED if rendered else ()), *_DONE)
        not_done = (*_NOT_DONE, *([_FLAWLESS] if flawless else []))
        write_report(folder, results, panels, done=done, not_done=not_done)
        for number, panel in enumerate(panels, start=1):
            if panel.pictures:
                write_bytes(folder / f"faces_{number}.png", draw_contact_sheet(panel.pictures))


def _told_by(name: str, outcomes: Iterable[Outcome], *, faces: bool) -> Iterator[Outcome]:
    """Let titles say which recogniser it was; the faces are the same for all, and shown once."""
    for outcome in outcomes:
        panel = replace(outcome.panel, title=f"{name}. {outcome.panel.title}")
        yield replace(outcome, panel=panel if faces else replace(panel, pictures={}, people=()))


def _line(row: Record) -> str:
    psnr = "" if row["psnr_y_db"] is None else f"  PSNR-Y {row['psnr_y_db']:.2f} dB"
    size = "" if row["ipd_px"] is None else f"  IPD {row['ipd_px']:g} px"
    return (
        f"{row['recogniser']}  option {row['option']}{size}  {row['label']:<9}"
        f"  AUC {row['auc']:.4f} [{row['low']:.4f}, {row['high']:.4f}]{psnr}"
    )
