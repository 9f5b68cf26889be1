"""From a head to the light on the film, by Mitsuba 3.

Nothing heavy is imported until one of these names is used, and Mitsuba not before it renders.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lrsr.rendering.lens import Lens, find_lens
    from lrsr.rendering.radiance import Radiance
    from lrsr.rendering.renderer import Renderer, render
    from lrsr.rendering.scene import Light, Lighting, Panel, Pose, find_lighting, find_pose
    from lrsr.rendering.standpoint import Standpoint, find_standpoint
    from lrsr.rendering.surfaces import Surface

_HOMES = {
    "Lens": "lens",
    "find_lens": "lens",
    "Surface": "surfaces",
    "Radiance": "radiance",
    "Renderer": "renderer",
    "render": "renderer",
    "Light": "scene",
    "Lighting": "scene",
    "Panel": "scene",
    "Standpoint": "standpoint",
    "find_standpoint": "standpoint",
    "Pose": "scene",
    "find_lighting": "scene",
    "find_pose": "scene",
}

__all__ = [
    "Lens",
    "Light",
    "Lighting",
    "Panel",
    "Pose",
    "Radiance",
    "Renderer",
    "Standpoint",
    "Surface",
    "find_lens",
    "find_lighting",
    "find_pose",
    "find_standpoint",
    "render",
]


def __getattr__(name: str) -> object:
    if name in _HOMES:
        return getattr(import_module(f"lrsr.rendering.{_HOMES[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
