"""Where are the points of a face on a photograph? A network of 468 of them, from five.

``face.onnx`` needs ``face.toml``::

    sha256 = "…"                # of face.onnx
    licence = "Apache-2.0"
    source = "mediapipe 0.10.21"

    [input]
    channels = "RGB"            # the network sees (N, 3, size, size) in [0, 1]
    size_px = 192

    [output]
    points = "points"           # the output with x, y, z of each point, px of the crop
    score = "score"             # and the one with the logit of "this is a face"
    mirror = [0, …]             # which point each one becomes in a mirror; as many as there are

    [crop]
    level = [33, 263]           # the points whose line the crop is turned by
    side = 1.5                  # of the crop, times the longer side of the points' box

The crop follows from the points (as MediaPipe's ``landmarks_to_roi``), so it is found in rounds.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lrsr.configuration import require
from lrsr.identities.photographs.crop import Crop
from lrsr.onnx import open_session, read_declared, run_lists
from lrsr.paths import asset

Points = NDArray[np.float64]

_SHIPPED = "landmarkers/face_landmark.onnx"
"""MediaPipe's; licence and origin lie beside it."""
_ROUNDS = 3
_FIRST_SIDE = 3.9
"""Side of the first crop, times the longer of: eyes to mouth, 0.9 times eye to eye."""
_EYES_TO_MOUTH = 0.9

_TABLES = {
    "": ("sha256", "licence", "source"),
    "input": ("channels", "size_px"),
    "output": ("points", "score", "mirror"),
    "crop": ("level", "side"),
}


@dataclass(frozen=True)
class _LandmarkerContract:
    """A landmark network's declared contract; see the module for each field."""

    sha256: str
    licence: str
    source: str
    channels: str
    size_px: int
    points: str
    score: str
    mirror: tuple[int, ...]
    level: tuple[int, ...]
    side: float


@dataclass(frozen=True, eq=False)
class Landmarks:
    """What is found on one picture.

    Attributes:
        points_px: ``(N, 2)`` (x, y).
        score: How sure the network is that this is a face, [0, 1].
    """

    points_px: Points
    score: float


class Landmarker:
    """A landmark network.

    Args:
        model: An ONNX file with its contract beside it; default: the one that ships.

    Raises:
        InputError: The contract is missing, broken or about another file, or the file is no network
            that can be run.
    """

    def __init__(self, model: Path | None = None) -> None:
        self.model = model or asset(_SHIPPED)
        self.contract = _read_landmarker_contract(self.model)
        self._session = open_session(self.model)
        self._mirror = np.array(self.contract.mirror)

    def __call__(self, image: NDArray[np.float32], five_px: ArrayLike) -> Landmarks:
        """Find the points; what is found in the mirrored crop counts as much.

        Args:
            image: ``(H, W, 3)`` float32, srgb, [0, 1].
            five_px: ``(5, 2)`` eyes, nose and corners of the mouth, as a detector finds them.

        Raises:
            InputError: The network cannot take such a crop.
        """
        crop = self._first_crop(np.asarray(five_px, dtype=np.float64))
        for _ in range(_ROUNDS):
            points, score = self._look(crop.take(image))
            found = crop.back(points)
            crop = self._next_crop(found)
        return Landmarks(found, score)

    def _look(self, crop: NDArray[np.float32]) -> tuple[Points, float]:
        """Return the points of a crop ``(N, 2)`` and their score."""
        both = np.stack([crop, crop[:, ::-1]]).transpose(0, 3, 1, 2)
        names = [self.contract.points, self.contract.score]
        batch = np.ascontiguousarray(both)
        lists, scores = run_lists(self._session, self.model, batch, names, batch_size=2)
        seen, mirrored = lists.reshape(2, -1, 3)[..., :2].astype(np.float64)
        mirrored = mirrored[self._mirror]
        mirrored[:, 0] = self.contract.size_px - 1 - mirrored[:, 0]
        logit = float(scores[0].ravel()[0])
        return (seen + mirrored) / 2, 1 / (1 + float(np.exp(-logit)))

    def _first_crop(self, five: Points) -> Crop:
        eyes, mouth = five[:2].mean(axis=0), five[3:].mean(axis=0)
        across = five[1] - five[0]
        reach = max(np.linalg.norm(mouth - eyes), _EYES_TO_MOUTH * np.linalg.norm(across))
        x, y = (eyes + mouth) / 2
        turned = float(np.arctan2(across[1], across[0]))
        return Crop((float(x), float(y)), _FIRST_SIDE * float(reach), turned, self.contract.size_px)

    def _next_crop(self, points: Points) -> Crop:
        first, second = self.contract.level
        across = points[second] - points[first]
        angle = float(np.arctan2(across[1], across[0]))
        axes = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        turned = points @ axes
        low, high = turned.min(axis=0), turned.max(axis=0)
        x, y = axes @ ((low + high) / 2)
        side = self.contract.side * float((high - low).max())
        return Crop((float(x), float(y)), side, angle, self.contract.size_px)


def _read_landmarker_contract(model: Path) -> _LandmarkerContract:
    """Read the contract beside ``model`` and check the model's bytes against its sha256.

    Raises:
        InputError: Model or contract is missing or unreadable; a field is missing, unknown or out
            of range; or the model is not the one that the contract was written for.
    """
    contract = read_declared(_LandmarkerContract, model, _TABLES, {"input.channels": ("RGB",)})
    count = len(contract.mirror)
    mirror = np.array(contract.mirror)
    involution = sorted(contract.mirror) == list(range(count)) and (mirror[mirror] == range(count))
    require(bool(np.all(involution)), "output.mirror", f"{count} numbers", "an involution")
    level = len(contract.level) == 2 and all(0 <= point < count for point in contract.level)
    require(level, "crop.level", [*contract.level], f"two points, 0 to {count - 1}")
    require(contract.side > 0, "crop.side", contract.side, "above 0")
    require(contract.size_px >= 16, "input.size_px", contract.size_px, "at least 16")
    return contract
