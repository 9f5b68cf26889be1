"""How does what a network has learned grow with the epochs, and does it peak, by the data's amount?

The curves are those that the runs of a multirun of ``lrsr train`` have written; nothing is trained.
"""

import json
import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self

from lrsr.configuration import as_word, seed_of
from lrsr.errors import InputError
from lrsr.experiments.design import OF_AXES
from lrsr.experiments.report.learning import draw_learning
from lrsr.files import read_bytes, write_bytes, write_json
from lrsr.pages import png_uri, title_of, write_page
from lrsr.paths import user_path
from lrsr.pictures.cache import RenderCache
from lrsr.provenance import versions

if TYPE_CHECKING:
    from omegaconf import DictConfig

_ALIKE = ("validation", "degradation.", "module.scale", "data.scale", "camera.")
"""Beginnings of settings on which a validation figure depends."""

_FOLLOWING = ("people", "pictures", "renderings", "files", "versions.", "trainer.precision")
"""Beginnings of settings that say again what others do."""

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class Run:
    """What one training has left.

    Attributes:
        folder: Its name.
        settings: All that its weights depend on.
        history: Every epoch's figures.
        finished: It reached its last epoch.
    """

    folder: str
    settings: Mapping[str, Any]
    history: Sequence[Mapping[str, float]]
    finished: bool

    def row(self, quantity: str, varied: Sequence[str]) -> dict[str, Any]:
        """Return its curve and what it says, in plain values."""
        values = [float(epoch[quantity]) for epoch in self.history]
        best = max(range(len(values)), key=values.__getitem__)
        told = {name: self.settings.get(name) for name in varied}
        return {
            "run": self.folder,
            "label": ", ".join(f"{name}={value}" for name, value in told.items()) or self.folder,
            "settings": told,
            "finished": self.finished,
            "epochs": len(values),
            "steps": int(self.history[-1]["step"]),
            "best_epoch": best + 1,
            "best": values[best],
            "last": values[-1],
            "drop": values[best] - values[-1],
            "values": values,
        }


@dataclass(frozen=True)
class TrainingStudy:
    """Runs that differ in how much they learn from, side by side.

    Attributes:
        runs: Folder of their folders.
        quantity: A figure of each epoch; more is better.
        name: Of the report.
        question: What it answers.
        seed: Nothing is drawn; it goes into the record.
    """

    runs: Path
    quantity: str = "val/psnr_y_db"
    name: str = "training_study"
    question: str = "How does what is learned grow with the epochs, by the amount of data?"
    seed: int = 0

    unread: ClassVar[tuple[str, ...]] = (
        *("identities", "rendering", "camera", "lens", "standpoint", "expression", "another_day"),
        *("gallery", "probes", "recognition", "sr", "level", "bootstrap", "save_scores"),
        *("calibration", "details", "references", *OF_AXES),
    )
    """Settings of ``lrsr eval`` that change nothing here."""

    @classmethod
    def from_config(cls, config: "DictConfig") -> Self:
        """Read a composed configuration of ``lrsr eval``.

        Raises:
            InputError: A value is wrong or missing.
        """
        from omegaconf import OmegaConf  # loaded by Hydra anyway

        if OmegaConf.is_missing(config, "runs"):
            raise InputError("runs must be given: the folder of lrsr train -m ... paths.run=DIR")
        return cls(
            runs=user_path(config.runs, "runs"),
            quantity=as_word(config.quantity, "quantity"),
            name=as_word(config.name, "name"),
            question=as_word(config.question, "question"),
            seed=seed_of(config),
        )

    def run(self, folder: Path, cache: RenderCache) -> Path:
        """Write ``results.json``, ``learning.png`` and ``report.html`` into ``folder``.

        Args:
            folder: Of the run.
            cache: Of renderings; none is needed.

        Raises:
            InputError: There are no runs, one cannot be read, has no epoch or no such figure, or
                they were validated on different pictures.
        """
        runs = self.read()
        varied = _varied(runs)
        rows = [run.row(self.quantity, varied) for run in runs]
        rows.sort(key=lambda row: [_rank(value) for value in row["settings"].values()])
        config = {"runs": str(self.runs), "quantity": self.quantity, "name": self.name}
        results = {"rows": rows, "config": config, "versions": versions()}
        write_json(folder / "results.json", results)
        curve = draw_learning({row["label"]: row["values"] for row in rows}, self.quantity)
        write_bytes(folder / "learning.png", curve)
        sentences = [_sentence(row, self.quantity) for row in rows]
        write_page(
            folder,
            "training_study",
            title=title_of(self.name),
            question=self.question,
            answer=sentences,
            rows=rows,
            quantity=self.quantity,
            curve=png_uri(curve),
            settings=config,
            seed=self.seed,
            done=["Each run's own figures were read; all were validated on the same pictures."],
            not_done=_NOT_DONE,
            versions=versions(),
        )
        for sentence in sentences:
            logger.info("%s", sentence)
        return folder

    def read(self) -> list[Run]:
        """Read the runs.

        Raises:
            InputError: See :meth:`run`.
        """
        paths = sorted(self.runs.glob("*/metrics.json"))
        if not paths:
            raise InputError(f"{self.runs} holds no run: give paths.run of a lrsr train -m")
        runs = [self._read(path) for path in paths]
        first = runs[0]
        for run in runs[1:]:
            for name in sorted({*first.settings} | {*run.settings}):
                one, other = (each.settings.get(name) for each in (first, run))
                if name.startswith(_ALIKE) and one != other:
                    raise InputError(
                        f"{self.runs / run.folder} has {name}={other} and {first.folder} {one}:"
                        " figures of different validations cannot be compared; train all with one"
                        " data.validation_count=N, or data.validation_root=DIR"
                    )
        return runs

    def _read(self, path: Path) -> Run:
        try:
            told = json.loads(read_bytes(path))
            history, settings = told["history"], told["settings"]
            run = Run(path.parent.name, settings, history, bool(told["finished"]))
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise InputError(f"{path} is no record of lrsr train: {error}; leave it out") from error
        if not history:
            raise InputError(f"{path} has no epoch yet: wait for it, or leave it out")
        if any(self.quantity not in epoch for epoch in history):
            known = ", ".join(name for name in history[0] if "/" in name)
            raise InputError(f"quantity={self.quantity}: {path} has {known}")
        return run


_NOT_DONE = (
    "One training of each is one draw: other seeds give other curves. Repeat with seed=0,1,2 "
    "before a small difference is believed.",
    "An epoch of more data has more steps; results.json has the steps. Rates that fall with the "
    "length of a run hide a decline: module.scheduler=null keeps them.",
)


def _varied(runs: Sequence[Run]) -> list[str]:
    """Return which settings the runs differ in, but for those that follow from others."""
    names = dict.fromkeys(name for run in runs for name in run.settings)
    return [
        name
        for name in names
        if not name.startswith(_FOLLOWING)
        and len({json.dumps(run.settings.get(name), sort_keys=True) for run in runs}) > 1
    ]


def _rank(value: object) -> tuple[float, str]:
    return (float(value), "") if isinstance(value, int | float) else (float("inf"), str(value))


def _sentence(row: Mapping[str, Any], quantity: str) -> str:
    end = f"{row['drop']:.2f} less" if row["drop"] > 0 else "the last one"
    return (
        f"{row['label']}: {quantity} is highest after epoch {row['best_epoch']} of {row['epochs']},"
        f" {row['best']:.2f}; at the end {end}."
    )
