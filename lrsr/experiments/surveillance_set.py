"""What does a published set of surveillance pictures say? Its protocol, our methods and pages."""

import logging
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self

from lrsr.configuration import require, section
from lrsr.evaluation.score_files.writing import score_file
from lrsr.experiments.conditions import Condition
from lrsr.experiments.design import OF_AXES, Design
from lrsr.experiments.further import gather
from lrsr.experiments.report.lines import condition_of, several_sources
from lrsr.experiments.report.page import write_report
from lrsr.experiments.report.sentences import about_recognition
from lrsr.experiments.set_trial import Part, SetTrial
from lrsr.experiments.table import Record, with_holm
from lrsr.experiments.trial import Outcome
from lrsr.files import write_json
from lrsr.paths import path_if_any
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.maker import Maker
from lrsr.pictures.source import Photographs, Source
from lrsr.provenance import versions
from lrsr.recognition.finder import Finder
from lrsr.recognition.memory import Memory
from lrsr.sr.perceptual import PerceptualDistance

if TYPE_CHECKING:
    from omegaconf import DictConfig

OF_VERIFICATION = ("fusions", "frames", "fusion", "burst", *OF_AXES)
OF_RENDERING = (
    *("identities", "rendering", "camera", "lens", "standpoint", "expression", "another_day"),
    *("gallery", "options", "conditions", "ipd_px", "lpips", "references"),
)

_DONE = (
    "Bicubic is the a = -0.5 kernel; SRCNN works on BT.601 luminance, chroma goes up bicubically. "
    "Base is not free of interpolation: alignment enlarges it bilinearly to 112 pixels.",
    "Intervals are DeLong's; tests are paired, on the same pairs of pictures.",
)
_NOT_SHOWN = "Faces of the set are not shown: its agreement says what may be passed on."

