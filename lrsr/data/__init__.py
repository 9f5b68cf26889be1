"""Renders what an experiment needs, keeps it, and serves it as pairs of tensors."""

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lrsr.data.cache import RenderCache
    from lrsr.data.datamodule import ProbeDataModule
    from lrsr.data.probes import Probe, load_probes, render_missing
    from lrsr.data.recipe import ProbeRecipe

__all__ = [
    "Probe",
    "ProbeDataModule",
    "ProbeRecipe",
    "RenderCache",
    "load_probes",
    "render_missing",
]

_HOMES = {
    "Probe": "lrsr.data.probes",
    "ProbeDataModule": "lrsr.data.datamodule",
    "ProbeRecipe": "lrsr.data.recipe",
    "RenderCache": "lrsr.data.cache",
    "load_probes": "lrsr.data.probes",
    "render_missing": "lrsr.data.probes",
}


def __getattr__(name: str) -> object:
    """Import a part (and torch, kornia or lightning with it) only when it is asked for.

    Raises:
        AttributeError: The package has no such name.
    """
    if name in _HOMES:
        return getattr(importlib.import_module(_HOMES[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
