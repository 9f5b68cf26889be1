"""Is the skin of a face a smooth sheet? Triangles turned over, against the template."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from lrsr.identities.gate.coarse import coarse_head, normals

Points = NDArray[np.float64]


def turned_share(skin: Points) -> float:
    """Return the share of a face's triangles that face away from where they do on the template.

    Args:
        skin: ``(V, 3)`` render vertices in the head frame, mm; eyes, nostrils and mouth are left
            out.
    """
    faces, usual = _face()
    turned = np.einsum("nc,nc->n", normals(skin[faces]), usual) < 0.0
    return float(turned.mean())


@lru_cache(maxsize=1)
def _face() -> tuple[NDArray[np.int64], Points]:
    """Coarse triangles of the face's outside, and their normals."""
    head = coarse_head()
    x, y, z = head.folded()
    length = np.linalg.norm(head.across, axis=1)
    eye = np.hypot(x - 31.0, y + 1.0) < 20.0
    nostril = (y < -38.0) & (y > -56.0) & (x < 22.0)
    mouth = (y < -58.0) & (y > -90.0) & (x < 34.0)
    front = (x < 64.0) & (y > -112.0) & (y < 70.0) & (z > -50.0)
    chosen = front & (head.across[:, 2] > 0.2 * length) & ~eye & ~nostril & ~mouth
    return head.faces[chosen], head.across[chosen]
