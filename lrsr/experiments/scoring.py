"""What do anybody's scores say? The same tables and pages as of our own experiments."""

import logging
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from lrsr.configuration import as_word, flag, require, words
from lrsr.errors import InputError, ScoreError
from lrsr.evaluation.sample_size import pairs_for_precision, rate_without_error
from lrsr.evaluation.score_files.reading import FORMATS, read_scores
from lrsr.evaluation.score_files.system import Name, System
from lrsr.evaluation.score_files.writing import write_bob
from lrsr.evaluation.summary import Evaluation, summarise
from lrsr.experiments.asked import Asked
from lrsr.experiments.further import NAMES, Further, gather, look_further
from lrsr.experiments.labels import Labels, read_labels
from lrsr.experiments.report.lines import condition_of
from lrsr.experiments.report.page import write_report
from lrsr.experiments.report.panel import Panel
from lrsr.experiments.table import (
    Record,
    area_record,
    comparison_record,
    rates_record,
    with_holm,
)
from lrsr.files import write_json
from lrsr.paths import path_if_any, user_path
from lrsr.provenance import versions

if TYPE_CHECKING:
    from omegaconf import DictConfig

_EXPORTS = ("bob",)

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class Scoring:
    """Which scores are evaluated, and how.

    Attributes:
        files: Of scores; see :mod:`lrsr.evaluation.score_files.reading`.
        asked: How sure numbers are told.
        name: Of the report.
        question: What its table answers.
        format: Of the files; None: told by their first lines.
        distance: The numbers are distances.
        qualities: Columns that hold a measure of the probe.
        people: A CSV of who belongs to which group; None: no groups.
        export: Another form in which the scores are written; None: none.

    Raises:
        InputError: A value is none of those that are known.
    """

    files: tuple[Path, ...]
    asked: Asked
    name: str = "scores"
    question: str = "How well do these scores tell people apart?"
    format: str | None = None
    distance: bool = False
    qualities: tuple[str, ...] = ()
    people: Path | None = None
    export: str | None = None

    def __post_init__(self) -> None:
        known = f"null or one of {', '.join(FORMATS)}"
        require(self.format in (None, *FORMATS), "format", self.format, known)
        known = f"null or {' or '.join(_EXPORTS)}"
        require(self.export in (None, *_EXPORTS), "export", self.export, known)

    @classmethod
    def from_config(cls, config: "DictConfig") -> Self:
        """Read a composed configuration of ``lrsr score``.

        Raises:
            InputError: A value is wrong; the message names the setting and the remedy.
        """
        return cls(
            files=tuple(user_path(file, "files") for file in words(config, "files")),
            asked=Asked.from_config(config),
            name=as_word(config.name, "name"),
            question=as_word(config.question, "question"),
            format=None if config.format is None else as_word(config.format, "format"),
            distance=flag(config, "distance"),
            qualities=tuple(words(config, "quality")),
            people=path_if_any(config.people, "people"),
            export=None if config.export is None else as_word(config.export, "export"),
        )

    def describe(self) -> dict[str, Any]:
        """Return all of it in plain values, for ``results.json``."""
        return {
            "name": self.name,
            "question": self.question,
            "files": [str(file) for file in self.files],
            "format": self.format,
            "distance": self.distance,
            "quality": list(self.qualities),
            "people": None if self.people is None else str(self.people),
            "level": self.asked.level,
            "bootstrap": self.asked.bootstrap,
            "calibration": self.asked.calibration,
            "seed": self.asked.seed,
        }

    def run(self, folder: Path) -> Path:
        """Write ``results.json`` and ``report.html``, and what is exported, into ``folder``.

        Raises:
            InputError: A file cannot be read, or its scores cannot be evaluated.
        """
        people = {} if self.people is None else read_labels(self.people)
        found = read_scores(
            self.files, self.format, qualities=self.qualities, distance=self.distance
        )
        conditions: dict[tuple[str, str, str], dict[str, tuple[Name, System]]] = {}
        for name, system in found.items():
            here = conditions.setdefault((name.option, name.ipd_px, name.landmarks), {})
            here[_key(name, found)] = name, system
        rows: list[Record] = []
        tests: list[Record] = []
        further: list[Further] = []
        panels: list[Panel] = []
        for members in conditions.values():
            told = self._evaluate(members, people)
            rows += told[0]
            tests += told[1]
            further.append(told[2])
            panels.append(told[3])
        results: dict[str, Any] = {
            "rows": rows,
            "comparisons": with_holm(tests),
            **gather(further),
            "config": self.describe(),
            "versions": versions(),
        }
        write_json(folder / "results.json", results)
        write_report(
            folder,
            {**results, "recognition": {}},
            panels,
            done=self._done(rows),
            not_done=_NOT_DONE,
            page="score",
        )
        if self.export is not None:
            self._export(folder, found)
        for row in rows:
            logger.info("%s", _line(row))
        return folder

    def _evaluate(
        self, members: Mapping[str, tuple[Name, System]], people: Mapping[str, Labels]
    ) -> tuple[list[Record], list[Record], Further, Panel]:
        """Evaluate one condition; methods are tested against each other on the same pairs only."""
        names = {key: name for key, (name, _) in members.items()}
        systems = {key: system for key, (_, system) in members.items()}
        evaluation = _summarise(systems, self.asked)
        # Several recognisers are told apart by the method, and tested against each other.
        recognisers = {name.recogniser for name in names.values()}
        recogniser = recognisers.pop() or None if len(recognisers) == 1 else None
        rows = []
        for key, summary in evaluation.summaries.items():
            name = names[key]
            rows.append(
                {
                    "experiment": self.name,
                    "option": int(name.option) if name.option.isdigit() else name.option or None,
                    "setting": "",
                    "ipd_px": _ipd(name.ipd_px),
                    "method": key,
                    "label": key,
                    "landmarks": name.landmarks or None,
                    "recogniser": recogniser,
                    **area_record(summary.area),
                    "psnr_y_db": None,
                    **rates_record(summary),
                }
            )
        condition = {
            name: rows[0][name]
            for name in ("recogniser", "option", "setting", "ipd_px", "landmarks")
        }
        same = {f"against_{name}": condition[name] for name in ("option", "ipd_px")}
        tests = [
            {**condition, "method": a, "against": b, **same, **comparison_record(test)}
            for (a, b), test in evaluation.comparisons.items()
        ]
        about = {row["method"]: {name: row[name] for name in NAMES} for row in rows}
        further = look_further(self.asked, about, systems, evaluation.summaries, people)
        curves = {row["label"]: evaluation.summaries[row["method"]].curve for row in rows}
        source = str(rows[0]["landmarks"] or "")
        panel = Panel(
            condition_of(rows[0], {"landmarks"}), {source: curves}, figures=further.figures
        )
        return rows, tests, further, panel

    def _done(self, rows: list[Record]) -> list[str]:
        fewest = min(row["n_genuine"] for row in rows)
        hidden = 100 * rate_without_error(fewest, self.asked.level)
        wanted = pairs_for_precision(0.1, 0.02, self.asked.level)
        return [
            "Scores were read as they are: higher is more alike."
            if not self.distance
            else "Distances were read, and their sign turned: higher is more alike.",
            "Intervals are DeLong's, Wilson's and, where people are named, those of the jackknife "
            "and the bootstrap over people; tests are paired, on the same pairs.",
            f"With {fewest:,} genuine pairs an FNMR that is seen as 0 may be as high as "
            f"{hidden:.2g} %; an FNMR of 10 % to be known to within 2 % needs {wanted:,}.",
        ]

    def _export(self, folder: Path, found: Mapping[Name, System]) -> None:
        several = len({name.landmarks for name in found}) > 1
        for name, system in found.items():
            words_of = [
                name.option and f"option{name.option}",
                name.ipd_px,
                name.landmarks * several,
                _key(name, found),
            ]
            stem = "-".join(filter(None, words_of)).replace("/", "_").replace(" ", "_")
            write_bob(folder / f"scores-{stem}.csv", system)


