"""Who is who, at which size, by which method? Probes against a gallery, one AUC a row.

``super_resolution`` (six options, one size) and ``interpupillary_distance`` (one option, many
sizes) are the same procedure under other conditions: photograph everyone once as a document would
(gallery) and once as the condition says (probe), enlarge the probe by each method, embed both, and
ask how well the similarity tells genuine from impostor pairs.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from lrsr.camera import Camera
from lrsr.data.cache import RenderCache
from lrsr.data.maker import Maker
from lrsr.data.probes import Probe, ProbeRecipe, filmed, load_probes, render_missing, stack
from lrsr.evaluation.quality import psnr_y
from lrsr.evaluation.scores import Scores
from lrsr.experiments.settings import Condition, VerificationSettings
from lrsr.experiments.table import Comparison, Row, compare_methods, make_row, mean_psnr_db
from lrsr.images import scale_points
from lrsr.recognition.engine import Engine, cosine_scores
from lrsr.sr.upscaling import Upscaler

SHOWN = 6
"""People on the contact sheet."""

Floats = NDArray[np.float32]


@dataclass(frozen=True)
class Outcome:
    """All that one condition gives.

    Attributes:
        condition: The condition.
        rows: A row a method, in the order asked for.
        comparisons: Each method against Base and against its bicubic.
        scores: By method.
        pictures: The first people, by column: "Gallery", "Probe", each method's label,
            "Reference"; each ``(n, 3, h, w)`` srgb.
    """

    condition: Condition
    rows: tuple[Row, ...]
    comparisons: tuple[Comparison, ...]
    scores: Mapping[str, Scores]
    pictures: Mapping[str, torch.Tensor]


class Verification:
    """Renders, photographs, enlarges, embeds and scores; everything expensive is done once.

    Args:
        settings: What is asked.
        cache: Where renderings are kept.
        engine: What recognises.
        camera: Takes the probes, with the condition's compression; all other pictures are taken by
            the reference camera, with the same exposure and without compression.
        maker: Renders what the cache lacks; Mitsuba when None.

    Raises:
        InputError: A method does not exist.
    """

    def __init__(
        self,
        settings: VerificationSettings,
        cache: RenderCache,
        engine: Engine,
        camera: Camera,
        maker: Maker | None = None,
    ) -> None:
        self.settings = settings
        self.upscalers = {method: Upscaler(method) for method in settings.methods}
        self._scales = sorted({1, *(upscaler.scale for upscaler in self.upscalers.values())})
        self._cache, self._engine, self._camera, self._maker = cache, engine, camera, maker

    def render(self, *, progress: bool = True) -> int:
        """Render whatever the cache lacks; return how many pictures that were."""
        recipes = self.gallery_recipes()
        for condition in self.settings.conditions:
            for scale in self._scales:
                camera = self._camera if scale == 1 else self._camera.clean()
                recipes += [filmed(r, camera) for r in self.probe_recipes(condition, scale)]
        return render_missing(recipes, self._cache, progress=progress, maker=self._maker)

    def gallery_recipes(self) -> list[ProbeRecipe]:
        """Return the recipe of everyone's enrolled picture."""
        return self._recipes(kind="gallery", **asdict(self.settings.gallery))

    def probe_recipes(self, condition: Condition, scale: int) -> list[ProbeRecipe]:
        """Return the recipe of everyone's probe, or of its reference ``scale`` times finer."""
        return self._recipes(
            kind="probe",
            pose=condition.pose,
            lighting=condition.lighting,
            ipd_px=condition.ipd_px,
            scale=scale,
            samples_per_pixel=self.settings.rendering.samples_at(condition.ipd_px),
            lens=self.settings.lens,
            standpoint=self.settings.standpoint,
        )

    def outcomes(self) -> Iterator[Outcome]:
        """Score one condition after the other; what is not rendered yet is rendered."""
        gallery = self._load(self.gallery_recipes(), self._camera.clean())
        images, landmarks = stack(gallery)
        enrolled = self._engine.embed(images, landmarks.numpy())
        for condition in self.settings.conditions:
            yield self._outcome(condition, gallery, enrolled)

    def _outcome(self, condition: Condition, gallery: Sequence[Probe], enrolled: Floats) -> Outcome:
        camera = self._camera.compressing(condition.compression)
        probes = self._load(self.probe_recipes(condition, 1), camera)
        images, landmarks = stack(probes)
        references = {
            scale: stack(self._load(self.probe_recipes(condition, scale), camera.clean()))[0]
            for scale in self._scales[1:]
        }
        ids = [probe.identity_id for probe in probes], [face.identity_id for face in gallery]
        pictures = {"Gallery": stack(gallery[:SHOWN])[0], "Probe": images[:SHOWN]}
        rows, scores = [], {}
        for method, upscaler in self.upscalers.items():
            enlarged = upscaler(images)
            points = scale_points(landmarks, upscaler.scale).numpy()
            scores[method] = cosine_scores(self._engine.embed(enlarged, points), enrolled, *ids)
            quality = None
            if upscaler.scale > 1:
                pictures[upscaler.label] = enlarged[:SHOWN]
                quality = _psnr_y_db(enlarged, references[upscaler.scale], upscaler.scale)
            name, level = self.settings.name, self.settings.level
            label = method, upscaler.label
            rows.append(make_row(name, condition, label, scores[method], quality, level))
        if references:
            pictures["Reference"] = references[self._scales[-1]][:SHOWN]
        comparisons = tuple(compare_methods(condition, scores, self.settings.level))
        return Outcome(condition, tuple(rows), comparisons, scores, pictures)

    def _load(self, recipes: Sequence[ProbeRecipe], camera: Camera) -> list[Probe]:
        return load_probes(recipes, self._cache, camera, maker=self._maker)

    def _recipes(self, **what: Any) -> list[ProbeRecipe]:
        people, rendering = self.settings.identities, self.settings.rendering
        what |= {
            "split": people.split,
            "population": people.cast.population,
            "texture_size": rendering.texture_size,
            "skin": rendering.skin,
            "max_depth": rendering.max_depth,
        }
        return [
            ProbeRecipe(index=index, draw=people.cast.draw(people.split, index), **what).seeded(
                self.settings.seed
            )
            for index in range(people.start, people.start + people.count)
        ]


def _psnr_y_db(enlarged: torch.Tensor, true: torch.Tensor, scale: int) -> float | None:
    return mean_psnr_db(psnr_y(enlarged.numpy(), true.numpy(), shave=scale))
