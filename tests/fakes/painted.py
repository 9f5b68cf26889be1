"""People made of paint: each identity a smooth random picture, aligned as a face would be."""

from collections.abc import Mapping

import numpy as np
import torch
import torch.nn.functional as F

from lrsr.identities.head import Head
from lrsr.pictures.recipe import Recipe
from lrsr.recognition.alignment import TEMPLATE_PX
from lrsr.rendering.geometry import film_size_px
from lrsr.rendering.radiance import Radiance

_FIRST = {"train": 0, "validation": 10**6, "test": 2 * 10**6, "photograph": 3 * 10**6}


class PaintedMaker:
    """Paints a face of 6×6 random tones over the frame; quick, and different for everyone."""

    versions: Mapping[str, str] = {"painted": "1"}

    def head(self, recipe: Recipe) -> Head:
        pupils = np.array([[-32.0, 0, 0], [32.0, 0, 0]])
        return Head(recipe.person.id, (), pupils, np.zeros((5, 3)))

    def render(self, head: Head, recipe: Recipe) -> Radiance:
        person, film = recipe.person, recipe.film
        generator = torch.Generator().manual_seed(_FIRST[person.split] + person.index)
        tones = torch.rand(1, 3, 6, 6, generator=generator)
        side = film_size_px(film.ipd_px) * film.scale
        image = F.interpolate(tones, size=(side, side), mode="bilinear")[0]
        noise = torch.Generator().manual_seed(recipe.seed)
        image = image + 0.02 * torch.rand(3, side, side, generator=noise)
        ipd = film.ipd_px * film.scale
        template_ipd = np.linalg.norm(TEMPLATE_PX[1] - TEMPLATE_PX[0])
        points = (TEMPLATE_PX - 55.5) * ipd / template_ipd + side / 2 - 0.5
        return Radiance(
            image=image,
            landmarks_px=torch.from_numpy(points.astype(np.float32)),
            ipd_px=film.ipd_px,
            scale=film.scale,
            metered=1.0,
        )
