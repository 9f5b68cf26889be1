"""Which faces does the embedder learn from? Rendered people, each seen in many ways.

Each person of the split "train" is rendered a few times **sharp** (about as large as the aligned
crop, so that training can make any smaller face of them) and a few times **small** (as the camera
really delivers them at 7 to 16 px between the eyes). The people of the split "validation" choose
the best epoch; nobody of "test" is touched.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
import torch.nn.functional as F

from lrsr.camera import Camera
from lrsr.data.cache import RenderCache
from lrsr.data.maker import Maker, mitsuba_maker
from lrsr.data.probes import Probe, load_probes, render_missing
from lrsr.data.recipe import ProbeRecipe, derived_seed
from lrsr.data.variety import random_expression, random_lighting, random_pose
from lrsr.errors import InputError
from lrsr.identities.roster import Casting
from lrsr.identities.splits import Split
from lrsr.images import scale_points
from lrsr.recognition.alignment import align

VALIDATION_IPDS_PX = (64, 14, 11, 8)
"""Sizes of the validation probes, which meet the gallery: frontal pose, light from above."""

SMALL_AS = (("none", 1), ("small", 1), ("heavy", 1), ("none", 4), ("small", 4), ("heavy", 4))
"""A small view is shown after each compression, as it is and enlarged bicubically by 4."""

_CHUNK = 64


@dataclass(frozen=True)
class FaceSettings(Casting):
    """What is rendered to train and to validate an embedder, and of whom (the base's attributes).

    Attributes:
        identities: People to learn, of the split "train", >= 2.
        start: Number of the first of them.
        sharp_views: Renderings per person at ``sharp_ipd_px``; the first one is frontal.
        small_views: Renderings per person at ``small_ipd_px``.
        sharp_ipd_px: Lowest and highest IPD of the sharp views, px.
        small_ipd_px: Lowest and highest IPD of the small views, px.
        expression_share: How many of the views, but never the first, show a mild expression, 0..1.
        sharp_samples: Rays per pixel of the sharp views.
        small_samples: Rays per pixel of the small views.
        validation_identities: People of the split "validation", >= 2.
        validation_samples: Rays per pixel of their small views; an experiment takes 2048.
        texture_size: Of the heads' albedo, px.
        skin: Name of a skin, or any other.
        max_depth: Longest light path.
        antialias: Average when alignment makes a face smaller; goes into the contract.
        seed: Poses, lights and samplers follow from it.

    Raises:
        InputError: A value is out of its range.
    """

    identities: int = 560
    start: int = 0
    sharp_views: int = 4
    small_views: int = 2
    sharp_ipd_px: tuple[float, float] = (32.0, 36.0)
    small_ipd_px: tuple[float, float] = (7.0, 16.0)
    expression_share: float = 0.0
    sharp_samples: int = 16
    small_samples: int = 96
    validation_identities: int = 60
    validation_samples: int = 256
    texture_size: int = 1024
    skin: Any = "reflective"
    max_depth: int = 5
    antialias: bool = True
    seed: int = 0

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("sharp_ipd_px", "small_ipd_px"):
            low, high = (float(ipd) for ipd in getattr(self, name))
            object.__setattr__(self, name, (low, high))
            if not 0 < low <= high:
                raise InputError(f"faces.{name}={[low, high]}: wanted 0 < lowest <= highest")
        if not 0 <= self.expression_share <= 1:
            raise InputError(f"faces.expression_share={self.expression_share}: wanted 0 to 1")
        least = {"identities": 2, "validation_identities": 2, "sharp_views": 1, "small_views": 0}
        for name, minimum in least.items():
            if getattr(self, name) < minimum:
                raise InputError(f"faces.{name}={getattr(self, name)}: wanted at least {minimum}")
        for index in (self.start, self.start + self.identities - 1):
            self.cast.draw("train", index)  # refuses who is not on the roster


@dataclass(frozen=True)
class Faces:
    """Aligned faces in memory.

    Attributes:
        crops: ``(N, 3, 112, 112)`` uint8, srgb.
        people: ``(N,)`` int64, 0, 1, ... in the order of the identities.
        sharp: ``(N,)`` bool: may training make them smaller?
    """

    crops: torch.Tensor
    people: torch.Tensor
    sharp: torch.Tensor

    def __len__(self) -> int:
        return len(self.crops)

    def __getitem__(self, rows: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        """Return crops, people and sharpness of these rows."""
        return self.crops[rows], self.people[rows], self.sharp[rows]


def training_recipes(settings: FaceSettings) -> list[ProbeRecipe]:
    """Return every view of every person to learn: person by person, sharp ones first."""
    return [
        view
        for index in range(settings.start, settings.start + settings.identities)
        for view in _views(settings, index)
    ]


def validation_recipes(settings: FaceSettings) -> dict[str, list[ProbeRecipe]]:
    """Return the views of the validation people: "gallery", then "ipd64", "ipd14", ..."""
    people = range(settings.validation_identities)
    gallery = [_frontal(settings, "validation", index, 64.0, "frontal") for index in people]
    probes = {
        f"ipd{ipd}": [_frontal(settings, "validation", index, ipd, "above") for index in people]
        for ipd in VALIDATION_IPDS_PX
    }
    return {"gallery": gallery, **probes}


def render_faces(
    settings: FaceSettings,
    cache: RenderCache,
    *,
    progress: bool = True,
    maker: Maker | None = None,
) -> int:
    """Render all that training needs and ``cache`` lacks; interrupted, the next call goes on.

    Returns:
        How many pictures were rendered.

    Raises:
        InputError: The cache cannot be written.
    """
    recipes = [view for views in validation_recipes(settings).values() for view in views]
    return render_missing(
        [*recipes, *training_recipes(settings)], cache, progress=progress, maker=maker
    )


def load_training_faces(
    settings: FaceSettings, cache: RenderCache, *, progress: bool = True, maker: Maker | None = None
) -> Faces:
    """Photograph and align the training views: a sharp one once, a small one as :data:`SMALL_AS`.

    Raises:
        InputError: The cache cannot be read or written.
    """
    recipes = training_recipes(settings)
    views_each = settings.sharp_views + settings.small_views
    people = [row // views_each for row in range(len(recipes))]
    sharp = [row % views_each < settings.sharp_views for row in range(len(recipes))]
    crops: list[torch.Tensor] = []
    owners: list[int] = []
    for compression in ("none", "small", "heavy"):
        rows = [row for row in range(len(recipes)) if compression == "none" or not sharp[row]]
        probes = _photographed([recipes[row] for row in rows], cache, compression, progress, maker)
        for row, probe in zip(rows, probes, strict=True):
            factors = [1] if sharp[row] else [f for name, f in SMALL_AS if name == compression]
            crops += [crop_face(probe, factor, antialias=settings.antialias) for factor in factors]
            owners += [row] * len(factors)
    return Faces(
        crops=torch.stack(crops),
        people=torch.tensor([people[row] for row in owners]),
        sharp=torch.tensor([sharp[row] for row in owners]),
    )


def load_validation_faces(
    settings: FaceSettings, cache: RenderCache, *, progress: bool = True, maker: Maker | None = None
) -> dict[str, torch.Tensor]:
    """Photograph (without compression) and align the validation views.

    Returns:
        "gallery", "ipd64", ...: each ``(people, 3, 112, 112)`` uint8.

    Raises:
        InputError: The cache cannot be read or written.
    """
    return {
        name: torch.stack(
            [
                crop_face(probe, 1, antialias=settings.antialias)
                for probe in _photographed(recipes, cache, "none", progress, maker)
            ]
        )
        for name, recipes in validation_recipes(settings).items()
    }


def crop_face(probe: Probe, factor: int, *, antialias: bool) -> torch.Tensor:
    """Enlarge a picture bicubically (a = -0.5) by ``factor`` and align it.

    Returns:
        ``(3, 112, 112)`` uint8.
    """
    image, landmarks = probe.image[None], probe.landmarks_px
    if factor > 1:
        image = enlarge(image, factor)
        landmarks = scale_points(landmarks, factor)
    crops, _ = align(image, landmarks[None].numpy(), antialias=antialias)
    return crops[0].mul(255).round().to(torch.uint8)


def enlarge(srgb: torch.Tensor, factor: int) -> torch.Tensor:
    """Enlarge srgb images bicubically with a = -0.5 (PyTorch's, when told to antialias)."""
    enlarged = F.interpolate(srgb, scale_factor=factor, mode="bicubic", antialias=True)
    return enlarged.clamp(0, 1)


def _views(settings: FaceSettings, index: int) -> Iterator[ProbeRecipe]:
    rng = np.random.default_rng(derived_seed(settings.seed, "faces", index))
    of_expression = np.random.default_rng(derived_seed(settings.seed, "expressions", index))
    for view in range(settings.sharp_views + settings.small_views):
        sharp = view < settings.sharp_views
        low, high = settings.sharp_ipd_px if sharp else settings.small_ipd_px
        pose, lighting = random_pose(rng), random_lighting(rng)
        acted = random_expression(of_expression)
        acting = view > 0 and of_expression.random() < settings.expression_share
        yield ProbeRecipe(
            split="train",
            index=index,
            population=settings.cast.population,
            draw=settings.cast.draw("train", index),
            pose="frontal" if view == 0 else pose,
            expression=acted if acting else "neutral",
            lighting=lighting,
            ipd_px=round(rng.uniform(low, high), 2),
            samples_per_pixel=settings.sharp_samples if sharp else settings.small_samples,
            seed=derived_seed(settings.seed, "faces", index, view),
            texture_size=settings.texture_size,
            skin=settings.skin,
            max_depth=settings.max_depth,
        )


def _frontal(
    settings: FaceSettings, split: Split, index: int, ipd_px: float, lighting: str
) -> ProbeRecipe:
    large = ipd_px >= 32
    return ProbeRecipe(
        split=split,
        index=index,
        population=settings.cast.population,
        draw=settings.cast.draw(split, index),
        kind="gallery" if lighting == "frontal" else "probe",
        lighting=lighting,
        ipd_px=ipd_px,
        samples_per_pixel=settings.sharp_samples if large else settings.validation_samples,
        seed=derived_seed(settings.seed, split, index, ipd_px, lighting),
        texture_size=settings.texture_size,
        skin=settings.skin,
        max_depth=settings.max_depth,
    )


def _photographed(
    recipes: Sequence[ProbeRecipe],
    cache: RenderCache,
    compression: str,
    progress: bool,
    maker: Maker | None,
) -> Iterator[Probe]:
    """Yield the pictures a few at a time: as floats they would not all fit in memory."""
    chosen, camera = maker or mitsuba_maker(), Camera(compression)
    for start in range(0, len(recipes), _CHUNK):
        chunk = recipes[start : start + _CHUNK]
        yield from load_probes(chunk, cache, camera, progress=progress, maker=chosen)
