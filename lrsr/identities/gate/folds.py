"""Is the skin of a face a smooth sheet? Triangles turned over or crushed, against the template."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from lrsr.identities.gate.coarse import coarse_head, normals

Points = NDArray[np.float64]

_AREA_RATIO = (0.03, 25.0)


def measure_folds(skin: Points) -> dict[str, float]:
    """Compare the triangles of a face with the template's, outside eyes, nostrils and mouth.

    Args:
        skin: ``(V, 3)`` render vertices in the head frame, mm.

    Returns:
        The shares of triangles that face away from where they do on the template, and of those of
        less than 3 % or more than 25 times their area there.
    """
    faces, usual, area = _face()
    across = normals(skin[faces])
    ratio = np.linalg.norm(across, axis=1) / area
    turned = np.einsum("nc,nc->n", across, usual) < 0.0
    crushed = (ratio < _AREA_RATIO[0]) | (ratio > _AREA_RATIO[1]) | ~np.isfinite(ratio)
    return {
        "skin: share of triangles turned over": float(turned.mean()),
        "skin: share of triangles crushed": float(crushed.mean()),
    }


@lru_cache(maxsize=1)
def _face() -> tuple[NDArray[np.int64], Points, Points]:
    """Coarse triangles of the face's outside, their normals and lengths of these."""
    head = coarse_head()
    x, y, z = head.folded()
    length = np.linalg.norm(head.across, axis=1)
    eye = np.hypot(x - 31.0, y + 1.0) < 20.0
    nostril = (y < -38.0) & (y > -56.0) & (x < 22.0)
    mouth = (y < -58.0) & (y > -90.0) & (x < 34.0)
    front = (x < 64.0) & (y > -112.0) & (y < 70.0) & (z > -50.0)
    chosen = front & (head.across[:, 2] > 0.2 * length) & ~eye & ~nostril & ~mouth
    return head.faces[chosen], head.across[chosen], length[chosen]
