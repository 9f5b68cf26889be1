"""Makes small images larger: bicubic, SRCNN and SRCNN twice, behind one call.

Only what needs nothing but torch is imported here; :mod:`lrsr.sr.module` and
:mod:`lrsr.sr.training` bring Lightning, :mod:`lrsr.sr.export` brings the ONNX exporter.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from lrsr.sr.bicubic import resize_bicubic
    from lrsr.sr.srcnn import SRCNN
    from lrsr.sr.upscaling import METHODS, Upscaler

__all__ = ["METHODS", "SRCNN", "Upscaler", "resize_bicubic"]

_HOMES = {
    "METHODS": "upscaling",
    "SRCNN": "srcnn",
    "Upscaler": "upscaling",
    "resize_bicubic": "bicubic",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
