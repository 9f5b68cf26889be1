"""From the light on the film to the stored file: the camera and the stages it is made of."""

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
