"""A maker that takes microseconds: what it makes depends on the recipe alone, as Mitsuba's does."""

import time
from collections.abc import Mapping

import numpy as np
import torch
from lrsr.data.recipe import ProbeRecipe, derived_seed

from lrsr.identities.head import Head
from lrsr.rendering.radiance import Radiance
from lrsr.spectra import band_edges


class FakeMaker:
    """Smooth random light; counts what it is asked for."""

    def __init__(self, delay_s: float = 0.0) -> None:
        self.delay_s = delay_s
        self.heads: list[str] = []
        self.renders: list[ProbeRecipe] = []
        self.versions: Mapping[str, str] = {"identities": "1", "renderer": "1", "variant": "fake"}

    def head(self, recipe: ProbeRecipe) -> Head:
        self.heads.append(recipe.identity_id)
        return Head(recipe.identity_id, (), np.zeros((2, 3)), np.zeros((5, 3)))

    def render(self, head: Head, recipe: ProbeRecipe) -> Radiance:
        assert head.identity_id == recipe.identity_id
        time.sleep(self.delay_s)
        self.renders.append(recipe)
        pose = recipe.pose if isinstance(recipe.pose, str) else recipe.pose.name
        lighting = recipe.lighting if isinstance(recipe.lighting, str) else recipe.lighting.name
        what = derived_seed(0, recipe.identity_id, recipe.pose, recipe.lighting)
        channels = recipe.bands or 3
        noise = torch.rand(1, channels, 8, 8, generator=torch.Generator().manual_seed(what))
        side = 4 * round(recipe.ipd_px) * recipe.scale
        film = torch.nn.functional.interpolate(noise, size=(side, side), mode="bilinear")
        return Radiance(
            image=film[0] * 2.0,
            landmarks_px=torch.arange(10.0).reshape(5, 2) * recipe.scale,
            ipd_px=recipe.ipd_px,
            scale=recipe.scale,
            metered=2.0,
            seed=recipe.seed,
            identity_id=recipe.identity_id,
            pose=pose,
            lighting=lighting,
            edges_nm=band_edges(recipe.bands) if recipe.bands else None,
            metered_bands=(1.0,) * recipe.bands if recipe.bands else None,
        )
