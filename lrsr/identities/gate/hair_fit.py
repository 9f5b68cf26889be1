"""Does hair sit on its head? Attached to the skin, off the face, with an edge that is no helmet's.

Distances are to the nearest vertex of the coarse head or, for ribbons, of the shell that carries
them; vertices lie 2 to 7 mm apart, so distances are too large by up to half of that.
"""

from collections.abc import Mapping
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lrsr.identities.face.template import template
from lrsr.identities.gate.intersection import coarse_faces
from lrsr.identities.hair.anchors import load_anchors
from lrsr.identities.hair.paths import COLUMNS
from lrsr.identities.hair.shell import ROWS, lay_shell
from lrsr.identities.hair.strands import RIBBONS
from lrsr.identities.shape.basis import load_basis

Points = NDArray[np.float64]

_EVERY_COLUMN = 8
_EVERY_RIBBON = 24
_FACE_TOP_MM = 8.0
"""Hair may hang to the brows, this far above the pupils."""


class HairFit(NamedTuple):
    """How a head of hair sits.

    Attributes:
        off_skin_mm: How far from the skin the columns of the shell stay even where they come
            nearest to it; the column at the 95th percentile.
        ribbons_off_mm: How far from shell and skin ribbons stay likewise; the 99th percentile.
        before_eyes: Share of the vertices of the hair that hang before an eye.
        before_face: Share that hang before nose and mouth.
        edge_mm: Height of the shell's edge over the forehead, median; 0 without such an edge.
    """

    off_skin_mm: float
    ribbons_off_mm: float
    before_eyes: float
    before_face: float
    edge_mm: float


def grow_shell(
    parameters: Mapping[str, Any], skin: NDArray[np.float32], seed: int
) -> NDArray[np.float32]:
    """Grow the shell of a head of hair, without the ribbons and the texture, which take longer.

    Args:
        parameters: See :func:`lrsr.identities.hair.hair.build_hair`.
        skin: ``(V, 3)`` render vertices, mm.
        seed: As there.

    Returns:
        The first vertices of the part "hair" that it would build, mm.
    """
    rng = np.random.default_rng([seed, 3])
    shell = lay_shell(parameters, load_anchors(), skin, rng)
    return shell.points[:, :ROWS].reshape(-1, 3).astype(np.float32)


def measure_hair(
    hair: NDArray[np.floating], skin: NDArray[np.floating], pupils: Points, *, stands: bool = True
) -> HairFit:
    """Measure how hair sits on a head.

    Args:
        hair: ``(N, 3)`` vertices of the part "hair", mm, or of its shell alone.
        skin: ``(V, 3)`` render vertices of the skin, mm.
        pupils: ``(2, 3)``, mm.
        stands: Whether there is any: that of shaved heads is hidden below the skin.
    """
    corners = skin[load_basis().surface.landmarks[1:]]
    skin = skin[_scalp_vertices()]
    columns = hair[: COLUMNS * ROWS].reshape(COLUMNS, ROWS, 3)
    sampled = columns[::_EVERY_COLUMN, ::2]
    off = _distances(skin, sampled)
    eyes, face = _before(hair, pupils, corners)
    forehead = sampled[:, -1] if stands else sampled[:0, -1]
    return HairFit(
        off_skin_mm=float(np.percentile(off.min(axis=1), 95)),
        ribbons_off_mm=_ribbons_off(hair, columns, skin),
        before_eyes=eyes,
        before_face=face,
        edge_mm=_edge_height(forehead, off[: len(forehead), -1]),
    )


def _distances(vertices: NDArray[np.floating], lines: NDArray[np.floating]) -> Points:
    """Return how far the points of lines ``(n, k, 3)`` are from the nearest vertex: ``(n, k)``."""
    tree = cKDTree(vertices, balanced_tree=False, compact_nodes=False)  # few queries: build fast
    return np.asarray(tree.query(lines.reshape(-1, 3))[0].reshape(lines.shape[:2]))


def _ribbons_off(
    hair: NDArray[np.floating], columns: NDArray[np.floating], skin: NDArray[np.floating]
) -> float:
    """How far ribbons stay off shell and skin, the 99th percentile of some; 0 without ribbons."""
    ribbons = hair[COLUMNS * ROWS :]
    if not len(ribbons):
        return 0.0
    some = ribbons.reshape(RIBBONS, -1, 3)[::_EVERY_RIBBON, ::4]
    bed = np.concatenate([skin, columns[::3, ::3].reshape(-1, 3)])
    return float(np.percentile(_distances(bed, some).min(axis=1), 99))


def _before(
    hair: NDArray[np.floating], pupils: Points, corners: NDArray[np.floating]
) -> tuple[float, float]:
    """Share of the hair's vertices before the eyes, and before nose and mouth."""
    x, y, z = hair[:, 0], hair[:, 1], hair[:, 2]
    front = (z > 0.0) & (y < _FACE_TOP_MM)
    eyes = np.zeros(len(hair), bool)
    for pupil in pupils:
        eyes |= front & (np.abs(x - pupil[0]) < 13.0) & (y > -8.0)
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
    vertices = np.unique(coarse_faces())
    skin = template().skin[vertices]
    face = (np.abs(skin[:, 0]) < 50.0) & (skin[:, 1] < 10.0) & (skin[:, 2] > -40.0)
    return np.asarray(vertices[~face])
