"""How is ``lrsr/assets/hair_anchors.npz`` made? ``python -m lrsr.identities.hair.build_anchors``.

From the average adult of :mod:`lrsr.identities.face.template` alone: the ears are the vertices
that the ear targets of the shape space move; :mod:`lrsr.identities.hair.anchors` casts the rays.
Run it again whenever ``head_basis.npz`` changes; a test compares the two.
"""

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lrsr.identities.face.template import template
from lrsr.identities.hair.anchors import ASSET_NAME, Anchors, anchor_arrays, build_anchors
from lrsr.identities.shape.basis import Basis, load_basis
from lrsr.identities.shape.build_basis import write
from lrsr.paths import PACKAGE

_EAR_MOTION_MM = 7.5
"""A vertex belongs to an ear when the ear targets, at full strength, move it by more than this."""

_EAR_SLIDERS = (
    "ear-scale-decr-incr",
    "ear-scale-depth-decr-incr",
    "ear-scale-vert-decr-incr",
    "ear-wing-decr-incr",
)
_HEAD_AND_SHOULDERS = 2


def _find_ears(basis: Basis) -> NDArray[np.int32]:
    """Return the render vertices of the ears."""
    motion = np.zeros(basis.n_skin)
    for slider in _EAR_SLIDERS:
        weights = np.zeros(len(basis.names))
        weights[basis.column[f"ears/{slider}/+"]] = 1.0
        offset = (basis.fields @ weights).reshape(-1, 3)[: basis.n_skin]
        motion = np.maximum(motion, np.linalg.norm(offset, axis=1))
    return np.flatnonzero(basis.surface.matrix @ motion > _EAR_MOTION_MM).astype(np.int32)


def _make_anchors() -> Anchors:
    """Build the chart of the average adult."""
    basis = load_basis()
    surface = basis.surface
    faces = surface.faces[surface.region < _HEAD_AND_SHOULDERS]
    return build_anchors(template().skin, faces, _find_ears(basis))


def main() -> int:
    """Write the asset."""
    write(anchor_arrays(_make_anchors()), Path(PACKAGE) / "assets" / ASSET_NAME)
    return 0


if __name__ == "__main__":
    sys.exit(main())