_TOLD = ("name", "question", "methods", "level", "bootstrap", "calibration", "seed")

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class SurveillanceSet(Design, ABC):
    """An experiment with the user's copy of a set.

    Attributes:
        wanted: What of the set takes part: the section :attr:`key` of the configuration.
    """

    wanted: Any = None

    key: ClassVar[str]
    title: ClassVar[str]
    """What its owners call the set."""
    unread: ClassVar[tuple[str, ...]] = ("probes", *OF_VERIFICATION, *OF_RENDERING)
    """Settings of ``lrsr eval`` that change nothing here."""

    @abstractmethod
    def parts(self) -> list[Part]:
        """Return the conditions, each with its pictures.

        Raises:
            InputError: The copy cannot be used.
        """

    def sentences(self) -> tuple[Sequence[str], Sequence[str]]:
        """Return what a report must say was done, and what was not."""
        return (), ()

    @classmethod
    def from_config(cls, config: "DictConfig") -> Self:
        """Read a composed configuration of ``lrsr eval`` that has no scenes of its own.

        Raises:
            InputError: A value is wrong; the message names the setting and the remedy.
        """
        from omegaconf import OmegaConf

        free: Any = OmegaConf.create(OmegaConf.to_container(config))
        free.update(options=[1], conditions={"1": {}}, ipd_px=8)  # parts have their own
        return cls.wanting(super().from_config(free), config)

    @classmethod
    def wanting(cls, asked: Self, config: "DictConfig") -> Self:
        """Return the same with what the configuration says of the set.

        Raises:
            InputError: A value is wrong; the message names the setting and the remedy.
        """
        return replace(asked, wanted=section(type(asked.wanted), config, cls.key))

    def describe(self) -> dict[str, Any]:
        """Return it in plain values, for ``results.json``; the parts say their conditions."""
        told = super().describe()
        return {**{name: told[name] for name in _TOLD}, self.key: asdict(self.wanted)}

    def part_of(self, number: int, name: str, photographs: Mapping[str, Photographs]) -> Part:
        """Return a part of photographs.

        Args:
            number: Of the condition.
            name: What a report calls it.
            photographs: By kind.
        """
        sizes = [entry.ipd_px for entry in photographs["probe"].entries if entry.ipd_px is not None]
        ipd_px = round(sum(sizes) / len(sizes), 1) if sizes else None
        condition = Condition(number, None, "", ipd_px)
        return Part(name, replace(self, conditions=(condition,)), photographs)

    def run(
        self,
        folder: Path,
        cache: RenderCache,
        *,
        maker: Maker | None = None,
        progress: bool = True,
    ) -> Path:
        """Write ``results.json``, ``report.html`` and ``scores.csv`` into ``folder``.

        Args:
            folder: Of the run.
            cache: Where renderings are kept, and what networks make of pictures.
            maker: Renders; Mitsuba when None.
            progress: Show bars on stderr.

        Raises:
            InputError: A file or a folder is wrong; nothing has been rendered by then.
        """
        parts = self.parts()
        memory = Memory(cache.folder / "recognition")
        engines, finder = self.recognition.engines(memory), self.recognition.finder(memory)
        finders: dict[str | None, Finder] = {None: finder} if finder else {}
        looks = (
            PerceptualDistance(self.lpips, device=self.recognition.device) if self.lpips else None
        )
        looked: dict[str, list[tuple[Source, Any]]] = {name: [] for name in engines}
        trials = [
            SetTrial(
                part.design, cache, engine, maker, finders, name, progress, looks,
                part=part, looked=looked[name],
            )
            for name, engine in engines.items()
            for part in parts
        ]  # fmt: skip
        known = {source for trial in trials for source in trial.landmarks}  # refused by now
        outcomes: list[Outcome] = []
        with score_file(folder) if self.save_scores else nullcontext() as table:
            for number, trial in enumerate(trials):
                logger.info("%s: %s", trial.name, parts[number % len(parts)].name)
                trial.render()
                outcomes += [
                    trial.named(one, several=len(engines) > 1) for one in trial.outcomes(table)
                ]
        results: dict[str, Any] = {
            "rows": [row for outcome in outcomes for row in outcome.rows],
            "comparisons": with_holm(
                [test for outcome in outcomes for test in outcome.comparisons]
            ),
            **gather([one for outcome in outcomes for one in outcome.further]),
            **{
                name: [record for trial in trials for record in trial.added[name]]
                for name in ("transfers", "searches")
            },
            "config": {
                **self.describe(),
                "lpips": looks and looks.describe(),
                "parts": _described(parts),
            },
            "recognition": {
                "recognisers": {name: dict(engine.describe()) for name, engine in engines.items()},
                **({"detector": finder.detector.describe()} if finder else {}),
            },
            "versions": versions(),
        }
        results |= self.compared(results["rows"])
        write_json(folder / "results.json", results)
        done, not_done = self.sentences()
        told, untold = about_recognition(self.recognition, sorted(known, reverse=True))
        hidden = (_NOT_SHOWN,) if any(part.photographs for part in parts) else ()
        write_report(
            folder,
            results,
            [outcome.panel for outcome in outcomes],
            done=(*done, *_DONE, *told),
            not_done=(*not_done, *untold, *hidden),
            page="surveillance_set",
            more={"title": self.title, **_tables(results)},
        )
        for row in results["rows"]:
            logger.info("%s", _line(row))
        return folder

    def compared(self, rows: Sequence[Record]) -> dict[str, list[Record]]:
        """Return further records that look at several parts at once."""
        return {}


def root_of(text: str | None, name: str, home: str) -> Path:
    """Return the folder of a set that must be given.

    Args:
        text: What was.
        name: Of the setting.
        home: Where its owners hand the set out.

    Raises:
        InputError: It is not.
    """
    root = path_if_any(text, name)
    require(root is not None, name, None, f"{name}=DIR, your copy; {home} has it")
    return root  # type: ignore[return-value]  # it is given


def _described(parts: Sequence[Part]) -> dict[int, Record]:
    """Return what each part is, by the number of its condition."""
    return {
        part.design.conditions[0].option: {
            "name": part.name,
            **{f"{kind}_pictures": len(one.entries) for kind, one in part.photographs.items()},
            "development_people": len(part.development),
            "evaluation_people": len(part.evaluation),
        }
        for part in parts
    }


def _tables(results: Mapping[str, Any]) -> dict[str, list[Record]]:
    """Return the lines of the tables that other experiments do not have."""
    several = several_sources(results["rows"])
    named = {
        name: [{**one, "condition": condition_of(one, several)} for one in results[name]]
        for name in ("transfers", "searches")
    }
    return {**named, "agreements": results.get("agreements", [])}


def _line(row: Record) -> str:
    told = f"{row['recogniser']}  {row['setting']}  {row['landmarks']:<6}  {row['label']:<9}"
    if row["auc"] is None:
        return f"{told}  too few faces were found (FTA {row['fta']:.3f})"
    fta = f"  FTA {row['fta']:.3f}" if row["fta"] else ""
    return f"{told}  AUC {row['auc']:.4f} [{row['low']:.4f}, {row['high']:.4f}]{fta}"
