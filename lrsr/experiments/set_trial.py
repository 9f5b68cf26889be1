"""How is a published set evaluated as its authors do? One condition, and what its protocol adds."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import torch

from lrsr.errors import InputError, ScoreError
from lrsr.evaluation.identification import identify
from lrsr.evaluation.pairs import PairScores
from lrsr.evaluation.score_files.system import System
from lrsr.evaluation.scores import CosineScores, ScoreSource
from lrsr.evaluation.transfer import carry_threshold
from lrsr.experiments.design import Design
from lrsr.experiments.further import NAMES
from lrsr.experiments.table import Record
from lrsr.experiments.trial import Outcome, Trial
from lrsr.pictures.source import Photographs

TARGET_FMRS = (None, 0.01)
"""Where thresholds are set on the development people: at their equal error rate, at this FMR."""


@dataclass(frozen=True)
class Part:
    """One condition of an experiment with a set.

    Attributes:
        name: What a report calls it.
        design: With this one condition.
        photographs: By kind, "probe" and "gallery", in place of rendered pictures.
        development: People on whom a threshold is set; empty: none is.
        evaluation: Others, on whom it is judged.
        search: Look for every probe in the whole gallery.
        templates: A person's enrolled pictures become one template, the mean of their embeddings.
        listed: Probe k is compared with enrolled picture k alone.
    """

    name: str
    design: Design
    photographs: Mapping[str, Photographs] = field(default_factory=dict)
    development: frozenset[str] = frozenset()
    evaluation: frozenset[str] = frozenset()
    search: bool = False
    templates: bool = False
    listed: bool = False

    def arrange(self, system: System) -> System:
        """Return the scores that the protocol looks at.

        Raises:
            InputError: Templates are asked for, and the recogniser compares otherwise than by
                embeddings.
        """
        if self.listed:
            return replace(system, source=diagonal(system.source))
        if self.templates:
            source = mean_templates(system.source)
            return replace(system, source=source, gallery=source.gallery_ids)
        return system


@dataclass(frozen=True)
class SetTrial(Trial):
    """A trial of one part.

    Attributes:
        part: Which; its design is the trial's.
    """

    part: Part = field(kw_only=True)

    @cached_property
    def added(self) -> dict[str, list[Record]]:
        """Records of what the protocol adds, by name; filled on the way."""
        return {"transfers": [], "searches": []}

    @cached_property
    def _given(self) -> dict[str, Photographs]:
        return dict(self.part.photographs) or super()._given

    def named(self, outcome: Outcome, *, several: bool) -> Outcome:
        """Let everything say the part's name.

        Args:
            outcome: Of this trial.
            several: There are several recognisers, so the title says which it is.
        """
        words = {"setting": self.part.name}
        further = outcome.further
        title = f"{self.name}. {self.part.name}" if several else self.part.name
        return Outcome(
            [row | words for row in outcome.rows],
            [test | words for test in outcome.comparisons],
            [
                replace(
                    one,
                    likelihood_ratios=[record | words for record in one.likelihood_ratios],
                    groups=[record | words for record in one.groups],
                    discards=[record | words for record in one.discards],
                )
                for one in further
            ],
            replace(outcome.panel, title=title),
        )

    def _judge(self, condition: Any, landmarks: Any, seen: Any, systems: Any, *more: Any) -> Any:
        """Judge what the protocol looks at, and add what it asks for besides; see Trial."""
        arranged = {method: self.part.arrange(system) for method, system in systems.items()}
        judged = super()._judge(condition, landmarks, seen, arranged, *more)
        for row in judged.rows:
            about = {name: row[name] for name in NAMES} | {"setting": self.part.name}
            source = arranged[row["method"]].source
            self.added["transfers"] += [about | one for one in self._transfers(source)]
            self.added["searches"] += [about | one for one in self._searches(source)]
        return judged

    def _transfers(self, source: ScoreSource) -> list[Record]:
        """Set thresholds on the development people, and judge them on the others."""
        sides = self.part.development, self.part.evaluation
        if not all(sides):
            return []
        try:
            parts = [source.restricted(people) for people in sides]
            return [asdict(carry_threshold(*parts, fmr)) for fmr in TARGET_FMRS]
        except ScoreError:  # too few of a kind were acquired; the table says so
            return [{"target_fmr": fmr, "hter": None} for fmr in TARGET_FMRS]

    def _searches(self, source: ScoreSource) -> list[Record]:
        if not self.part.search:
            return []
        return [asdict(identify(source, level=self.design.level))]

    def _pictures(self, *of_what: Any) -> dict[str, torch.Tensor]:
        """Show no face of a set: its agreement allows few of them to be passed on."""
        return {} if self.part.photographs else super()._pictures(*of_what)


def diagonal(source: ScoreSource) -> PairScores:
    """Return the scores of row and column 0, of row and column 1, and so on, as listed pairs.

    Example:
        >>> from lrsr.evaluation.scores import Scores
        >>> matrix = np.array([[0.9, 0.5], [0.5, 0.1]])
        >>> diagonal(Scores(matrix, ["ann", "ann"], ["ann", "bob"])).impostor().tolist()
        [0.1]
    """
    parts = [
        tile.scores[np.arange(len(tile.scores)), np.arange(tile.rows.start, tile.rows.stop)]
        for tile in source.tiles()
    ]
    return PairScores(np.concatenate(parts), source.probe_ids, source.gallery_ids)


def mean_templates(source: ScoreSource) -> CosineScores:
    """Return cosines with one template a person: the mean of embeddings of length 1, as long.

    A picture without an embedding is left out; a person without any has none.

    Args:
        source: Cosines with every picture of the gallery.

    Raises:
        InputError: The recogniser compares otherwise.

    Example:
        >>> faces = np.array([[1.0, 0.0], [0.0, 1.0]])
        >>> both = mean_templates(CosineScores(faces, faces, ["ann", "bob"], ["ann", "ann"]))
        >>> both.gallery.round(3).tolist(), both.gallery_ids
        ([[0.707, 0.707]], ('ann',))
    """
    if not isinstance(source, CosineScores):
        raise InputError("templates are means of embeddings: name recognisers that have such")
    people, who = np.unique(source.gallery_ids, return_inverse=True)
    known = np.isfinite(source.gallery).all(axis=1)
    total = np.zeros((people.size, source.gallery.shape[1]))
    np.add.at(total, who[known], source.gallery[known])
    length = np.linalg.norm(total, axis=1, keepdims=True)
    templates = np.divide(total, length, out=np.full_like(total, np.nan), where=length > 0)
    return CosineScores(source.probes, templates, source.probe_ids, people.tolist())


def people_of(photographs: Photographs, numbers: Sequence[int]) -> frozenset[str]:
    """Return who of a set has a number from the first to the last of two."""
    first, last = numbers
    return frozenset(who for who in photographs.identity_ids if first <= int(who) <= last)
