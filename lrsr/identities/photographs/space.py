"""Which faces are likely, and what can a face do? The population as a Gaussian, and face units.

``coefficients = mean + components z``, z ~ N(0, 1) for each of them, ordered by how much they move
the front of the face; ``lrsr/assets/face_space.npz`` is made by
:mod:`lrsr.identities.photographs.build_space` from drawn people.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from lrsr.identities.shape.basis import load_basis
from lrsr.paths import asset

Points = NDArray[np.float64]

ASSET_NAME = "face_space.npz"
UNIT = 1e-4
"""Components are stored as whole numbers of these."""
_LEFT_OUT = ("eyeLook", "tongueOut")
"""Units that move no skin, or what the mesh does not have."""


@dataclass(frozen=True, eq=False)
class FaceSpace:
    """Faces around the mean one.

    Attributes:
        mean: ``(K,)`` coefficients of the shape space, lids at rest, no expression.
        components: ``(K, n)``, of one standard deviation each.
        units: Names of the face units that a fit may use, without "unit/".
    """

    mean: Points
    components: Points
    units: tuple[str, ...]

    @property
    def directions(self) -> Points:
        """What moves a face, in coefficients: components, then units, ``(K, n + m)``."""
        column = load_basis().column
        acting = np.zeros((len(self.mean), len(self.units)))
        for k, unit in enumerate(self.units):
            acting[column[f"unit/{unit}"], k] = 1.0
        return np.concatenate([self.components, acting], axis=1)


@lru_cache(maxsize=1)
def load_space() -> FaceSpace:
    """Read the space that ships with the package; later calls are free.

    Raises:
        InputError: The file is missing.
    """
    with np.load(asset(ASSET_NAME), allow_pickle=False) as archive:
        mean, components = archive["mean"], archive["components"] * UNIT
    names = [name.removeprefix("unit/") for name in load_basis().names if name.startswith("unit/")]
    units = tuple(name for name in names if not name.startswith(_LEFT_OUT))
    return FaceSpace(mean.astype(np.float64), components, units)
