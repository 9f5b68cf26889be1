"""A verification experiment under way: rendered, photographed, enlarged, embedded and scored."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import torch

from lrsr.camera import Camera
from lrsr.errors import InputError
from lrsr.evaluation.roc import RocCurve
from lrsr.experiments.design import Condition, Design
from lrsr.experiments.report.page import Panel
from lrsr.experiments.seen import Seen
from lrsr.experiments.table import Record, evaluate
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.maker import Maker
from lrsr.pictures.picture import Picture, stack
from lrsr.pictures.recipe import Recipe
from lrsr.pictures.sitting import Sitting
from lrsr.pictures.source import (
    Photographs,
    Rendered,
    Source,
    chunks,
    read_photographs,
    references_of,
    render_sources,
)
from lrsr.recognition.recognisers import Recogniser
from lrsr.recognition.settings import Landmarks
from lrsr.rendering.scene import Film
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
        panel: ROC curves of each method, and the first people, by column: "Gallery", "Probe", each
            method's label, "Reference"; photographs of several sizes are not shown.
    """

    rows: Sequence[Record]
    comparisons: Sequence[Record]
    panel: Panel


@dataclass(frozen=True)
class Trial:
    """A verification experiment under way.

    Attributes:
        design: What is asked.
        cache: Where renderings are kept.
        engine: What recognises.
        maker: Renders what the cache lacks; Mitsuba when None.
        name: What a report calls the engine.
        progress: Show bars while rendering.
    """

    design: Design
    cache: RenderCache
    engine: Recogniser
    maker: Maker | None = None
    name: str = "shipped"
    progress: bool = True

    @property
    def _scales(self) -> list[int]:
        return sorted({upscaler.scale for upscaler in self.design.upscalers.values()} - {1})

    def render(self) -> int:
        """Render whatever the cache lacks; return how many pictures that were."""
        sources = [self.gallery()]
        for condition in self.design.conditions:
            references = [self.references(condition, scale) for scale in self._scales]
            sources += [self.probes(condition), *(one for one in references if one is not None)]
        return render_sources(sources)

    def gallery(self) -> Source:
        """Return everyone's enrolled picture."""
        if "gallery" in self._given:
            return self._given["gallery"]
        return self._rendered(self.design.gallery.recipes(), self.design.camera.clean())

    def probes(self, condition: Condition) -> Source:
        """Return the probes."""
        if "probe" in self._given:
            return self._given["probe"]
        camera = self.design.camera.compressing(condition.compression)
        return self._rendered(self._sitting(condition).recipes(), camera)

    def references(self, condition: Condition, scale: int) -> Source | None:
        """Return the true references of the probes; None: a folder has none."""
        if "probe" in self._given:
            return references_of(self._given["probe"], scale)
        return self._rendered(self._sitting(condition).recipes(scale), self.design.camera.clean())

    @cached_property
    def _given(self) -> dict[str, Photographs]:
        """The pictures of folders by their kind; a manifest is read once."""
        folders = {"probe": self.design.probes_folder, "gallery": self.design.gallery_folder}
        return {kind: read_photographs(root, kind) for kind, root in folders.items() if root}

    def _rendered(self, recipes: Sequence[Recipe], camera: Camera) -> Source:
        return Rendered(recipes, camera, self.cache, self.maker, self.progress)

    def outcomes(self) -> Iterator[Outcome]:
        """Score one condition after the other; what is not rendered yet is rendered."""
        gallery = self.gallery()
        enrolled, as_it_is = Seen(self.landmarks), Bicubic(1)
        for _, some in chunks(gallery):
            enrolled.look(self.engine, some, as_it_is)
        shown = gallery.load(0, _SHOWN)
        for condition in self.design.conditions:
            yield self._outcome(condition, gallery, enrolled, shown)

    @cached_property
    def landmarks(self) -> tuple[Landmarks, ...]:
        """Of which sources: what was asked for, but for true ones where nobody knows any.

        Raises:
            InputError: True ones alone are asked for, and nobody knows any.
        """
        asked = self.design.recognition.landmarks
        for photographs in self._given.values():
            if all(entry.landmarks_px is None for entry in photographs.entries):
                if asked == ("shared",):
                    raise InputError(
                        f"recognition.landmarks=shared: no picture in {photographs.root} has"
                        " landmarks_px; give recognition.landmarks=own"
                    )
                return ("own",)
        return asked

    def _outcome(
        self, condition: Condition, gallery: Source, enrolled: Seen, shown: Sequence[Picture]
    ) -> Outcome:
        probes, upscalers = self.probes(condition), self.design.upscalers
        references = {scale: self.references(condition, scale) for scale in self._scales}
        seen = {method: Seen(self.landmarks) for method in upscalers}
        for place, some in chunks(probes):
            true = {
                scale: source.load(place.start, place.stop)
                for scale, source in references.items()
                if source is not None
            }
            for method, upscaler in upscalers.items():
                seen[method].look(self.engine, some, upscaler, true.get(upscaler.scale))
        ids = tuple(probes.identity_ids), tuple(gallery.identity_ids)
        decibels = {method: one.decibels for method, one in seen.items()}
        rows, comparisons = [], []
        curves: dict[str, Mapping[str, RocCurve]] = {}
        for landmarks in self.landmarks:
            scores = {
                method: self.engine.compare(one.joined(landmarks), enrolled.joined(landmarks), *ids)
                for method, one in seen.items()
            }
            errors = {name: one.errors if landmarks == "own" else () for name, one in seen.items()}
            found = evaluate(self.design, condition, scores, decibels, landmarks, errors)
            rows += [{"recogniser": self.name, **row} for row in found[0]]
            comparisons += [{"recogniser": self.name, **test} for test in found[1]]
            curves[landmarks] = {upscalers[name].label: one for name, one in found[2].items()}
        pictures = self._pictures(probes, references, shown)
        panel = Panel(condition.title, curves, pictures, ids[0][:_SHOWN])
        return Outcome(rows, comparisons, panel)

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
            if upscaler.scale > 1:
                columns[upscaler.label] = upscaler(images)
        finest = references[self._scales[-1]] if self._scales else None
        true = {} if finest is None else {"Reference": stack(finest.load(0, _SHOWN))[0]}
        return {**columns, **true}

    def _sitting(self, condition: Condition) -> Sitting:
        asked = self.design
        if condition.scene is None or condition.ipd_px is None:
            raise RuntimeError("photographs are not rendered")
        return Sitting(
            people=asked.people,
            scene=condition.scene,
            film=Film(condition.ipd_px),
            quality=asked.quality.at(condition.ipd_px),
            seed=asked.seed,
        )
