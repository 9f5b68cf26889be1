"""From the light on the film to the stored file: the camera and the stages it is made of."""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lrsr.camera.camera import Camera
    from lrsr.camera.codec import Jpeg
    from lrsr.camera.colour import Colour
    from lrsr.camera.mosaic import Mosaic
    from lrsr.camera.optics import Optics
    from lrsr.camera.processing import Processing
    from lrsr.camera.sensor import Sensor
    from lrsr.camera.spectral import SpectralColour
    from lrsr.camera.video import Video

__all__ = [
    "Camera",
    "Colour",
    "Jpeg",
    "Mosaic",
    "Optics",
    "Processing",
    "Sensor",
    "SpectralColour",
    "Video",
]


def __getattr__(name: str) -> object:
    """Import a stage (torch, kornia or PyAV with it) only when it is asked for.

    Raises:
        AttributeError: The package has no such name.
    """
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    home = {"Jpeg": "codec", "SpectralColour": "spectral"}.get(name, name.lower())
    return getattr(import_module(f"{__name__}.{home}"), name)
