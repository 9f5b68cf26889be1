"""A verification experiment under way: rendered, photographed, enlarged, embedded and scored."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import torch

from lrsr.camera import Camera
from lrsr.errors import InputError
from lrsr.evaluation.roc import RocCurve
from lrsr.evaluation.score_files.system import Name, System
from lrsr.evaluation.score_files.writing import ScoreFile
from lrsr.evaluation.scores import ScoreSource
from lrsr.experiments.conditions import Condition
from lrsr.experiments.design import Design
from lrsr.experiments.further import NAMES, Further, look_further
from lrsr.experiments.labels import Labels, labels_of, labels_of_entry
from lrsr.experiments.likeness import Truth
from lrsr.experiments.report.panel import Panel
from lrsr.experiments.seen import Seen
from lrsr.experiments.several import Pooled, see
from lrsr.experiments.table import FALSE_FACES, Record, evaluate
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.maker import Maker
from lrsr.pictures.picture import Picture, stack
from lrsr.pictures.recipe import Recipe
from lrsr.pictures.sitting import Sitting
from lrsr.pictures.source import (
    Bursts,
    Photographs,
    Rendered,
    Source,
    bursts_of,
    chunks,
    enrolled_photographs,
    read_photographs,
    references_of,
    render_sources,
)
from lrsr.recognition.finder import Finder
from lrsr.recognition.recognisers import Recogniser
from lrsr.recognition.settings import Landmarks
from lrsr.rendering.scene import Film
from lrsr.rendering.skin import Skin
from lrsr.sr.perceptual import PerceptualDistance
from lrsr.sr.upscaler import Bicubic

_SHOWN = 6
"""People on the contact sheet."""


@dataclass(frozen=True)
class Outcome:
    """All that one condition gives.

    Attributes:
        rows: A row a method for each source of landmarks, in the order asked for; see
            :func:`lrsr.experiments.table.evaluate`.
        comparisons: Each method against the picture as it is and against its bicubic, with
            landmarks of the same source.
        further: Likelihood ratios, groups and quality, likewise.
        panel: ROC curves of each method, and the first people, by column: "Gallery", "Probe", each
            method's label, "Reference"; photographs of several sizes are not shown.
    """

    rows: Sequence[Record]
    comparisons: Sequence[Record]
    further: Sequence[Further]
    panel: Panel


class _Judged(NamedTuple):
    """What landmarks of one source give under one condition; curves by label of the method."""

    rows: Sequence[Record]
    comparisons: Sequence[Record]
    further: Further
    curves: Mapping[str, RocCurve]


class _Enrolled(NamedTuple):
    """The gallery, what was made of it, and its first pictures."""

    source: Source
    seen: Seen
    shown: Sequence[Picture]


def known_landmarks(
    given: Iterable[Photographs], asked: tuple[Landmarks, ...]
) -> tuple[Landmarks, ...]:
    """Return the sources of landmarks that were asked for and are there for photographs.

    Raises:
        InputError: True ones alone are asked for, and nobody knows any.
    """
    for photographs in given:
        if all(entry.landmarks_px is None for entry in photographs.entries):
            if asked == ("shared",):
                raise InputError(
                    f"recognition.landmarks=shared: no picture in {photographs.root} has"
                    " landmarks_px; give recognition.landmarks=own"
                )
            return ("own",)
    return asked


@dataclass(frozen=True)
class Trial:
    """A verification experiment under way.

    Attributes:
        design: What is asked.
        cache: Where renderings are kept.
        engine: What recognises.
        finders: What finds faces, by :attr:`Condition.detector`; needed where landmarks are own.
        maker: Renders what the cache lacks; Mitsuba when None.
        name: What a report calls the engine.
        progress: Show bars while rendering.
        perceptual: Says how far a method's picture looks from its reference; None: nobody asks.
    """

    design: Design
    cache: RenderCache
    engine: Recogniser
    maker: Maker | None = None
    finders: Mapping[str | None, Finder] = field(default_factory=dict)
    name: str = "shipped"
    progress: bool = True
    perceptual: PerceptualDistance | None = None

    @cached_property
    def _galleries(self) -> dict[tuple[Skin | None, str | None], _Enrolled]:
        """By skin and detector; filled on the way."""
        return {}

    @cached_property
    def _earlier(
        self,
    ) -> dict[tuple[tuple[int, float | None], Landmarks], Mapping[str, ScoreSource]]:
        """Scores of rivals by option and size, and landmarks, then by method; filled on the way."""
        return {}

    @property
    def _scales(self) -> list[int]:
        """Of the true references that are wanted."""
        if not self.design.references:
            return []
        return sorted({upscaler.scale for upscaler in self.design.upscalers.values()} - {1})

    def render(self) -> int:
        """Render whatever the cache lacks of all people, or of the share asked for.

        Returns:
            How many pictures that were.
        """
        conditions = self.design.conditions
        sources = [self.gallery(skin) for skin in dict.fromkeys(one.skin for one in conditions)]
        for condition in conditions:
            references = [self.references(condition, scale) for scale in self._scales]
            sources += [self.probes(condition), *(one for one in references if one is not None)]
        return render_sources(sources, self.design.share or (0, 1))

    def gallery(self, skin: Skin | None = None) -> Source:
        """Return everyone's enrolled picture.

        Args:
            skin: That everybody has; None: the experiment's.
        """
        if "gallery" in self._given:
            return self._given["gallery"]
        if (enrolled := self.design.people.enrolled) is not None:
            return enrolled_photographs(enrolled)
        sitting = self.design.gallery
        if skin is not None:
            sitting = replace(sitting, quality=replace(sitting.quality, skin=skin))
        return self._rendered(sitting.recipes(), self.design.camera.clean())

    def probes(self, condition: Condition) -> Source:
        """Return the probes, with as many frames as the methods take.

        Raises:
            InputError: A folder lacks a frame.
        """
        frames = self.design.frames
        if "probe" in self._given:
            given = self._given["probe"]
            return bursts_of(given, frames) if frames > 1 else given
        camera, sitting = self.design.camera_of(condition), self._sitting(condition)
        taken = [
            Rendered(sitting.recipes(frame=n), camera, self.cache, self.maker, self.progress)
            for n in range(frames)
        ]
        return Bursts(taken) if frames > 1 else taken[0]

    def references(self, condition: Condition, scale: int) -> Source | None:
        """Return the true references of the probes; None: a folder has none."""
        if "probe" in self._given:
            return references_of(self._given["probe"], scale)
        camera = self.design.camera_of(condition).clean()
        return self._rendered(self._sitting(condition).recipes(scale), camera)

    @cached_property
    def _given(self) -> dict[str, Photographs]:
        """The pictures of folders by their kind; a manifest is read once."""
        folders = {"probe": self.design.probes_folder, "gallery": self.design.gallery_folder}
        return {kind: read_photographs(root, kind) for kind, root in folders.items() if root}

    def _rendered(self, recipes: Sequence[Recipe], camera: Camera) -> Source:
        return Rendered(recipes, camera, self.cache, self.maker, self.progress)

    def outcomes(self, table: ScoreFile | None = None) -> Iterator[Outcome]:
        """Score one condition after the other; what is not rendered yet is rendered.

        Args:
            table: Where all scores go, too.
        """
        for condition in self.design.conditions:
            yield self._outcome(condition, self._enrol(condition.skin, condition.detector), table)

    def _enrol(self, skin: Skin | None, detector: str | None) -> _Enrolled:
        """Look at the gallery, once for all conditions that share it."""
        if (skin, detector) not in self._galleries:
            gallery, as_it_is = self.gallery(skin), Bicubic(1)
            seen = self._nothing_seen(detector)
            for _, some in chunks(gallery):
                seen.look(self.engine, some, as_it_is)
            self._galleries[skin, detector] = _Enrolled(gallery, seen, gallery.load(0, _SHOWN))
        return self._galleries[skin, detector]

    @cached_property
    def landmarks(self) -> tuple[Landmarks, ...]:
        """Of which sources: what was asked for, but for true ones where nobody knows any.

        Raises:
            InputError: True ones alone are asked for, and nobody knows any.
        """
        return known_landmarks(self._given.values(), self.design.recognition.landmarks)

    def _nothing_seen(self, detector: str | None) -> Seen:
        return Seen(self.landmarks, self.finders[detector] if "own" in self.landmarks else None)

    def _outcome(
        self,
        condition: Condition,
        enrolled: _Enrolled,
        table: ScoreFile | None,
    ) -> Outcome:
        probes = self.probes(condition)
        references = {scale: self.references(condition, scale) for scale in self._scales}
        seen, people = self._look(condition, probes, references)
        if "probe" in self._given:
            entries = self._given["probe"].entries
            people = {entry.identity_id: labels_of_entry(entry) for entry in entries}
        judged = {
            landmarks: self._judge(
                condition,
                landmarks,
                seen,
                self._systems(landmarks, seen, enrolled, probes),
                people,
                table,
            )
            for landmarks in self.landmarks
        }
        figures = [
            replace(figure, caption=f"{landmarks.capitalize()} landmarks. {figure.caption}")
            if len(judged) > 1
            else figure
            for landmarks, one in judged.items()
            for figure in one.further.figures
        ]
        panel = Panel(
            condition.title,
            {landmarks: one.curves for landmarks, one in judged.items()},
            self._pictures(probes, references, enrolled.shown),
            tuple(probes.identity_ids)[:_SHOWN],
            figures,
            place=(condition.option, condition.ipd_px),
        )
        return Outcome(
            [row for one in judged.values() for row in one.rows],
            [test for one in judged.values() for test in one.comparisons],
            [one.further for one in judged.values()],
            panel,
        )

    def _look(
        self, condition: Condition, probes: Source, references: Mapping[int, Source | None]
    ) -> tuple[dict[str, Seen], dict[str, Labels]]:
        """Enlarge and embed the probes by each method; tell the groups of who was rendered."""
        upscalers = self.design.upscalers
        seen = {method: self._nothing_seen(condition.detector) for method in upscalers}
        people: dict[str, Labels] = {}
        for place, some in chunks(probes):
            true = {
                scale: Truth(source.load(place.start, place.stop), self.engine, self.perceptual)
                for scale, source in references.items()
                if source is not None
            }
            people |= {one.identity_id: labels_of(one.traits) for one in some if one.traits}
            for method, upscaler in upscalers.items():
                seen[method].look(self.engine, some, upscaler, true.get(upscaler.scale))
        return seen, people

    def _judge(
        self,
        condition: Condition,
        landmarks: Landmarks,
        seen: Mapping[str, Seen],
        systems: Mapping[str, System],
        people: Mapping[str, Labels],
        table: ScoreFile | None,
    ) -> _Judged:
        """Evaluate all methods with landmarks of one source, and keep their scores."""
        if table is not None:
            for method, system in systems.items():
                table.add(self._system_name(condition, method, landmarks), system)
        scores = {method: system.source for method, system in systems.items()}
        likeness = {method: one.likeness for method, one in seen.items()}
        errors = {}
        if landmarks == "own":
            likeness = {
                method: one.likeness | {FALSE_FACES: one.false_faces.tolist()}
                for method, one in seen.items()
            }
            errors = {method: one.errors for method, one in seen.items()}
        place = condition.option, condition.ipd_px
        if place in {one.rival for one in self.design.conditions}:
            self._earlier[place, landmarks] = scores
        rivals = self._earlier.get((condition.rival, landmarks), {}) if condition.rival else {}
        told, tests, summaries = evaluate(
            self.design, condition, scores, likeness, landmarks, errors, rivals
        )
        rows = [{"recogniser": self.name, **row} for row in told]
        about = {row["method"]: {name: row[name] for name in NAMES} for row in rows}
        return _Judged(
            rows,
            [{"recogniser": self.name, **test} for test in tests],
            look_further(
                self.design.asked, about, systems, summaries, people, draw=self.design.details
            ),
            {about[name]["label"]: summary.curve for name, summary in summaries.items()},
        )

    def _systems(
        self,
        landmarks: Landmarks,
        seen: Mapping[str, Seen],
        enrolled: _Enrolled,
        probes: Source,
    ) -> dict[str, System]:
        """Return the scores of each method with landmarks of one source."""
        gallery, known = enrolled.source, enrolled.seen.joined(landmarks)
        ids = tuple(probes.identity_ids), tuple(gallery.identity_ids)
        return {
            method: System(
                self.engine.compare(one.joined(landmarks), known, *ids),
                probes.names,
                gallery.names,
                one.qualities,
            )
            for method, one in seen.items()
        }

    def _system_name(self, condition: Condition, method: str, landmarks: Landmarks) -> Name:
        size = "" if condition.ipd_px is None else f"{condition.ipd_px:g}"
        return Name(str(condition.option), size, method, landmarks, self.name)

    def _pictures(
        self,
        probes: Source,
        references: Mapping[int, Source | None],
        enrolled: Sequence[Picture],
    ) -> dict[str, torch.Tensor]:
        """Return the columns of the contact sheet; none where sizes differ."""
        first = probes.load(0, _SHOWN)
        by_id = {picture.identity_id: picture for picture in enrolled}
        beside = [by_id[one.identity_id] for one in first if one.identity_id in by_id]
        sizes = [{picture.image.shape for picture in some} for some in (first, beside)]
        if any(len(some) > 1 for some in sizes) or len(beside) < len(first):
            return {}
        images = stack(first)[0]
        columns = {"Gallery": stack(beside)[0], "Probe": images}
        for upscaler in self.design.upscalers.values():
            if upscaler.scale > 1 and not isinstance(upscaler, Pooled):  # those make no picture
                columns[upscaler.label] = see(upscaler, first)[0][:, 0]
        finest = references[self._scales[-1]] if self._scales else None
        true = {} if finest is None else {"Reference": stack(finest.load(0, _SHOWN))[0]}
        return {**columns, **true}

    def _sitting(self, condition: Condition) -> Sitting:
        asked = self.design
        if condition.scene is None or condition.ipd_px is None:
            raise RuntimeError("photographs are not rendered")
        quality = asked.quality.at(condition.ipd_px)
        return Sitting(
            people=asked.people,
            scene=condition.scene,
            film=Film(condition.ipd_px),
            quality=replace(quality, skin=condition.skin or quality.skin),
            seed=asked.seed,
            burst=asked.burst,
        )
