"""What does one known camera make of a sharp picture? It takes the picture for the light."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import torch
from torch.nn import functional as F

from lrsr.camera import Camera
from lrsr.camera.encoding import encode
from lrsr.camera.exposure import KEY
from lrsr.configuration import as_list, require
from lrsr.images import resize_bicubic, srgb_to_linear
from lrsr.training.patches import Pair
from lrsr.training.shrinking.clean import Clean
from lrsr.training.shrinking.shrinking import Shrinking


@dataclass(frozen=True)
class OneCamera(Shrinking):
    """The configured camera, with its lens, mosaic, noise, processing and file.

    A rendered scene is taken on a film of the small picture's pixels. Of a picture, linear light is
    averaged over them, and exposed as it was, but for the camera's ``exposure_ev``.

    Attributes:
        compressions: What becomes of the camera's picture; each is shown after every one of them.

    Raises:
        InputError: There is no such compression, or none at all.
    """

    compressions: Sequence[str] = ("none",)

    redrawn = False
    reads_camera = True

    def __post_init__(self) -> None:
        given = self.compressions
        listed = [given] if isinstance(given, str) else as_list(given, "degradation.compressions")
        require(len(listed) > 0, "degradation.compressions", [], "at least one")
        for name in listed:
            Camera(name)
        object.__setattr__(self, "compressions", tuple(listed))

    def cameras(self, camera: Camera) -> list[Camera]:
        """Return the camera with each compression."""
        return [camera.compressing(name) for name in self.compressions]

    def __call__(
        self, true: torch.Tensor, scale: int, seeds: Sequence[int], camera: Camera
    ) -> Iterator[Pair]:
        """Shrink pictures in linear light and photograph that; see the base."""
        light = srgb_to_linear(true)
        film = _on_film(light, scale, camera.supersampling)
        metered, exposed = torch.full((len(true),), KEY), encode(light * 2.0**camera.exposure_ev)
        for compressing in self.cameras(camera):
            yield compressing(film, metered, seeds), exposed

    def in_words(self, camera: Camera, *, of_films: bool) -> str:
        """Say how the small pictures are made."""
        if of_films and camera.flawless and {*self.compressions} == {"none"}:
            return Clean().in_words(camera, of_films=True)
        what = "the same scene on" if of_films else "the linear light of pictures averaged on"
        compressed = ", ".join(self.compressions)
        return (
            f"{what} a film of 1/scale the pixels, taken by the camera {camera.name},"
            f" compression {compressed}"
        )


def _on_film(light: torch.Tensor, scale: int, supersampling: int) -> torch.Tensor:
    """Make light ``scale`` times finer than a small picture ``supersampling`` times finer."""
    if scale % supersampling == 0:
        return F.avg_pool2d(light, scale // supersampling)
    return resize_bicubic(light, supersampling / scale).clamp_min(0)
