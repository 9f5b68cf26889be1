"""How is a published set evaluated as its authors do? One condition, and what its protocol adds."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from typing import Any

import torch

from lrsr.errors import InputError, ScoreError
from lrsr.evaluation.arranged import Templates, diagonal, mean_templates
from lrsr.evaluation.identification import identify
from lrsr.evaluation.score_files.system import System
from lrsr.evaluation.scores import ScoreSource
from lrsr.evaluation.transfer import carry_threshold
from lrsr.experiments.design import Design
from lrsr.experiments.further import NAMES
from lrsr.experiments.table import Record
from lrsr.experiments.trial import Outcome, Trial
from lrsr.pictures.source import Photographs, Source

_TARGET_FMRS = (None, 0.01)
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
        templates: Which pictures are compared as one, the mean of their embeddings, by kind as
            ``photographs``; of a kind that is not there each is by itself.
        listed: Probe k is compared with enrolled picture k alone.
    """

    name: str
    design: Design
    photographs: Mapping[str, Photographs] = field(default_factory=dict)
    development: frozenset[str] = frozenset()
    evaluation: frozenset[str] = frozenset()
    search: bool = False
    templates: Mapping[str, Templates] = field(default_factory=dict)
    listed: bool = False

    def arrange(self, system: System) -> System:
        """Return the scores that the protocol looks at.

        Raises:
            InputError: Templates are asked for, and the recogniser compares otherwise than by
                embeddings.
        """
        if self.listed:
            return replace(system, source=diagonal(system.source))
        if not self.templates:
            return system
        probes, gallery = (self.templates.get(kind) for kind in ("probe", "gallery"))
        try:
            source = mean_templates(system.source, probes=probes, gallery=gallery)
        except ScoreError as error:
            raise InputError(f"recognition: {error}; name recognisers that have such") from error
        return System(
            source,
            system.probes if probes is None else probes.names,
            system.gallery if gallery is None else gallery.names,
            system.qualities if probes is None else {},  # a detector is sure of pictures
        )


@dataclass(frozen=True)
class SetTrial(Trial):
    """A trial of one part.

    Attributes:
        part: Which; its design is the trial's.
        looked: The probes of the part before and what the same recogniser has made of them: parts
            that differ in the gallery alone share it.
    """

    part: Part = field(kw_only=True)
    looked: list[tuple[Source, Any]] = field(default_factory=list, kw_only=True)

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

    def _look(self, condition: Any, probes: Any, references: Any) -> Any:
        """Look at the probes once for all parts in a row that have the same; see Trial."""
        if not any(before is probes for before, _ in self.looked):
            self.looked[:] = [(probes, super()._look(condition, probes, references))]
        return self.looked[0][1]

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
            here, there = (source.restricted(people) for people in sides)
            return [
                asdict(carry_threshold(here, there, fmr, level=self.design.level))
                for fmr in _TARGET_FMRS
            ]
        except ScoreError:  # too few of a kind were acquired; the table says so
            return [{"target_fmr": fmr, "hter": None} for fmr in _TARGET_FMRS]

    def _searches(self, source: ScoreSource) -> list[Record]:
        if not self.part.search:
            return []
        return [asdict(identify(source, level=self.design.level))]

    def _pictures(self, *of_what: Any) -> dict[str, torch.Tensor]:
        """Show no face of a set: its agreement allows few of them to be passed on."""
        return {} if self.part.photographs else super()._pictures(*of_what)


def people_of(photographs: Photographs, numbers: Sequence[int]) -> frozenset[str]:
    """Return who of a set has a number from the first to the last of two."""
    first, last = numbers
    return frozenset(who for who in photographs.identity_ids if first <= int(who) <= last)
