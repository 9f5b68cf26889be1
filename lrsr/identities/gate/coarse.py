"""What do the gate's measures look at? Every second line of the mesh, and the template's own.

Catmull-Clark leaves the lines of the first round in the mesh of the second, so a quarter of the
quads, corner by corner, is a coarser head whose vertices lie on the fine one. Two sheets that cross
deeply enough to be seen cross there too.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lrsr.identities.face.template import template
from lrsr.identities.shape.basis import load_basis
from lrsr.identities.shape.subdivision import triangulate

Points = NDArray[np.float64]
Faces = NDArray[np.int64]


class _CoarseHead(NamedTuple):
    """Triangles of the template's head, without shoulders, sockets and mouth.

    Attributes:
        faces: ``(F, 3)``, vertices at one place under one index.
        centres: ``(F, 3)``, mm.
        across: ``(F, 3)`` normals, as long as twice the area, mm^2.
    """

    faces: Faces
    centres: Points
    across: Points

    def folded(self) -> tuple[Points, Points, Points]:
        """Return how far from the midline, how high and how far in front the centres lie, mm."""
        return np.abs(self.centres[:, 0]), self.centres[:, 1], self.centres[:, 2]


def coarse_quads() -> Faces:
    """Return the coarse quads of the whole mesh, in the order of the basis: ``(F, 4)``.

    Four quads of the fine mesh in a row make one of the coarse; each starts at one of its corners.
    """
    surface = load_basis().surface
    return surface.twin[surface.faces[::2, 0]].reshape(-1, 4)


@lru_cache(maxsize=1)
def coarse_head() -> _CoarseHead:
    """Return the template's coarse head; later calls are free."""
    on_head = load_basis().surface.region[::8] == 0
    faces = triangulate(coarse_quads()[on_head])
    corners = template().skin[faces]
    return _CoarseHead(faces, corners.mean(axis=1), normals(corners))


def normals(corners: Points) -> Points:
    """Return the normals of triangles ``(n, 3, 3)``, as long as twice their area: ``(n, 3)``."""
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
