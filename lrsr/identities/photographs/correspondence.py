"""Which vertices of our skin are the points of a landmark network, and how wrong is it there?

It is measured on rendered people whose vertices are known, by ``lrsr calibrate-reconstructor``,
and lies beside the network, ``face.npz`` beside ``face.onnx``: it belongs to one network, the one
whose checksum it carries.
"""

import json
import zipfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lrsr.errors import InputError
from lrsr.files import check_file

Points = NDArray[np.float64]

_UNIT_MM = 0.01
"""Bias and components are stored as whole numbers of these."""


@dataclass(frozen=True, eq=False)
class Correspondence:
    """The network's points on our mesh, and their noise about it, mm in the plane of the picture.

    The noise turns with the head: its axes are those of a head that is not tipped, x to the
    picture's right and y up.

    Attributes:
        points: ``(N,)`` which of the network's points these are.
        vertices: ``(N,)`` render vertices.
        bias_mm: ``(N, 2)`` mean of what is found less what is true.
        components_mm: ``(c, N, 2)`` of one standard deviation each: how points err together.
        rest_mm: Standard deviation of what is left, of each coordinate of each point.
        network: SHA-256 of the network's file.
    """

    points: NDArray[np.int64]
    vertices: NDArray[np.int64]
    bias_mm: Points
    components_mm: Points
    rest_mm: float
    network: str

    def arrays(self, made_by: str) -> dict[str, NDArray[np.generic]]:
        """Return what the file holds.

        Args:
            made_by: Command and inputs, for its provenance.
        """
        told = {"network": self.network, "licence": "CC0-1.0", "made_by": made_by}
        return {
            "provenance": np.array(json.dumps(told)),
            "points": self.points.astype(np.uint32),
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


def correspondence_path(model: Path) -> Path:
    """Return where the correspondence of ``model`` lies: the same name, ending in ``.npz``."""
    return model.with_suffix(".npz")


def read_correspondence(model: Path, network: str) -> Correspondence:
    """Read what lies beside a network.

    Args:
        model: Its ONNX file.
        network: SHA-256 of that.

    Raises:
        InputError: There is no such file, it holds something else, or it is another network's.
    """
    path, remedy = correspondence_path(model), f"lrsr calibrate-reconstructor model={model}"
    try:
        with check_file(path).open("rb") as file, np.load(file, allow_pickle=False) as archive:
            raw = dict(archive)
        found = Correspondence(
            points=raw["points"].astype(np.int64),
            vertices=raw["vertices"].astype(np.int64),
            bias_mm=raw["bias"] * _UNIT_MM,
            components_mm=raw["components"] * _UNIT_MM,
            rest_mm=float(raw["rest_mm"]),
            network=json.loads(str(raw["provenance"]))["network"],
        )
    except FileNotFoundError as error:
        raise InputError(f"{path} is missing: {remedy} writes it") from error
    except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile) as error:
        raise InputError(f"{path} is no calibration: {remedy} writes another") from error
    if found.network != network:
        raise InputError(f"{path} is that of another network than {model}: {remedy}")
    return found
