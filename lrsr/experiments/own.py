"""Whom do a lab's own photographs show? Rates where people are known; candidates in any case."""

import csv
import io
import logging
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from lrsr.configuration import as_flag, as_mapping, require, whole_number
from lrsr.errors import InputError
from lrsr.evaluation.score_files.reading import NATIVE
from lrsr.evaluation.score_files.writing import score_file
from lrsr.experiments.design import OF_AXES, Design
from lrsr.experiments.further import Further, gather, look_further
from lrsr.experiments.labels import Labels, labels_of_entry
from lrsr.experiments.portraits import Cut, Portrait, Portraits, look_over, without_copies
from lrsr.experiments.report.candidates import shown_candidates
from lrsr.experiments.report.lines import best_methods, report_lines
from lrsr.experiments.report.page import write_report
from lrsr.experiments.report.panel import Panel
from lrsr.experiments.systems import Comparer, Comparison, known_landmarks
from lrsr.experiments.table import Record, evaluate, with_holm
from lrsr.files import write_json, write_text
from lrsr.pages import title_of, write_page
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.source import read_photographs
from lrsr.provenance import versions
from lrsr.recognition.finder import Finder
from lrsr.recognition.memory import Memory
from lrsr.recognition.settings import Landmarks

if TYPE_CHECKING:
    from omegaconf import DictConfig

