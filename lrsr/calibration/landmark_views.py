"""From which pictures are a landmark network's habits learned? Rendered people, known to the point.

Everybody is pictured first about frontally, then turned, under several lights, from near and far,
and at last with an expression. The people are drawn ones of the split "train".
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np
import torch
from numpy.typing import NDArray

from lrsr.camera import Camera
from lrsr.identities.face.expression import Expression
from lrsr.identities.head import Head
from lrsr.identities.person import Person
from lrsr.identities.photographs.person import Somebody
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.recipe import Recipe
from lrsr.pictures.render import take_pictures
from lrsr.presets import preset
from lrsr.rendering.pose import Pose
from lrsr.rendering.renderer import viewpoint_of
from lrsr.rendering.scene import Film, Quality, Scene
from lrsr.rendering.standpoint import Standpoint

_IPD_PX = 50.0
_SAMPLES = 16
_LIGHTINGS = ("frontal", "above", "side", "frontal")
_EXPRESSIONS = ("smile", "grin", "mouth_open", "squint", "frown", "surprise")
_NEAR_M, _FAR_M = 0.55, 2.5
_FRONTAL_DEG = (3.0, 4.0, 3.0)
_TURNED_DEG = (32.0, 18.0, 12.0)
"""Largest yaw, pitch and roll of the first view and of the others."""
_TEXTURE_SIZE = 64
"""Of heads of which only the shape is asked for: the least there is."""


@dataclass(frozen=True, eq=False)
class View:
    """One picture and what is true of it.

    Attributes:
        image: ``(3, H, W)`` float32, srgb, [0, 1].
        landmarks_px: ``(5, 2)`` true places of the five landmarks.
        head: Who it shows, with the expression; its textures are small.
        scene: How the head is held, and where the camera stands.
    """

    image: NDArray[np.float32]
    landmarks_px: NDArray[np.float64]
    head: Head
    scene: Scene

    def project(self, points_mm: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return where points of the head frame ``(N, 3)`` fall on the picture: ``(N, 2)``, px."""
        camera = viewpoint_of(self.head, self.scene, Film(_IPD_PX))
        return camera.project(self.scene.pose.turn(points_mm))

    @property
    def px_per_mm(self) -> float:
        """Scale of the picture at the pupils."""
        return _IPD_PX / self.head.ipd_mm


def plan_views(people: Sequence[Person], views: int = 4) -> list[Recipe]:
    """Return what is rendered, person after person.

    Args:
        people: Who.
        views: Of each, at least 2.
    """
    recipes = []
    for person in people:
        rng = np.random.default_rng([person.index, 55])
        for view in range(views):
            limits = np.array(_TURNED_DEG if view else _FRONTAL_DEG)
            yaw, pitch, roll = (float(angle) for angle in rng.uniform(-limits, limits))
            away = float(np.exp(rng.uniform(np.log(_NEAR_M), np.log(_FAR_M))))
            acted = str(rng.choice(_EXPRESSIONS)) if view == views - 1 else "neutral"
            scene = Scene(
                lighting=preset("lighting", str(rng.choice(_LIGHTINGS))),
                pose=Pose(f"view {view}", yaw, pitch, roll),
                standpoint=Standpoint("view", distance_m=away),
                expression=preset("expression", acted),
            )
            recipe = Recipe(person, scene, Film(_IPD_PX), Quality(samples_per_pixel=_SAMPLES))
            recipes.append(recipe.seeded(0, "probe"))
    return recipes


def take_views(recipes: Sequence[Recipe], cache: RenderCache) -> Iterator[View]:
    """Yield the views; what the cache lacks is rendered, and an interrupted call goes on.

    Args:
        recipes: Of :func:`plan_views`.
        cache: Where renderings are kept.

    Raises:
        InputError: The cache cannot be written.
    """
    pictures = take_pictures(recipes, cache, Camera())
    shown: tuple[Somebody, Expression] | None = None
    for recipe, picture in zip(recipes, pictures, strict=True):
        if shown != (recipe.person, recipe.scene.expression):
            shown = recipe.person, recipe.scene.expression
            head = recipe.person.head(recipe.scene.expression, _TEXTURE_SIZE)
        yield View(
            picture.image.numpy(),
            cast("torch.Tensor", picture.landmarks_px).numpy().astype(np.float64),
            head,
            recipe.scene,
        )
