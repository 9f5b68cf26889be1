"""What is skin to a tracer of every scattering? A homogeneous medium behind a smooth boundary.

This is the truth that :mod:`lrsr.rendering.subsurface` is measured against. It needs thousands of
times the samples, and it has no texture: the whole head is of one tone.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lrsr.identities.head import Part
from lrsr.rendering.backend import mi
from lrsr.rendering.diffusion import scattering_albedo
from lrsr.rendering.skin import Skin

LONGEST_PATH = 1000
"""Edges of the longest path; light scatters tens of times in skin before it leaves."""

_FROM_OUTSIDE = 0.0768
"""Share of diffuse light that a smooth boundary of index 1.4 reflects."""


def _medium_numbers(skin: Skin, part: Part) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return extinction and single-scattering albedo of a part's inside.

    Args:
        skin: Coefficients. Where the scattering is fixed, absorption follows from the part's
            median albedo.
        part: Of skin.

    Returns:
        extinction: ``(3,)`` σt, mm⁻¹.
        scattering: ``(3,)`` σs' / σt, [0, 1].
    """
    absorption, scattering = np.array([skin.absorption_per_mm, skin.scattering_per_mm])
    if skin.fixed == "scattering":
        tone = np.median(part.albedo.reshape(-1, 3), axis=0) / (1 - _FROM_OUTSIDE)
        share = np.array([scattering_albedo(float(channel)) for channel in tone])
        return scattering / share, share
    return scattering + absorption, scattering / (scattering + absorption)


def describe_medium(skin: Skin, part: Part) -> dict[str, Any]:
    """Describe a part's inside for ``mi.load_dict``."""
    extinction, scattering = _medium_numbers(skin, part)
    return {
        "type": "homogeneous",
        "scale": float(extinction.max()),  # Mitsuba takes no colours above 1
        "sigma_t": {"type": "rgb", "value": (extinction / extinction.max()).tolist()},
        "albedo": {"type": "rgb", "value": scattering.tolist()},
        "phase": {"type": "isotropic"},
    }


def describe_boundary(skin: Skin) -> dict[str, Any]:
    """Describe the surface around it for ``mi.load_dict``."""
    return {"type": "dielectric", "int_ior": skin.refractive_index, "ext_ior": 1.0}


def medium_parameters(skin: Skin, part: Part) -> dict[str, Any]:
    """Return what ``mi.traverse`` lists of that medium, to change a live one."""
    extinction, scattering = _medium_numbers(skin, part)
    return {
        "scale": float(extinction.max()),
        "sigma_t.value.value": mi.Color3f((extinction / extinction.max()).tolist()),
        "albedo.value.value": mi.Color3f(scattering.tolist()),
    }