_DONE = (
    "On every photograph the face was taken that is largest and nearest to the middle; larger "
    "photographs were cut to it. Probes were enlarged by every method, enrolled pictures were not.",
    "Bicubic is the a = -0.5 kernel; Base is not free of interpolation: alignment enlarges it.",
)
_NOT_DONE = (
    "A rank and a score are no probability that two pictures show one person: what a score is "
    "worth as evidence, lrsr compare and lrsr eval experiment=case say.",
    "Whether the photographs are as those of any other case was not looked at.",
)
_UNKNOWN = (
    "Nobody said who the photographs show, so there are no error rates and no likelihood ratios: "
    "only who is most alike."
)

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class Own(Design):
    """Photographs of a folder against photographs of another one.

    Attributes:
        cut: What of large ones is taken.
        candidates: How many enrolled pictures are told of for each probe, the most alike first.
        identified: Is it known who is on them? None: where a probe and an enrolled picture have
            an identity in common.

    Raises:
        InputError: A folder is not given, or a number is out of range.
    """

    cut: Cut = field(default_factory=Cut)
    candidates: int = 5
    identified: bool | None = None

    unread: ClassVar[tuple[str, ...]] = (
        *("lpips", "references", "fusions", "fusion", "frames", "burst"),
        *OF_AXES,
    )
    """Settings of ``lrsr eval`` that change nothing here."""

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("probes", "gallery"):
            wish = f"a folder of photographs: {name}=DIR"
            require(getattr(self, f"{name}_folder") is not None, f"{name}.folder", None, wish)
        require(self.candidates >= 1, "candidates", self.candidates, "at least 1")

    @classmethod
    def from_config(cls, config: "DictConfig") -> Self:
        """Read a composed configuration of ``lrsr eval``.

        Raises:
            InputError: A value is wrong; the message names the setting and the remedy.
        """
        for name in ("probes", "gallery"):  # before anything is read
            wish = f"a folder of photographs: {name}=DIR"
            require(config[name].folder is not None, f"{name}.folder", None, wish)
        known, cut = config.identified, as_mapping(config.cut, "cut")
        for name in cut:
            require(name in vars(Cut()), "cut", name, f"one of {', '.join(vars(Cut()))}")
        return replace(
            super().from_config(config),
            cut=Cut(**cut),
            candidates=whole_number(config, "candidates"),
            identified=None if known is None else as_flag(known, "identified"),
        )

    def run(self, folder: Path, cache: RenderCache, *, progress: bool = True) -> Path:
        """Write ``results.json``, ``scores.csv`` and ``report.html`` into ``folder``.

        Args:
            folder: Of the run.
            cache: Where what networks make of pictures is kept, so that a run that was stopped goes
                on.
            progress: Show bars on stderr.

        Raises:
            InputError: A setting or a folder is wrong, or no photograph of one can be used.
            ExceptionGroup: Of InputErrors: some photographs were refused; all else is finished.
        """
        memory = Memory(cache.folder / "recognition")
        engines, finder = self.recognition.engines(memory), self.recognition.finder(memory)
        probes, gallery, records, refused = self._photographs(finder, progress)
        landmarks = self.recognition.landmarks
        for side in (probes, gallery):
            known = any(one.entry.landmarks_px is not None for one in side.members)
            landmarks = known_landmarks(landmarks, str(side.root), known=known)
        unrated = self._unrated(probes, gallery)
        comparer = Comparer(self.upscalers, engines, landmarks, finder, progress)
        found = comparer.compare(probes, gallery, ipd_px=self.conditions[0].ipd_px)
        judged, panels = ({}, []) if unrated else self._judge(found, probes)
        results: dict[str, Any] = {
            "rows": [],
            "comparisons": [],
            **judged,
            "unrated": unrated,
            "photographs": records,
            "failures": [_failures(one) for one in found],
            "candidates": [
                row
                for one in found
                for row in _candidates_of(one, self.candidates, named=self._named(probes, gallery))
            ],
            "config": self.describe(),
            "recognition": {
                "recognisers": {name: dict(engine.describe()) for name, engine in engines.items()},
                **({"detector": finder.detector.describe()} if finder else {}),
            },
            "versions": versions(),
        }
        write_json(folder / "results.json", results)
        if self.save_scores:
            self._save(folder, found, rated=not unrated)
        self._write_page(folder, results, panels, (probes, gallery))
        for sentence in _answer(results):
            logger.info("%s", sentence)
        if refused:
            logger.info("%s: all but what follows", folder)
            raise ExceptionGroup("some photographs were refused", refused)
        return folder

    def describe(self) -> dict[str, Any]:
        """Return all of it in plain values, for ``results.json``."""
        told = ("name", "question", "methods", "level", "bootstrap", "calibration", "seed")
        plain = super().describe()
        return {
            **{name: plain[name] for name in told},
            "probes_folder": plain["probes_folder"],
            "gallery_folder": plain["gallery_folder"],
            "cut": vars(self.cut),
            "candidates": self.candidates,
            "identified": self.identified,
        }

    def _photographs(
        self, finder: Finder | None, progress: bool
    ) -> tuple[Portraits, Portraits, list[Record], list[InputError]]:
        """Look over both folders; return what is compared, a record of each file, and the errors.

        Raises:
            InputError: A folder holds no photograph that can be used.
        """
        records: list[Record] = []
        refused: list[InputError] = []
        sides: dict[str, list[Portrait]] = {}
        for kind, root in self._folders.items():
            portraits, errors = look_over(read_photographs(root, kind), finder, progress=progress)
            if not portraits:
                raise InputError(f"{kind}.folder={root}: {errors[0]} (and none of the others is)")
            sides[kind] = portraits
            refused += errors
            records += [{"kind": kind, "status": "refused", "why": str(one)} for one in errors]
        probes, copies = without_copies(sides["probe"], sides["gallery"])
        if not probes:
            raise InputError(
                f"probes.folder={self.probes_folder}: every photograph is in the gallery, too, and"
                " would be compared with itself; give others"
            )
        records += [
            {
                "kind": "probe",
                "status": "left out",
                "why": f"its copy {copy.entry.file} is enrolled",
            }
            | one.describe()
            for one, copy in copies
        ]
        for kind, kept in (("probe", probes), ("gallery", sides["gallery"])):
            records += [{"kind": kind, "status": "compared"} | one.describe() for one in kept]
        roots = self._folders
        return (
            Portraits(roots["probe"], probes, self.cut),
            Portraits(roots["gallery"], sides["gallery"], self.cut),
            records,
            refused,
        )

    @property
    def _folders(self) -> dict[str, Path]:
        folders = {"probe": self.probes_folder, "gallery": self.gallery_folder}
        return {kind: root for kind, root in folders.items() if root is not None}

    def _named(self, probes: Portraits, gallery: Portraits) -> bool:
        """Is it known who is who?"""
        if self.identified is not None:
            return self.identified
        return bool({*probes.identity_ids} & {*gallery.identity_ids})

    def _unrated(self, probes: Portraits, gallery: Portraits) -> str:
        """Return why there can be no error rates; empty where there can.

        Raises:
            InputError: It is said that people are known, but nobody is in both folders.
        """
        if not self._named(probes, gallery):
            return _UNKNOWN
        enrolled = Counter(gallery.identity_ids)
        mated = sum(enrolled[person] for person in probes.identity_ids)
        others = len(probes.members) * len(gallery.members) - mated
        require(mated > 0, "identified", True, "false: no identity is in both folders")
        if min(mated, others) >= 2:
            return ""
        return (
            f"{mated} pairs of pictures show one person and {others} two: error rates need at least"
            " two of each."
        )

    def _judge(
        self, found: Sequence[Comparison], probes: Portraits
    ) -> tuple[dict[str, Any], list[Panel]]:
        """Measure how well people are told apart, as of any other scores."""
        condition = self.conditions[0]
        people: dict[str, Labels] = {
            one.entry.identity_id: labels_of_entry(one.entry) for one in probes.members
        }
        groups: dict[tuple[str, Landmarks], dict[str, Comparison]] = {}
        for one in found:
            groups.setdefault((one.name.recogniser, one.landmarks), {})[one.name.method] = one
        rows: list[Record] = []
        tests: list[Record] = []
        further: list[Further] = []
        panels: list[Panel] = []
        for (recogniser, landmarks), members in groups.items():
            systems = {method: one.system for method, one in members.items()}
            told, compared, summaries = evaluate(
                self,
                condition,
                {method: system.source for method, system in systems.items()},
                {method: {} for method in systems},
                landmarks,
                {m: one.seen.errors if landmarks == "own" else () for m, one in members.items()},
            )
            rows += [{"recogniser": recogniser, **row} for row in told]
            tests += [{"recogniser": recogniser, **one} for one in compared]
            about = {m: {**one.about, "setting": condition.setting} for m, one in members.items()}
            more = look_further(self.asked, about, systems, summaries, people)
            further.append(more)
            curves = {members[name].label: one.curve for name, one in summaries.items()}
            title = f"{recogniser}, {landmarks} landmarks"
            panels.append(Panel(title, {landmarks: curves}, figures=more.figures))
        return {"rows": rows, "comparisons": with_holm(tests), **gather(further)}, panels

    def _save(self, folder: Path, found: Sequence[Comparison], *, rated: bool) -> None:
        """Write every score; without the column ``mated`` where nobody knows who is who."""
        if rated:
            with score_file(folder) as table:
                for one in found:
                    table.add(one.name, one.system)
            return
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow([name for name in NATIVE if name != "mated"])
        for one in found:
            name, system = one.name, one.system
            for tile in system.source.tiles():
                for row, scores in enumerate(tile.scores.tolist(), start=tile.first):
                    said = (name.method, name.landmarks, name.recogniser)
                    lines = zip(system.gallery, scores, strict=True)
                    writer.writerows(
                        (system.probes[row], who, *said, "NaN" if s != s else s) for who, s in lines
                    )
        write_text(folder / "scores.csv", text.getvalue())

    def _write_page(
        self,
        folder: Path,
        results: Mapping[str, Any],
        panels: Sequence[Panel],
        sides: tuple[Portraits, Portraits],
    ) -> None:
        more = {
            "answer": _answer(results),
            "rated": not results["unrated"],
            "photographs": results["photographs"],
            "failures": results["failures"],
            **shown_candidates(results["candidates"], *sides),
        }
        not_done = [results["unrated"], *_NOT_DONE] if results["unrated"] else _NOT_DONE
        if panels:
            write_report(
                folder, results, panels, done=_DONE, not_done=not_done, page="own", more=more
            )
            return
        config = results["config"]
        write_page(
            folder,
            "own",
            title=title_of(config["name"]),
            question=config["question"],
            settings={**config, "recognition": results["recognition"]},
            done=_DONE,
            not_done=not_done,
            versions=results["versions"],
            seed=config["seed"],
            **more,
        )


