"""Which network tells what a photograph's face is like? The one that ships, or one of the user's.

A network comes as three files: ``face.onnx``, its contract ``face.toml`` (:mod:`~.landmarker`) and
its calibration on our faces ``face.npz`` (:mod:`~.correspondence`). From the fit on all are alike.
"""

import hashlib
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lrsr.files import read_bytes
from lrsr.identities.photographs.correspondence import correspondence_path, read_correspondence
from lrsr.identities.photographs.fit import FaceFitter, Fit
from lrsr.identities.photographs.landmarker import SHIPPED, Landmarker
from lrsr.identities.shape.basis import load_basis
from lrsr.onnx import contract_path
from lrsr.paths import asset

Points = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Found:
    """What a network makes of a photograph.

    Attributes:
        fit: The face.
        points_px: ``(468, 2)`` where the points of the network that ships are, by which
            :mod:`~.outlines` knows a face: found by it, or those of the fitted face.
        score: How sure the network is that this is a face, [0, 1]; None: it does not say.
    """

    fit: Fit
    points_px: Points
    score: float | None


class Reconstructor:
    """A calibrated network.

    Args:
        model: An ONNX file with its contract and its calibration beside it; default: the one that
            ships.

    Raises:
        InputError: One of the three is missing, broken or about another network.
    """

    def __init__(self, model: Path | None = None) -> None:
        self.landmarker = Landmarker(model)
        model = self.landmarker.model
        self.correspondence = read_correspondence(model, self.landmarker.contract.sha256)
        self.fitter = FaceFitter(self.correspondence)

    @property
    def digest(self) -> str:
        """Return a checksum of all three files."""
        model = self.landmarker.model
        parts = (model, contract_path(model), correspondence_path(model))
        return hashlib.sha256(b"".join(map(read_bytes, parts))).hexdigest()

    def __call__(self, srgb: NDArray[np.float32], five_px: ArrayLike) -> Found:
        """Fit a face to a photograph.

        Args:
            srgb: ``(H, W, 3)`` float32, srgb, [0, 1].
            five_px: ``(5, 2)`` eyes, nose and corners of the mouth, as a detector finds them.

        Raises:
            InputError: The network cannot take its crop of it.
        """
        found = self.landmarker(srgb, five_px)
        fit = self.fitter(found.points_px[self.correspondence.points])
        ships = self.landmarker.model == asset(SHIPPED)
        return Found(fit, found.points_px if ships else _usual_points(fit), found.score)


@lru_cache(maxsize=2)
def shared_reconstructor(model: Path | None = None) -> Reconstructor:
    """Return a network's reconstructor; later calls are free.

    Args:
        model: See :class:`Reconstructor`.

    Raises:
        InputError: See :class:`Reconstructor`.
    """
    return Reconstructor(model)


def _usual_points(fit: Fit) -> Points:
    """Return where a fitted face has the points of the network that ships: ``(468, 2)``, px."""
    rows = load_basis().surface.matrix[shared_reconstructor().correspondence.vertices]
    return fit.perspective.project(rows @ load_basis().shape(fit.acting).skin)[0]
