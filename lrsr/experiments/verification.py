"""Does this way of enlarging help to tell people apart, and under which conditions?"""

import logging
from collections.abc import Iterable, Iterator, Mapping
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any

from tqdm import tqdm

from lrsr.evaluation.score_files.writing import score_file
from lrsr.experiments.design import Design
from lrsr.experiments.further import gather
from lrsr.experiments.report.overview import Overview, draw_conditions
from lrsr.experiments.report.page import write_report
from lrsr.experiments.report.sentences import about_recognition
from lrsr.experiments.report.sheets import draw_contact_sheet
from lrsr.experiments.table import Record, with_holm
from lrsr.experiments.trial import Outcome, Trial
from lrsr.files import write_bytes, write_json
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.maker import Maker
from lrsr.provenance import versions
from lrsr.recognition.finder import Finder
from lrsr.recognition.memory import Memory
from lrsr.recognition.settings import Landmarks
from lrsr.sr.perceptual import PerceptualDistance

_RENDERED = (
    "Every probe and every gallery picture shows a synthetic person, rendered by Mitsuba as light "
    "would make it; nobody shown was used in training.",
    "The true references are the same scene on a finer film: nothing was resampled or registered.",
)
_DONE = (
    "Bicubic is the a = -0.5 kernel; SRCNN works on BT.601 luminance, chroma goes up bicubically.",
    "PSNR is that of BT.601 studio luminance, with as many pixels shaved as the factor, averaged "
    "over images; SSIM is of the same luminance, in Gaussian windows of 11x11.",
    "Identity is how alike the recogniser finds a method's picture and the true reference, both "
    "aligned with the true landmarks: for embeddings the cosine.",
    "Base is not free of interpolation: alignment enlarges it bilinearly to 112 pixels.",
    "Intervals are DeLong's; tests are paired, on the same pairs of pictures. Beside them stands "
    "the bootstrap: whole people drawn with replacement, the same draws for all methods.",
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
        """Write ``results.json``, ``report.html``, ``scores.csv`` and ``faces_1.png``, ... .

        Where axes are gone through, ``conditions.png`` shows all of it side by side. Of a share of
        the people pictures are rendered, and nothing is written.

        Args:
            folder: Of the run; all goes into it.
            cache: Where renderings are kept.
            maker: Renders; Mitsuba when None.
            progress: Show bars on stderr.

        Raises:
            InputError: A file or a folder is wrong; nothing has been rendered by then.
        """
        memory = Memory(cache.folder / "recognition")
        engines, finders = self.recognition.engines(memory), self._finders(memory)
        looks = (
            PerceptualDistance(self.lpips, device=self.recognition.device) if self.lpips else None
        )
        trials = [
            Trial(self, cache, engine, maker, finders, name, progress, looks)
            for name, engine in engines.items()
        ]
        landmarks = trials[0].landmarks  # refused before anything is rendered
        if self.share is not None:
            count = trials[0].render()
            logger.info("part %d of %d: %d pictures were lacking", *self.share, count)
            return folder
        outcomes: list[Outcome] = []
        with score_file(folder) if self.save_scores else nullcontext() as table:
            for trial in trials:
                trial.render()
                scored, total = trial.outcomes(table), len(self.conditions)
                what = "scoring" if len(trials) == 1 else f"scoring, {trial.name}"
                bar = tqdm(scored, what, total, unit="condition", disable=not progress)
                several = len(trials) > 1
                outcomes += _told_by(trial.name, bar, faces=not outcomes) if several else bar
        results: dict[str, Any] = {
            "rows": [row for outcome in outcomes for row in outcome.rows],
            "comparisons": with_holm(
                [test for outcome in outcomes for test in outcome.comparisons]
            ),
            **gather([one for outcome in outcomes for one in outcome.further]),
            "config": {**self.describe(), "lpips": looks and looks.describe()},
            "recognition": {
                "recognisers": {name: dict(engine.describe()) for name, engine in engines.items()},
                **_described(finders),
            },
            "versions": versions(),
        }
        write_json(folder / "results.json", results)
        self._write_report(folder, results, outcomes, landmarks)
        for row in results["rows"]:
            logger.info("%s", _line(row))
        return folder

    def _finders(self, memory: Memory) -> dict[str | None, Finder]:
        """Load every detector that a condition asks for; none where nothing is to be found."""
        names = dict.fromkeys(condition.detector for condition in self.conditions)
        found = {name: self.recognition.finder(memory, name) for name in names}
        return {name: finder for name, finder in found.items() if finder is not None}

    def _write_report(
        self,
        folder: Path,
        results: dict[str, Any],
        outcomes: list[Outcome],
        landmarks: tuple[Landmarks, ...],
    ) -> None:
        """Write page and contact sheets; a camera without flaws is among what was not done."""
        panels = [outcome.panel for outcome in outcomes]
        rendered = self.probes_folder is None and self.gallery_folder is None
        rendered = rendered and self.people.photographs is None
        cameras = [condition.camera or self.camera for condition in self.conditions]
        flawless = all(camera.flawless for camera in cameras) and self.probes_folder is None
        told, untold = about_recognition(self.recognition, landmarks)
        done = (*(_RENDERED if rendered else ()), *_DONE, *told)
        not_done = (*untold, *([_FLAWLESS] if flawless else []))
        write_report(folder, results, panels, done=done, not_done=not_done)
        for number, panel in enumerate(panels if self.details else [], start=1):
            if panel.pictures:
                write_bytes(folder / f"faces_{number}.png", draw_contact_sheet(panel.pictures))
        grids = Overview(results["config"]).faces(panels)
        if grids:
            write_bytes(folder / "conditions.png", draw_conditions(grids))


def _described(finders: Mapping[str | None, Finder]) -> dict[str, Any]:
    """Describe the detector, or each by its name where there are several."""
    told = {str(name): finder.detector.describe() for name, finder in finders.items()}
    if len(told) > 1:
        return {"detectors": told}
    return dict(zip(["detector"], told.values(), strict=False))


def _told_by(name: str, outcomes: Iterable[Outcome], *, faces: bool) -> Iterator[Outcome]:
    """Let titles say which recogniser it was; the faces are the same for all, and shown once."""
    for outcome in outcomes:
        panel = replace(outcome.panel, title=f"{name}. {outcome.panel.title}")
        yield replace(outcome, panel=panel if faces else replace(panel, pictures={}, people=()))


def _line(row: Record) -> str:
    psnr = "" if row["psnr_y_db"] is None else f"  PSNR-Y {row['psnr_y_db']:.2f} dB"
    size = "" if row["ipd_px"] is None else f"  IPD {row['ipd_px']:g} px"
    option = row["setting"] or f"option {row['option']}"
    told = f"{row['recogniser']}  {option}{size}  {row['landmarks']:<6}"
    told += f"  {row['label']:<9}"
    if row["auc"] is None:
        return f"{told}  too few faces were found (FTA {row['fta']:.3f})"
    fta = f"  FTA {row['fta']:.3f}" if row["fta"] else ""
    return f"{told}  AUC {row['auc']:.4f} [{row['low']:.4f}, {row['high']:.4f}]{psnr}{fta}"
