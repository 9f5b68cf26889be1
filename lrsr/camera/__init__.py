"""From the light on the film to the stored file: the camera and the stages it is made of."""

import importlib
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

_HOMES = {
    "Camera": "lrsr.camera.camera",
    "Colour": "lrsr.camera.colour",
    "Jpeg": "lrsr.camera.codec",
    "Mosaic": "lrsr.camera.mosaic",
    "Optics": "lrsr.camera.optics",
    "Processing": "lrsr.camera.processing",
    "Sensor": "lrsr.camera.sensor",
    "SpectralColour": "lrsr.camera.spectral",
    "Video": "lrsr.camera.video",
}


def __getattr__(name: str) -> object:
    """Import a stage (and kornia or PyAV with it) only when it is asked for.

    Raises:
        AttributeError: The package has no such name.
    """
    if name in _HOMES:
        return getattr(importlib.import_module(_HOMES[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
