"""A maker that takes microseconds: what it makes depends on the recipe alone, as Mitsuba's does."""

import time
from collections.abc import Mapping

import numpy as np
import torch

from lrsr.identities.head import Head
from lrsr.pictures.recipe import Recipe, derived_seed
from lrsr.rendering.radiance import Radiance
from lrsr.spectra import band_edges


class FakeMaker:
    """Smooth random light; counts what it is asked for."""

    def __init__(self, delay_s: float = 0.0) -> None:
        self.delay_s = delay_s
        self.heads: list[str] = []
        self.renders: list[Recipe] = []
        self.versions: Mapping[str, str] = {"identities": "1", "renderer": "1", "variant": "fake"}

    def head(self, recipe: Recipe) -> Head:
        self.heads.append(recipe.person.id)
        return Head(recipe.person.id, (), np.zeros((2, 3)), np.zeros((5, 3)))

    def render(self, head: Head, recipe: Recipe) -> Radiance:
        assert head.identity_id == recipe.person.id
        time.sleep(self.delay_s)
        self.renders.append(recipe)
        film, scene = recipe.film, recipe.scene
        what = derived_seed(0, recipe.person.id, scene.pose, scene.lighting)
        noise = torch.rand(1, film.bands or 3, 8, 8, generator=torch.Generator().manual_seed(what))
        side = 4 * round(film.ipd_px) * film.scale
        light = torch.nn.functional.interpolate(noise, size=(side, side), mode="bilinear")
        return Radiance(
            image=light[0] * 2.0,
            landmarks_px=torch.arange(10.0).reshape(5, 2) * film.scale,
            ipd_px=film.ipd_px,
            scale=film.scale,
            metered=2.0,
            edges_nm=band_edges(film.bands) if film.bands else None,
            metered_bands=(1.0,) * film.bands if film.bands else None,
        )
