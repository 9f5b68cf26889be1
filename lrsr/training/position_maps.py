"""From what does a network learn where every point of a face is? Rendered people, turned and lit.

A position map (Feng et al., *Joint 3D Face Reconstruction and Dense Alignment with Position Map
Regression Network*, ECCV 2018) is a texture whose three channels are places instead of colours. The
texture layout is ours, so what is true follows from the vertices of the head.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import cast

import numpy as np
import torch
from numpy.typing import NDArray
from torch.utils.data import DataLoader, TensorDataset

from lrsr.camera import Camera
from lrsr.configuration import as_list, as_number, require
from lrsr.identities.face.template import template
from lrsr.identities.head import Head
from lrsr.identities.person import Person
from lrsr.identities.photographs.crop import Crop, CropRule
from lrsr.identities.photographs.person import Somebody
from lrsr.identities.shape.basis import load_basis
from lrsr.identities.shape.position_map import Raster, cover, fill_outside
from lrsr.pictures.recipe import Recipe, derived_seed
from lrsr.recognition.alignment import CROP_PX
from lrsr.rendering.renderer import viewpoint_of
from lrsr.rendering.scene import Film, Scene
from lrsr.training.order import EpochOrder
from lrsr.training.rendered import Rendered
from lrsr.training.variety import Variety

MAP_SIZE = 64
"""Rows and columns of a map."""
RULE = CropRule(side=1.1, shift=0.0, size_px=CROP_PX)
"""From crown to chin: about 3.3 distances of the pupils."""
_TEXTURE_SIZE = 64
"""Of heads of which only the shape is asked for: the least there is."""

_Map = NDArray[np.float64]
_Batch = tuple[torch.Tensor, ...]


@dataclass(kw_only=True, eq=False)
class PositionMaps(Rendered):
    """Crops of faces, and where each texel is on them.

    See the base's attributes, too; the standpoint's height counts, its distance is ``distance_m``.

    Attributes:
        variety: Poses, lights and expressions; a person acts once.
        distance_m: Nearest and farthest camera, log-uniform.
        rendered_ipd_px: Of the renderings.
        views: Of each person.

    Raises:
        InputError: A value is out of its range.
    """

    variety: Variety
    distance_m: Sequence[float]
    rendered_ipd_px: float
    views: int

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, least in {"views": 1, "batch_size": 2}.items():
            value = getattr(self, name)
            require(value >= least, f"data.{name}", value, f"at least {least}")
        given = as_list(self.distance_m, "data.distance_m")
        away = [as_number(distance, "data.distance_m") for distance in given]
        holds = len(away) == 2 and 0 < away[0] <= away[1]
        require(holds, "data.distance_m", away, "0 < nearest <= farthest")
        require(
            self.rendered_ipd_px > 0, "data.rendered_ipd_px", self.rendered_ipd_px, "a number > 0"
        )
        self.plain = self.camera.compressing("none")

    def recipes(self, people: Sequence[Person]) -> list[Recipe]:
        """Return every view of some people, person by person."""
        return [view for person in people for view in self._views(person)]

    def _views(self, person: Person) -> Iterator[Recipe]:
        rng = np.random.default_rng(derived_seed(self.seed, "maps", person.id))
        near, far = np.log(self.distance_m)
        acted = self.variety.expression(rng)
        for view in range(self.views):
            away = round(float(np.exp(rng.uniform(near, far))), 3)
            scene = Scene(
                pose=self.variety.pose(rng),
                lighting=self.variety.lighting(rng),
                lens=self.lens,
                standpoint=replace(self.standpoint, distance_m=away),
                expression=acted if acted.units else self.expression,
                another_day=self.another_day,
            )
            seed = derived_seed(self.seed, "maps", person.id, view)
            yield Recipe(person, scene, Film(self.rendered_ipd_px), self.quality, seed)

    def shots(self) -> Iterator[tuple[Recipe, Camera]]:
        """Yield every picture that is needed and who takes it."""
        for recipe in self.recipes([*self.validation_people, *self.people]):
            yield recipe, self.plain

    def setup(self, stage: str | None = None) -> None:
        """Cut all faces and draw their maps, once.

        Args:
            stage: Lightning's; all stages need both.
        """
        if not hasattr(self, "faces"):
            self.faces = self._lessons(self.people)
            self.validation = self._lessons(self.validation_people)

    def _lessons(self, people: Sequence[Person]) -> TensorDataset:
        recipes, crops, maps = self.recipes(people), [], []
        shown: tuple[Somebody, Head] | None = None
        for recipe, picture in zip(recipes, self.taken(recipes, self.plain), strict=True):
            if shown is None or shown[0] != recipe.person:  # who acts once has one shape
                small = replace(recipe.quality, texture_size=_TEXTURE_SIZE)
                shown = recipe.person, self.maker.head(replace(recipe, quality=small))
            five_px = cast("torch.Tensor", picture.landmarks_px).numpy().astype(np.float64)
            crop = RULE.of_five(five_px)
            image = np.ascontiguousarray(picture.image.numpy().transpose(1, 2, 0))
            crops.append(np.rint(255 * crop.take(image)).astype(np.uint8))
            maps.append(_draw_map(shown[1], recipe, crop).astype(np.float32))
        faces = torch.from_numpy(np.stack(crops)).permute(0, 3, 1, 2).contiguous()
        return TensorDataset(faces, torch.from_numpy(np.stack(maps)))

    def train_dataloader(self) -> DataLoader[_Batch]:
        """Return batches of crops ``(B, 3, 112, 112)`` uint8 and maps ``(B, 3, 64, 64)``, px."""
        order = EpochOrder(
            lambda _: np.arange(len(self.faces)), batch_size=self.batch_size, seed=self.seed
        )
        return DataLoader(self.faces, sampler=order, batch_size=None)

    def val_dataloader(self) -> DataLoader[_Batch]:
        """Return the same of the validation people, in their order."""
        return DataLoader(self.validation, batch_size=self.batch_size)


def _draw_map(head: Head, recipe: Recipe, crop: Crop) -> _Map:
    """Return where every texel of a head's skin is on a crop of its picture.

    Args:
        head: As it was rendered.
        recipe: Of the picture.
        crop: Of it.

    Returns:
        ``(3, 64, 64)``: x, y, px of the crop; and how much nearer than the pupils, in the same
        unit, as PRNet has it. Texels outside the skin hold what the nearest within does.
    """
    viewpoint, pose = viewpoint_of(head, recipe.scene, recipe.film), recipe.scene.pose
    skin = pose.turn(head.parts[0].vertices.astype(np.float64))
    pupils_mm = float(viewpoint.depth_mm(pose.turn(head.pupils)).mean())
    nearer = (pupils_mm - viewpoint.depth_mm(skin)) * viewpoint.pixels_per_slope / pupils_mm
    places = crop.within(viewpoint.project(skin))
    return _drawn(np.column_stack([places, nearer / crop.scale]))


def resting_map() -> _Map:
    """Return the map ``(3, 64, 64)`` of the mean face before a far camera, px of the crop."""
    skin = template().skin
    eyes = template().eyes.centres * [1, 1, 0]
    five_mm = np.concatenate([eyes, skin[load_basis().surface.landmarks]])[:, :2] * [1, -1]
    crop = RULE.of_five(five_mm)
    return _drawn(np.column_stack([crop.within(skin[:, :2] * [1, -1]), skin[:, 2] / crop.scale]))


def skin_mask() -> NDArray[np.bool_]:
    """Return which texels ``(64, 64)`` are skin: without mouth and ears, it has a mirror image."""
    mask = np.zeros((MAP_SIZE, MAP_SIZE), dtype=bool)
    mask[_raster().row, _raster().column] = True
    return mask


def _drawn(values: NDArray[np.float64]) -> _Map:
    """Draw values ``(V, C)`` of the skin's vertices as ``(C, 64, 64)``."""
    drawn, mask = _raster().draw(_faces(), values)
    return fill_outside(drawn, mask).transpose(2, 0, 1)


@lru_cache(maxsize=1)
def _raster() -> Raster:
    return cover(load_basis().surface.uv, _faces(), MAP_SIZE)


def _faces() -> NDArray[np.int32]:
    surface = load_basis().surface
    return np.asarray(surface.faces[surface.region == 0])
