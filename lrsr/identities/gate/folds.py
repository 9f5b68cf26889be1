"""Is the skin of a face a smooth sheet? Triangles turned over or crushed, against the template."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lrsr.identities.face.template import template
from lrsr.identities.gate.intersection import coarse_faces

Points = NDArray[np.float64]

_AREA_RATIO = (0.03, 25.0)


class Folds(NamedTuple):
    """How a face's mesh differs from the template's, outside eyes, nostrils and mouth.

    Attributes:
        turned_share: Of triangles that face away from where they do on the template.
        crushed_share: Of triangles of less than 3 % or more than 25 times their area there.
    """

    turned_share: float
    crushed_share: float


def measure_folds(skin: Points) -> Folds:
    """Compare the triangles of a face with the template's.

    Args:
        skin: ``(V, 3)`` render vertices in the head frame, mm.
    """
    faces, usual, area = _face()
    across = _across(skin, faces)
    ratio = np.linalg.norm(across, axis=1) / area
    turned = np.einsum("nc,nc->n", across, usual) < 0.0
    crushed = (ratio < _AREA_RATIO[0]) | (ratio > _AREA_RATIO[1]) | ~np.isfinite(ratio)
    return Folds(float(turned.mean()), float(crushed.mean()))


def _across(skin: Points, faces: NDArray[np.int64]) -> Points:
    a, b, c = (skin[faces[:, k]] for k in range(3))
    return np.cross(b - a, c - a)


@lru_cache(maxsize=1)
def _face() -> tuple[NDArray[np.int64], Points, Points]:
    """Coarse triangles of the face's outside, their normals and lengths of these."""
    faces, skin = coarse_faces(), template().skin
    centre = skin[faces].mean(axis=1)
    x, y, z = np.abs(centre[:, 0]), centre[:, 1], centre[:, 2]
    across = _across(skin, faces)
    length = np.linalg.norm(across, axis=1)
    eye = np.hypot(x - 31.0, y + 1.0) < 20.0
    nostril = (y < -38.0) & (y > -56.0) & (x < 22.0)
    mouth = (y < -58.0) & (y > -90.0) & (x < 34.0)
    front = (x < 64.0) & (y > -112.0) & (y < 70.0) & (z > -50.0) & (across[:, 2] > 0.2 * length)
    chosen = front & ~eye & ~nostril & ~mouth
    return faces[chosen], across[chosen], length[chosen]
