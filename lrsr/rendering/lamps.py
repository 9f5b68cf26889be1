"""Panels in the live scene: rectangles that shine, moved and recoloured in place.

How many there are is part of what a scene is loaded with; where they stand, how large and how
bright they are is not.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lrsr.rendering.backend import start
from lrsr.rendering.environment import panel_radiance
from lrsr.rendering.lighting import Lighting

PREFIX = "panel_"


def describe_panels(lighting: Lighting) -> dict[str, Any]:
    """Describe the panels of a lighting for ``mi.load_dict``; far away until they are moved."""
    mi = start()
    return {
        f"{PREFIX}{number}": {
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
    from lrsr.rendering.stage import opaque_transform

    mi = start()
    for number, panel in enumerate(lighting.panels):
        name = f"{PREFIX}{number}"
        radiance = (panel_radiance(panel) * panel.colour).tolist()
        parameters[f"{name}.to_world"] = opaque_transform(to_head @ panel.to_world())
        parameters[f"{name}.emitter.radiance.value"] = opaque_colour(mi.Color3f(*radiance))
    if lighting.panels:
        parameters.update()


def opaque_colour(colour: Any) -> Any:
    """Return a colour whose numbers are no literals of a kernel."""
    mi = start()
    if "scalar" not in mi.variant():
        import drjit

        drjit.make_opaque(colour)
    return colour
