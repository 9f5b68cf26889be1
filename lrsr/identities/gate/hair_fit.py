"""Does hair sit on its head? Attached to the skin, off the face, with an edge that is no helmet's.

Distances are to the nearest vertex of the coarse head; vertices lie 2 to 7 mm apart, so distances
are too large by up to half of that.
"""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lrsr.identities.face.template import template
from lrsr.identities.gate.coarse import coarse_head
from lrsr.identities.hair.paths import COLUMNS
from lrsr.identities.hair.shell import ROWS
from lrsr.identities.shape.basis import load_basis

Points = NDArray[np.float64]

_EVERY_COLUMN = 8
_FACE_TOP_MM = 8.0
"""Hair may hang to the brows, this far above the pupils."""


def measure_hair(
    hair: NDArray[np.floating], skin: NDArray[np.floating], pupils: Points, *, stands: bool
) -> dict[str, float]:
    """Measure how hair sits on a head.

    Args:
        hair: ``(N, 3)``, mm: the vertices of the shell, or of all hair, the shell first.
        skin: ``(V, 3)`` render vertices of the skin, mm.
        pupils: ``(2, 3)``, mm.
        stands: Whether there is any: that of shaved heads is hidden below the skin.

    Returns:
        How far from the skin the columns of the shell stay even where they come nearest to it (the
        column at the 95th percentile), the shares of the vertices that hang before an eye and
        before nose and mouth, and the median height of the shell's edge over the forehead, 0
        without such an edge.
    """
    corners = skin[load_basis().surface.landmarks[1:]]
    sampled = hair[: COLUMNS * ROWS].reshape(COLUMNS, ROWS, 3)[::_EVERY_COLUMN, ::2]
    off = _distances(skin[_scalp_vertices()], sampled)
    eyes, face = _before(hair, pupils, corners)
    return {
        "hair: off the skin, mm": float(np.percentile(off.min(axis=1), 95)),
        "hair: share before the eyes": eyes,
        "hair: share before nose and mouth": face,
        "hair: height of the edge on the forehead, mm": (
            _edge_height(sampled[:, -1], off[:, -1]) if stands else 0.0
        ),
    }


def _distances(vertices: NDArray[np.floating], lines: NDArray[np.floating]) -> Points:
    """Return how far the points of lines ``(n, k, 3)`` are from the nearest vertex: ``(n, k)``."""
    tree = cKDTree(vertices, balanced_tree=False, compact_nodes=False)  # few queries: build fast
    return np.asarray(tree.query(lines.reshape(-1, 3))[0].reshape(lines.shape[:2]))


def _before(
    hair: NDArray[np.floating], pupils: Points, corners: NDArray[np.floating]
) -> tuple[float, float]:
    """Share of the hair's vertices before the eyes, and before nose and mouth."""
    x, y, z = hair[:, 0], hair[:, 1], hair[:, 2]
    front = (z > 0.0) & (y < _FACE_TOP_MM)
    eyes = front & (np.abs(x[:, None] - pupils[:, 0]) < 13.0).any(axis=1) & (y > -8.0)
    half = float(np.abs(corners[:, 0]).max())
    bottom = float(corners[:, 1].min()) - 15.0
    face = front & (np.abs(x) < half) & (y > bottom) & (y < -8.0)
    return float(eyes.mean()), float(face.mean())


def _edge_height(tips: NDArray[np.floating], off: Points) -> float:
    """Median height over the skin of the tips that end on the forehead."""
    forehead = (np.abs(tips[:, 0]) < 55.0) & (tips[:, 1] > 25.0) & (tips[:, 2] > -60.0)
    return float(np.median(off[forehead])) if forehead.sum() > 3 else 0.0


@lru_cache(maxsize=1)
def _scalp_vertices() -> NDArray[np.int64]:
    """Vertices of the coarse head, but for the middle of the face."""
    vertices = np.unique(coarse_head().faces)
    skin = template().skin[vertices]
    face = (np.abs(skin[:, 0]) < 50.0) & (skin[:, 1] < 10.0) & (skin[:, 2] > -40.0)
    return np.asarray(vertices[~face])
