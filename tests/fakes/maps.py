"""Faces without a renderer whose every point is known: paint that follows a real head's outline."""

from collections.abc import Mapping
from dataclasses import replace
from functools import cache, partial
from typing import Any

import numpy as np
import torch
from lightning.pytorch import LightningDataModule
from torch.utils.data import DataLoader, TensorDataset

from lrsr.identities.face.expression import NEUTRAL
from lrsr.identities.face.template import template
from lrsr.identities.head import Head
from lrsr.identities.person import Person
from lrsr.identities.shape.basis import load_basis
from lrsr.pictures.recipe import Recipe
from lrsr.rendering.radiance import Radiance
from lrsr.rendering.renderer import viewpoint_of
from lrsr.training.augmentation.background import Background
from lrsr.training.augmentation.blur import Blur
from lrsr.training.augmentation.colour import Colour
from lrsr.training.augmentation.misalignment import Misalignment
from lrsr.training.augmentation.occlusion import Occlusion
from lrsr.training.order import EpochOrder
from lrsr.training.portraits import Portraits
from lrsr.training.position_mapping import PositionMapping
from lrsr.training.position_maps import resting_map


@cache
def somebody() -> Head:
    """Return one person of the test split."""
    return Person("test", 3).head(NEUTRAL, 64)


def average_adult() -> Head:
    """Return a head of the template's shape, which no recipe changes."""
    head, average = somebody(), template()
    skin = average.skin.astype(np.float32)
    landmarks = np.concatenate([average.eyes.pupils, skin[load_basis().surface.landmarks]])
    parts = (replace(head.parts[0], vertices=skin), *head.parts[1:])
    return replace(head, parts=parts, pupils=average.eyes.pupils, landmarks=landmarks)


class DottedMaker:
    """Everybody has one head; its five landmarks are white dots on black."""

    versions: Mapping[str, str] = {"dotted": "1"}

    def head(self, recipe: Recipe) -> Head:
        return somebody()

    def render(self, head: Head, recipe: Recipe) -> Radiance:
        viewpoint = viewpoint_of(head, recipe.scene, recipe.film)
        points = viewpoint.project(recipe.scene.pose.turn(head.landmarks))
        y, x = np.mgrid[: viewpoint.film_px, : viewpoint.film_px]
        near = [np.hypot(x - right, y - down) < 1.5 for right, down in points]
        image = torch.from_numpy(np.any(near, axis=0).astype(np.float32)).expand(3, -1, -1)
        landmarks = torch.from_numpy(points.astype(np.float32))
        ipd_px = recipe.film.ipd_px
        return Radiance(image, landmarks, ipd_px=ipd_px, scale=1, metered=1.0)


class DrawnMaps(LightningDataModule):
    """Grey pictures that are the brighter the lower their face is."""

    def __init__(self, count: int = 4) -> None:
        super().__init__()
        lower = torch.linspace(-8, 8, count)
        maps = torch.from_numpy(resting_map()).float().repeat(count, 1, 1, 1)
        maps[:, 1] += lower[:, None, None]
        tones = (128 + 8 * lower).to(torch.uint8)
        self.data = TensorDataset(tones[:, None, None, None].repeat(1, 3, 112, 112), maps)

    def train_dataloader(self) -> DataLoader[Any]:
        order = EpochOrder(lambda _: np.arange(len(self.data)), batch_size=2, seed=0)
        return DataLoader(self.data, sampler=order, batch_size=None)

    def val_dataloader(self) -> DataLoader[Any]:
        return DataLoader(self.data, batch_size=2)


def portraits(**changes: Any) -> Portraits:
    """Nothing is done but what is given."""
    still = {
        "noise": 0.0,
        "background": Background(),
        "occlusion": Occlusion(),
        "blur": Blur(),
        "colour": Colour(),
        "misalignment": Misalignment(),
    }
    return Portraits(**{**still, **changes})


def make_mapping(**changes: Any) -> PositionMapping:
    given = {
        "optimizer": partial(torch.optim.AdamW, lr=2e-3),
        "portraits": portraits(noise=0.02, misalignment=Misalignment(jitter=0.02)),
        "features": 4.0,
        "behind": 0.1,
    }
    return PositionMapping(**{**given, **changes})
