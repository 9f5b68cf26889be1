"""From a head to the light on the film, by Mitsuba 3.

Nothing heavy is imported until one of these names is used, and Mitsuba not before it renders.
"""

from importlib import import_module

_HOMES = {
    "Film": "scene",
    "Lens": "lens",
    "Light": "lights",
    "Lighting": "lighting",
    "Panel": "lights",
    "Pose": "pose",
    "Quality": "scene",
    "Radiance": "radiance",
    "Renderer": "renderer",
    "Scene": "scene",
    "Skin": "skin",
    "Standpoint": "standpoint",
    "render": "renderer",
}

__all__ = list(_HOMES)


def __getattr__(name: str) -> object:
    if name in _HOMES:
        return getattr(import_module(f"lrsr.rendering.{_HOMES[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
