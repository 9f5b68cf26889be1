"""Where do the eyes of a photograph look? A network finds the irises, their rays the gazes.

``iris.onnx`` needs ``iris.toml``, as a landmark network's (:mod:`~.landmarker`)::

    [output]
    points = "points"           # x, y, z of points, px of the crop; the first is the pupil

    [crop]
    corners = [[33, 133], …]    # points of the face: outer and inner corner of the left eye in the
                                # picture, then of the right one, which is shown in a mirror
    side = 2.3                  # of the crop, times the distance of the corners
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lrsr.configuration import require
from lrsr.identities.face.eyes import Eyes
from lrsr.identities.photographs.crop import Crop
from lrsr.identities.photographs.perspective import Perspective
from lrsr.onnx import open_session, read_declared, run_session
from lrsr.paths import asset

Points = NDArray[np.float64]

_SHIPPED = "landmarkers/iris_landmark.onnx"
_TABLES = {
    "": ("sha256", "licence", "source"),
    "input": ("channels", "size_px"),
    "output": ("points",),
    "crop": ("corners", "side"),
}
_FARTHEST_DEG = 20.0
"""From where eyes look by their lids: beyond it the network or the fit errs."""


@dataclass(frozen=True)
class _Contract:
    sha256: str
    licence: str
    source: str
    channels: str
    size_px: int
    points: str
    corners: tuple[tuple[int, ...], ...]
    side: float


class IrisFinder:
    """A network that finds irises.

    Args:
        model: An ONNX file with its contract beside it; default: the one that ships.

    Raises:
        InputError: The contract is missing, broken or about another file.
    """

    def __init__(self, model: Path | None = None) -> None:
        self.model = model or asset(_SHIPPED)
        contract = read_declared(_Contract, self.model, _TABLES, {"input.channels": ("RGB",)})
        pairs = len(contract.corners) == 2 and all(len(pair) == 2 for pair in contract.corners)
        require(pairs, "crop.corners", [*contract.corners], "two pairs of points")
        self.contract = contract
        self._session = open_session(self.model)

    def __call__(self, image: NDArray[np.float32], points_px: Points) -> Points:
        """Find the pupils.

        Args:
            image: ``(H, W, 3)`` float32, srgb, [0, 1].
            points_px: ``(N, 2)`` of the face's landmark network.

        Returns:
            ``(2, 2)`` (x, y), px, left in the picture first.
        """
        (left_outer, left_inner), (right_outer, right_inner) = self.contract.corners
        across = ((left_outer, left_inner), (right_inner, right_outer))
        crops = [self._crop(*(points_px[k] for k in ends)) for ends in across]
        seen = [crop.take(image) for crop in crops]
        batch = np.stack([seen[0], seen[1][:, ::-1]]).transpose(0, 3, 1, 2)
        found = run_session(
            self._session, self.model, np.ascontiguousarray(batch), batch_size=2,
            output=self.contract.points,
        )  # fmt: skip
        pupils = found.reshape(2, -1, 3)[:, 0, :2].astype(np.float64)
        pupils[1, 0] = self.contract.size_px - 1 - pupils[1, 0]
        places = [crop.back(pupil[None])[0] for crop, pupil in zip(crops, pupils, strict=True)]
        return np.array(places)

    def _crop(self, start: Points, end: Points) -> Crop:
        x, y = (start + end) / 2
        along = end - start
        side = self.contract.side * float(np.linalg.norm(along))
        angle = float(np.arctan2(along[1], along[0]))
        return Crop((float(x), float(y)), side, angle, self.contract.size_px)


def gazes_through(eyes: Eyes, perspective: Perspective, pupils_px: Points) -> Points:
    """Return gazes ``(2, 3)`` that put the pupils where they are seen.

    Args:
        eyes: In the axes of the perspective.
        perspective: Of the photograph.
        pupils_px: ``(2, 2)`` on it. One too far from where the lids let an eye look is not
            believed: that eye looks as it did.
    """
    gazes = eyes.gazes.copy()
    for which, (centre, radius) in enumerate(zip(eyes.centres, eyes.radii, strict=True)):
        start, direction = perspective.ray(pupils_px[which])
        offset = start - centre
        along = float(offset @ direction)
        inside = along**2 - float(offset @ offset) + radius**2
        if inside <= 0:
            continue
        gaze = (offset - (along + np.sqrt(inside)) * direction) / radius
        if gaze @ eyes.gazes[which] > np.cos(np.radians(_FARTHEST_DEG)):
            gazes[which] = gaze
    return gazes
