"""From the light on the film to the stored file: exposure, encoding, compression."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lrsr.camera.camera import Camera

__all__ = ["Camera"]


def __getattr__(name: str) -> object:
    """Import the camera (and kornia with it) only when it is asked for.

    Raises:
        AttributeError: The part has no such name.
    """
    if name == "Camera":
        from lrsr.camera.camera import Camera

        return Camera
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
