"""Does hair sit on its forehead? With a soft edge that lies flat, not with a helmet's.

Distances are to the nearest vertex of the coarse head; vertices lie 2 to 7 mm apart, so distances
are too large by up to half of that.
"""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lrsr.identities.face.template import template
from lrsr.identities.gate.coarse import coarse_head
from lrsr.identities.hair.shell import ROWS

EVERY_COLUMN = 8
"""Of so many columns of the hair one is looked at."""


def edge_height_mm(shell: NDArray[np.floating], skin: NDArray[np.floating]) -> float:
    """Return the median height over the skin of the hair's edge on the forehead.

    Args:
        shell: ``(n, ROWS or more, 3)``, mm: some of the columns of the hair's shell.
        skin: ``(V, 3)`` render vertices of the skin, mm.

    Returns:
        mm; 0 without such an edge.
    """
    tips = shell[:, ROWS - 2].astype(np.float32)
    tips = tips[(np.abs(tips[:, 0]) < 55.0) & (tips[:, 1] > 25.0) & (tips[:, 2] > -60.0)]
    if len(tips) <= 3:
        return 0.0
    vertices = skin[_scalp_vertices()]
    tree = cKDTree(vertices, balanced_tree=False, compact_nodes=False)  # few queries: build fast
    return float(np.median(tree.query(tips)[0]))


@lru_cache(maxsize=1)
def _scalp_vertices() -> NDArray[np.int64]:
    """Vertices of the coarse head, but for the middle of the face."""
    vertices = np.unique(coarse_head().faces)
    skin = template().skin[vertices]
    face = (np.abs(skin[:, 0]) < 50.0) & (skin[:, 1] < 10.0) & (skin[:, 2] > -40.0)
    return np.asarray(vertices[~face])