_NOT_DONE = (
    "Nothing was checked about how the scores came about, or whose pictures they compare.",
    "A threshold that was chosen on these scores has no error rate for others: set it on people of "
    "its own.",
)


def _key(name: Name, among: Collection[Name]) -> str:
    """Name a method by what sets it apart from others."""
    recognisers = len({one.recogniser for one in among}) > 1
    return " ".join(filter(None, (name.method, name.recogniser * recognisers)))


def _ipd(text: str) -> float | None:
    """Return the distance of the pupils that a file says.

    Raises:
        InputError: It is no number.
    """
    try:
        return float(text) if text else None
    except ValueError:
        raise InputError(f"ipd_px {text[:40]!r} of the scores is no number: mend it") from None


def _summarise(systems: Mapping[str, System], asked: Asked) -> Evaluation:
    """Summarise methods, those of the same pairs together.

    Raises:
        ScoreError: They cannot be evaluated.
    """
    groups: list[dict[str, System]] = []
    for name, system in systems.items():
        for group in groups:
            if _same_pairs(next(iter(group.values())), system):
                group[name] = system
                break
        else:
            groups.append({name: system})
    told = [
        summarise(
            {name: system.source for name, system in group.items()},
            level=asked.level,
            bootstrap=asked.bootstrap,
            seed=asked.seed,
        )
        for group in groups
    ]
    summaries = {name: one for part in told for name, one in part.summaries.items()}
    tests = {pair: one for part in told for pair, one in part.comparisons.items()}
    return Evaluation({name: summaries[name] for name in systems}, tests)


def _same_pairs(one: System, other: System) -> bool:
    try:
        one.source.check_same_pairs(other.source, "")
    except ScoreError:
        return False
    named = one.source.people_known and one.source.crossed is other.source.crossed
    return named and (one.probes, one.gallery) == (other.probes, other.gallery)


def _line(row: Record) -> str:
    interval = f"[{row['low']:.4f}, {row['high']:.4f}]"
    return f"{condition_of(row, {'landmarks'})}  {row['label']}  AUC {row['auc']:.4f} {interval}"
