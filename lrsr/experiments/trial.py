"""A verification experiment under way: rendered, photographed, enlarged, embedded and scored."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from lrsr.camera import Camera
from lrsr.evaluation.quality import psnr_y
from lrsr.experiments.design import Condition, Design
from lrsr.experiments.report.page import Panel
from lrsr.experiments.table import Record, evaluate
from lrsr.images import scale_points
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
from lrsr.rendering.scene import Film
from lrsr.sr.upscaler import Bicubic, Upscaler

_SHOWN = 6
"""People on the contact sheet."""

_Floats = NDArray[np.floating[Any]]


@dataclass(frozen=True)
class Outcome:
    """All that one condition gives.

    Attributes:
        rows: A row a method, in the order asked for; see :func:`lrsr.experiments.table.evaluate`.
        comparisons: Each method against the picture as it is and against its bicubic.
        panel: ROC curve of each method, and the first people, by column: "Gallery", "Probe", each
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
        as_it_is = Bicubic(1)
        enrolled = np.concatenate(
            [self._enlarge_and_embed(some, as_it_is)[0] for _, some in chunks(gallery)],
            dtype=np.float64,
        )
        shown = gallery.load(0, _SHOWN)
        for condition in self.design.conditions:
            yield self._outcome(condition, gallery, enrolled, shown)

    def _outcome(
        self, condition: Condition, gallery: Source, enrolled: _Floats, shown: Sequence[Picture]
    ) -> Outcome:
        probes, upscalers = self.probes(condition), self.design.upscalers
        references = {scale: self.references(condition, scale) for scale in self._scales}
        embedded: dict[str, list[_Floats]] = {method: [] for method in upscalers}
        decibels: dict[str, list[float]] = {method: [] for method in upscalers}
        for place, some in chunks(probes):
            true = {
                scale: source.load(place.start, place.stop)
                for scale, source in references.items()
                if source is not None
            }
            for method, upscaler in upscalers.items():
                found, quality = self._enlarge_and_embed(some, upscaler, true.get(upscaler.scale))
                embedded[method].append(found)
                decibels[method] += quality
        ids = tuple(probes.identity_ids), tuple(gallery.identity_ids)
        scores = {
            method: self.engine.compare(np.concatenate(parts, dtype=np.float64), enrolled, *ids)
            for method, parts in embedded.items()
        }
        rows, comparisons, curves = evaluate(self.design, condition, scores, decibels)
        pictures = self._pictures(probes, references, shown)
        named = {upscalers[method].label: curve for method, curve in curves.items()}
        panel = Panel(condition.title, named, pictures, ids[0][:_SHOWN])
        return Outcome(self._named(rows), self._named(comparisons), panel)

    def _named(self, records: Sequence[Record]) -> list[Record]:
        return [{"recogniser": self.name, **record} for record in records]

    def _enlarge_and_embed(
        self,
        pictures: Sequence[Picture],
        upscaler: Upscaler,
        true: Sequence[Picture] | None = None,
    ) -> tuple[_Floats, list[float]]:
        """Return embeddings ``(n, D)`` and, against true references, the PSNR of each in dB."""
        alike: dict[object, list[int]] = {}
        for number, picture in enumerate(pictures):
            alike.setdefault(picture.image.shape, []).append(number)
        rows: list[_Floats] = []
        decibels = np.empty(0 if true is None else len(true))
        for members in alike.values():
            images, landmarks = stack([pictures[i] for i in members])
            enlarged = upscaler(images)
            points = scale_points(landmarks, upscaler.scale)
            rows.append(self.engine.embed(enlarged, points.numpy()))
            if true is not None:
                references = stack([true[i] for i in members])[0].numpy()
                decibels[members] = psnr_y(enlarged.numpy(), references, shave=upscaler.scale)
        given_order = np.argsort(np.concatenate([*alike.values()]))
        return np.concatenate(rows)[given_order], decibels.tolist()

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
