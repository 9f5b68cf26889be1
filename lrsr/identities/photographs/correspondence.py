"""Which vertex of our skin is a point of the landmark network, and how wrong is it there?

``lrsr/assets/landmark_correspondence.npz`` is measured on rendered people whose vertices are known,
by ``python -m lrsr.calibration.landmark_correspondence``: it belongs to one network, the one whose
checksum it carries.
"""

import json
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from lrsr.paths import asset

Points = NDArray[np.float64]

ASSET_NAME = "landmark_correspondence.npz"
_UNIT_MM = 0.01
"""Bias and components are stored as whole numbers of these."""


@dataclass(frozen=True, eq=False)
class Correspondence:
    """The network's points on our mesh, and their noise about it, mm in the plane of the picture.

    The noise turns with the head: its axes are those of a head that is not tipped, x to the
    picture's right and y up.

    Attributes:
        vertices: ``(N,)`` render vertices.
        bias_mm: ``(N, 2)`` mean of what is found less what is true.
        components_mm: ``(c, N, 2)`` of one standard deviation each: how points err together.
        rest_mm: Standard deviation of what is left, of each coordinate of each point.
        network: SHA-256 of the network's file.
    """

    vertices: NDArray[np.int64]
    bias_mm: Points
    components_mm: Points
    rest_mm: float
    network: str

    def arrays(self, made_by: str) -> dict[str, NDArray[np.generic]]:
        """Return what the asset holds.

        Args:
            made_by: Command and inputs, for its provenance.
        """
        told = {"network": self.network, "licence": "CC0-1.0", "made_by": made_by}
        return {
            "provenance": np.array(json.dumps(told)),
            "vertices": self.vertices.astype(np.uint16),
            "bias": np.rint(self.bias_mm / _UNIT_MM).astype(np.int16),
            "components": np.rint(self.components_mm / _UNIT_MM).astype(np.int16),
            "rest_mm": np.array(self.rest_mm),
        }


def tip_of(rotation: Points) -> Points:
    """Return how a head is tipped in the plane of the picture: ``(2, 2)``, x right and y up.

    Args:
        rotation: ``(3, 3)`` of the head.

    Example:
        >>> lying = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
        >>> (tip_of(lying) @ [0.0, 1.0]).round(6).tolist()
        [1.0, 0.0]
    """
    angle = np.arctan2(-rotation[1, 0], rotation[1, 1])
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([[cosine, sine], [-sine, cosine]])


@lru_cache(maxsize=1)
def load_correspondence() -> Correspondence:
    """Read what ships with the package; later calls are free.

    Raises:
        InputError: The file is missing.
    """
    with np.load(asset(ASSET_NAME), allow_pickle=False) as archive:
        raw = dict(archive)
    return Correspondence(
        vertices=raw["vertices"].astype(np.int64),
        bias_mm=raw["bias"] * _UNIT_MM,
        components_mm=raw["components"] * _UNIT_MM,
        rest_mm=float(raw["rest_mm"]),
        network=json.loads(str(raw["provenance"]))["network"],
    )
