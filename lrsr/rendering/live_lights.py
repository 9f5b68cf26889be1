"""Lights in the live scene, changed in place: the far map, and panels as rectangles that shine.

How many panels there are is part of what a scene is loaded with; where they stand, how large and
how bright they are is not.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lrsr.rendering.backend import dr, mi
from lrsr.rendering.environment import panel_radiance
from lrsr.rendering.lighting import Lighting

_PREFIX = "panel_"


def describe_panels(lighting: Lighting) -> dict[str, Any]:
    """Describe the panels of a lighting for ``mi.load_dict``; far away until they are moved."""
    return {
        f"{_PREFIX}{number}": {
            "type": "rectangle",
            "to_world": mi.ScalarTransform4f().translate([0.0, 0.0, 1e5 * (1 + number)]),
            "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}},
            "emitter": {"type": "area", "radiance": {"type": "rgb", "value": [1.0, 1.0, 1.0]}},
        }
        for number in range(len(lighting.panels))
    }


def move_panels(parameters: Any, lighting: Lighting, to_head: NDArray[np.float64]) -> None:
    """Put the panels of a lighting where they are for the head, and tell the scene.

    What is far away is told how large the scene is by the update after, so that comes later.

    Args:
        parameters: Of ``mi.traverse``.
        lighting: With as many panels as the scene was loaded with.
        to_head: ``(4, 4)``, takes the posed world back into the frame of the head.
    """
    for number, panel in enumerate(lighting.panels):
        name = f"{_PREFIX}{number}"
        radiance = (panel_radiance(panel) * panel.colour).tolist()
        parameters[f"{name}.to_world"] = opaque_transform(to_head @ panel.to_world())
        for key, value in _radiance(radiance).items():
            parameters[f"{name}.emitter.{key}"] = _opaque(value)
    if lighting.panels:
        parameters.update()


def map_data(painted: NDArray[np.float32], width: int) -> Any:
    """Return a painted map ``(H, W, 3)`` as Mitsuba's ``envmap`` keeps it, ``width`` columns."""
    if mi.is_spectral:  # as coefficients of spectra
        emitter = mi.load_dict({"type": "envmap", "bitmap": mi.Bitmap(painted.copy())})
        return mi.traverse(emitter)["data"]
    # It keeps copies of the outer columns at its sides.
    sides = ((0, 0), (1, width - painted.shape[1] - 1), (0, 0))
    return mi.TensorXf(np.pad(painted, sides, mode="wrap"))


def _radiance(rgb: list[float]) -> dict[str, Any]:
    """Return the parameters of an area emitter of that radiance, by their keys."""
    if not mi.is_spectral:
        return {"radiance.value": mi.Color3f(*rgb)}
    emitter = mi.load_dict({"type": "area", "radiance": {"type": "rgb", "value": rgb}})
    parameters = mi.traverse(emitter)
    return {key: parameters[key] for key in ("radiance.value", "radiance.d65.values")}


def opaque_transform(matrix: NDArray[np.float64]) -> Any:
    """Turn a ``(4, 4)`` matrix into a transform whose numbers are no literals of a kernel."""
    return _opaque(mi.Transform4f(matrix))


def _opaque(value: Any) -> Any:
    """Return numbers of Dr.Jit that are no literals of a kernel."""
    if "scalar" not in mi.variant():
        dr.make_opaque(value)
    return value