def _candidates_of(one: Comparison, most: int, *, named: bool) -> Iterator[Record]:
    """Yield, for each probe, the enrolled pictures that are most alike.

    Args:
        one: The scores.
        most: Of a probe; pictures without a score are no candidates.
        named: It is known who is who.
    """
    source = one.system.source
    for tile in source.tiles():
        for row, scores in enumerate(tile.scores, start=tile.first):
            order = np.argsort(-scores, kind="stable")[:most]
            for rank, column in enumerate(order.tolist(), start=1):
                if np.isnan(scores[column]):
                    break
                who = source.gallery_ids[column]
                yield one.about | {
                    "probe": one.system.probes[row],
                    "rank": rank,
                    "gallery": one.system.gallery[column],
                    "identity_id": who,
                    "score": float(scores[column]),
                    "mated": who == source.probe_ids[row] if named else None,
                }


def _failures(one: Comparison) -> Record:
    lost, unenrolled = one.failures
    return one.about | {"probes": lost, "gallery": unenrolled}


def _answer(results: Mapping[str, Any]) -> list[str]:
    """Return what a reader must know first."""
    told = []
    for kind in ("probe", "gallery"):
        became = Counter(one["status"] for one in results["photographs"] if one["kind"] == kind)
        counts = ", ".join(f"{count} {status}" for status, count in became.most_common())
        told.append(f"Photographs, {kind}: {counts}.")
    lost = max((len(one["probes"]) for one in results["failures"]), default=0)
    told += [f"Probes on which no face was found (FTA), by method: up to {lost}."] if lost else []
    if results["unrated"]:
        return [*told, results["unrated"]]
    return [*told, *best_methods(report_lines(results["rows"], results["comparisons"]))]
