"""Who is photographed while a camera is sought? Rendered people, again and again."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import torch

from lrsr.camera.camera import Camera
from lrsr.camera.preset_file import build_camera
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.maker import Maker
from lrsr.pictures.render import filmed, load_radiances, render_missing
from lrsr.pictures.sitting import Sitting
from lrsr.rendering.scene import Film

_DRAW_SEEDS = 1_000_003
"""From the seeds of one draw of the noise to those of the next: more than there are people."""


@dataclass(frozen=True)
class Strangers:
    """Rendered people on their films, ready to be photographed again and again.

    Attributes:
        linear: ``(k, 3, S H, S W)``, scene-referred light.
        metered: ``(k,)``.
        supersampling: S.
        seed: Of the noise.
    """

    linear: torch.Tensor
    metered: torch.Tensor
    supersampling: int
    seed: int

    @property
    def size_px(self) -> tuple[int, int]:
        """(height, width) of a picture."""
        height, width = self.linear.shape[-2:]
        return height // self.supersampling, width // self.supersampling

    def photographed(
        self, camera: Camera, draw: int = 0, who: Sequence[int] | None = None
    ) -> torch.Tensor:
        """Return the pictures ``(k, 3, H, W)`` that a camera takes of them.

        Args:
            camera: Takes them.
            draw: Number of the draw of the noise, >= 0; another one has other noise everywhere.
            who: Numbers of those who are photographed; everybody if None.
        """
        people = list(range(len(self.linear)) if who is None else who)
        seeds = [self.seed + k + draw * _DRAW_SEEDS for k in people]
        with torch.no_grad():
            pictures: torch.Tensor = camera(self.linear[people], self.metered[people], seeds)
        return pictures

    def trial(
        self, preset: Mapping[str, Any], draw: int = 0, origins_px: Sequence[tuple[int, int]] = ()
    ) -> torch.Tensor:
        """Photograph with a preset, so that a small change of it changes the pictures little.

        Shot noise is that of the differentiable sensor: the same normal numbers in every trial,
        where Poisson's would be drawn anew. The file is the true codec's.

        Args:
            preset: Plain mapping as in ``conf/camera``.
            draw: Of the noise, see :meth:`photographed`.
            origins_px: Places of the pictures in their frames, which the strangers have in turn;
                the preset's own if empty.
        """
        stored = build_camera(preset).stored
        people = range(len(self.linear))
        turns = list(origins_px) or [tuple(preset["origin_px"])]
        places = [turns[k % len(turns)] for k in people]
        phases = [(x % 2, y % 2) for x, y in places]  # a mosaic repeats after two pixels
        pictures = self.linear.new_empty(len(people), 3, *self.size_px)
        for phase in dict.fromkeys(phases):
            who = [k for k in people if phases[k] == phase]
            there = {"origin_px": places[who[0]], "stored": None, "codec": "differentiable"}
            pictures[who] = self.photographed(build_camera({**preset, **there}), draw, who)
        if stored is not None:
            for place in dict.fromkeys(places):
                who = [k for k in people if places[k] == place]
                pictures[who] = stored(pictures[None, who], origin_px=place)
        return pictures

    def cropped(self, size_px: tuple[int, int]) -> "Strangers":
        """Return the middle of that (height, width), or less where there is not as much."""
        finer = self.supersampling
        tall, wide = (min(a, b) for a, b in zip(self.size_px, size_px, strict=True))
        top, left = (self.size_px[0] - tall) // 2, (self.size_px[1] - wide) // 2
        rows = slice(finer * top, finer * (top + tall))
        columns = slice(finer * left, finer * (left + wide))
        return replace(self, linear=self.linear[..., rows, columns])


def render_strangers(
    sitting: Sitting,
    ipd_px: float,
    supersampling: int,
    *,
    cache: RenderCache,
    maker: Maker | None = None,
    progress: bool = True,
) -> Strangers:
    """Render people who are not in the cache yet, and load all.

    Args:
        sitting: Who, and how, at 8 px.
        ipd_px: Of their faces in the pictures, px.
        supersampling: How much finer than a picture its film is.
        cache: Where renderings are kept.
        maker: Renders; Mitsuba when None.
        progress: Show a bar on stderr.

    Raises:
        InputError: The cache cannot be read or written.
    """
    camera = Camera(supersampling=supersampling)
    sized = replace(sitting, film=Film(ipd_px), quality=sitting.quality.at(ipd_px))
    films = [filmed(recipe, camera) for recipe in sized.recipes()]
    render_missing(films, cache, progress=progress, maker=maker)
    radiances = load_radiances(films, cache, progress=progress, maker=maker)
    linear = torch.stack([radiance.image for radiance in radiances])
    metered = torch.tensor([radiance.metered for radiance in radiances])
    return Strangers(linear, metered, supersampling, sitting.seed)
