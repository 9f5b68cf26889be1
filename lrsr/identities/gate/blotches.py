"""Is the colour of the skin that of skin? Its range, and dark patches where none belong."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lrsr.identities.face.template import template
from lrsr.identities.gate.intersection import coarse_faces
from lrsr.identities.shape.basis import load_basis

DARK = 0.35
"""Skin of less than this share of the face's median reflectance is a dark patch; moles, painted
pores and shadows of lids are smaller than what shares are limited to."""
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


class Paint(NamedTuple):
    """What an albedo holds.

    Attributes:
        lowest: Smallest reflectance, NaN if any is not finite.
        highest: Largest reflectance, likewise.
        dark_cheeks: Share of both cheeks' area darker than :data:`DARK` of the median.
        dark_nose: Of the nose above its nostrils.
        dark_forehead: Of the forehead above the brows.
    """

    lowest: float
    highest: float
    dark_cheeks: float
    dark_nose: float
    dark_forehead: float


def measure_paint(albedo: NDArray[np.float32]) -> Paint:
    """Measure the albedo of a skin.

    Args:
        albedo: ``(H, W, 3)``, linear reflectance, in the template's layout.
    """
    height, width = albedo.shape[:2]
    size = np.array([width, height])
    lights = []
    for uv in _zones():
        texel = np.minimum((uv * size).astype(np.int64), size - 1)
        lights.append(albedo[texel[:, 1], texel[:, 0]] @ _LUMINANCE)
    bound = DARK * float(np.median(np.concatenate(lights)))
    cheeks, nose, forehead = (float((light < bound).mean()) for light in lights)
    return Paint(float(albedo.min()), float(albedo.max()), cheeks, nose, forehead)


@lru_cache(maxsize=1)
def _zones() -> tuple[NDArray[np.float64], ...]:
    """Texture coordinates of points on cheeks, nose and forehead, about one every 4 mm^2."""
    skin, faces = template().skin, coarse_faces()
    centre = skin[faces].mean(axis=1)
    x, y, z = np.abs(centre[:, 0]), centre[:, 1], centre[:, 2]
    cheeks = (x > 20.0) & (x < 48.0) & (y > -44.0) & (y < -16.0) & (z > -25.0)
    nose = (x < 12.0) & (y > -40.0) & (y < -8.0) & (z > 4.0)
    forehead = (x < 30.0) & (y > 28.0) & (y < 44.0) & (z > -5.0)
    uv = load_basis().surface.uv
    return tuple(uv[faces[zone]].mean(axis=1) for zone in (cheeks, nose, forehead))
