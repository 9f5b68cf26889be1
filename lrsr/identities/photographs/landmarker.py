"""Where are the points of a face on a photograph? A network finds them, from five.

It returns a list of landmarks, or a map each texel of which is one, such as PRNet's position map.
``face.onnx`` needs ``face.toml``::

    sha256 = "…"                # of face.onnx
    licence = "Apache-2.0"
    source = "mediapipe 0.10.21"

    [input]
    channels = "RGB"            # or "BGR"
    size_px = 192               # of the square crop
    layout = "NCHW"             # or "NHWC"; may be left out, as the next two
    mean = 0                    # the network sees (255 srgb - mean) / scale, each a number or
    scale = 255                 # three, in the order of `channels`

    [output]
    points = "points"           # the output with x, y, z of each point; z is not read
    shape = [256, 256, 3]       # of it for one picture: a map, or [3, 256, 256]; not for a list
    unit_px = 1.0               # px of the crop that 1 of it means; may be left out
    score = "score"             # the output with the logit of "this is a face", if there is one
    mirror = [0, …]             # which point each one becomes in a mirror, if that is known, or of
    symmetric = true            # a map: its columns from right to left

    [crop]
    side = 1.5                  # of the crop, times the longer side of the face's box
    shift = 0.0                 # how much lower its middle is than the box's, in the same unit
    box = "points"              # of the network's own points, in rounds (as MediaPipe's
                                # landmarks_to_roi), or "five": about the five points, once
    level = [33, 263]           # the points whose line the crop is turned by; not given: the eyes

:class:`~.crop.CropRule` says what the box about the five points is.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lrsr.configuration import require
from lrsr.errors import InputError
from lrsr.identities.photographs.crop import Crop, CropRule, axes
from lrsr.onnx import PerChannel, open_session, read_declared, run_lists
from lrsr.paths import asset

Points = NDArray[np.float64]

SHIPPED = "landmarkers/face_landmark.onnx"
"""MediaPipe's; licence and origin lie beside it."""
_ROUNDS = 3
_TABLES = {
    "": ("sha256", "licence", "source"),
    "input": ("channels", "size_px", "layout", "mean", "scale"),
    "output": ("points", "shape", "unit_px", "score", "mirror", "symmetric"),
    "crop": ("side", "shift", "box", "level"),
}
_CHOICES = {
    "input.channels": ("RGB", "BGR"),
    "input.layout": ("NCHW", "NHWC"),
    "crop.box": ("points", "five"),
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
    side: float
    layout: str = "NCHW"
    mean: PerChannel = 0.0
    scale: PerChannel = 255.0
    shape: tuple[int, ...] = ()
    unit_px: float = 1.0
    score: str = ""
    mirror: tuple[int, ...] = ()
    symmetric: bool = False
    shift: float = 0.0
    box: str = "points"
    level: tuple[int, ...] = ()

    def mirrored(self) -> NDArray[np.int64]:
        """Return which point each one becomes in a mirror; empty: nobody knows."""
        if not self.symmetric:
            return np.array(self.mirror, dtype=np.int64)
        map_shape = self.shape[:2] if self.shape[-1] == 3 else self.shape[1:]
        return np.arange(np.prod(map_shape)).reshape(map_shape)[:, ::-1].ravel()

    def read(self, raw: NDArray[np.float32]) -> Points:
        """Return the points ``(B, N, 2)``, px of the crop, of what the network returned ``(B, …)``.

        Raises:
            ValueError: It is of another size.
        """
        each = raw.reshape(len(raw), *(self.shape or (-1, 3)))
        last = each if each.shape[-1] == 3 else np.moveaxis(each, 1, -1)
        return self.unit_px * last.reshape(len(raw), -1, 3)[..., :2].astype(np.float64)

    def prepare(self, crops: NDArray[np.float32]) -> NDArray[np.float32]:
        """Turn srgb ``(B, size, size, 3)``, [0, 1], into what the network takes."""
        seen = crops[..., ::-1] if self.channels == "BGR" else crops
        mean, scale = np.asarray(self.mean), np.asarray(self.scale)
        values = seen * (255 / scale).astype(np.float32) - (mean / scale).astype(np.float32)
        moved = values.transpose(0, 3, 1, 2) if self.layout == "NCHW" else values
        return np.ascontiguousarray(moved, dtype=np.float32)


@dataclass(frozen=True, eq=False)
class Landmarks:
    """What is found on one picture.

    Attributes:
        points_px: ``(N, 2)`` (x, y).
        score: How sure the network is that this is a face, [0, 1]; None: it does not say.
    """

    points_px: Points
    score: float | None


class Landmarker:
    """A landmark network.

    Args:
        model: An ONNX file with its contract beside it; default: the one that ships.

    Raises:
        InputError: The contract is missing, broken or about another file, or the file is no network
            that can be run.
    """

    def __init__(self, model: Path | None = None) -> None:
        self.model = model or asset(SHIPPED)
        self.contract = _read_landmarker_contract(self.model)
        self._session = open_session(self.model)
        self._mirror = self.contract.mirrored()
        told = self.contract
        self._rule = CropRule(told.side, told.shift, told.size_px)

    def __call__(self, image: NDArray[np.float32], five_px: ArrayLike) -> Landmarks:
        """Find the points; what is found in the mirrored crop counts as much, where it is known.

        Args:
            image: ``(H, W, 3)`` float32, srgb, [0, 1].
            five_px: ``(5, 2)`` eyes, nose and corners of the mouth, as a detector finds them.

        Raises:
            InputError: The network cannot take such a crop, or returns what its contract does not
                say.
        """
        five = np.asarray(five_px, dtype=np.float64)
        crop = self._rule.of_five(five)
        for _ in range(_ROUNDS if self.contract.box == "points" else 1):
            points, score = self._look(crop.take(image))
            found = crop.back(points)
            crop = self._next_crop(found, crop.angle_rad)
        return Landmarks(found, score)

    def _look(self, crop: NDArray[np.float32]) -> tuple[Points, float | None]:
        """Return the points of a crop ``(N, 2)`` and their score.

        Raises:
            InputError: See :meth:`__call__`.
        """
        contract, known = self.contract, len(self._mirror) > 0
        crops = np.stack([crop, crop[:, ::-1]] if known else [crop])
        names = [name for name in (contract.points, contract.score) if name]
        batch = contract.prepare(crops)
        raw, *scores = run_lists(self._session, self.model, batch, names, batch_size=len(crops))
        try:
            points, *mirrored = contract.read(raw)
            for other in mirrored:
                turned = other[self._mirror]
                turned[:, 0] = contract.size_px - 1 - turned[:, 0]
                points = (points + turned) / 2
        except (ValueError, IndexError) as error:
            raise InputError(
                f"{self.model}: output {contract.points} has {raw[0].size} numbers, which its"
                " contract's shape and mirror do not fit; mend the contract"
            ) from error
        logits = [float(one[0].ravel()[0]) for one in scores]
        return points, 1 / (1 + float(np.exp(-logits[0]))) if logits else None

    def _next_crop(self, points: Points, angle: float) -> Crop:
        if self.contract.level:
            first, second = self.contract.level
            across = points[second] - points[first]
            angle = float(np.arctan2(across[1], across[0]))
        turn = axes(angle)
        turned = points @ turn
        low, high = turned.min(axis=0), turned.max(axis=0)
        longer = float((high - low).max())
        return self._rule.of_box(turn @ ((low + high) / 2), longer, angle)


def _read_landmarker_contract(model: Path) -> _LandmarkerContract:
    """Read the contract beside ``model`` and check the model's bytes against its sha256.

    Raises:
        InputError: Model or contract is missing or unreadable; a field is missing, unknown or out
            of range; or the model is not the one that the contract was written for.
    """
    contract = read_declared(_LandmarkerContract, model, _TABLES, _CHOICES)
    shape, symmetric = contract.shape, contract.symmetric
    is_map = len(shape) == 3 and min(shape) > 0 and 3 in (shape[0], shape[-1])
    wish = "a map, [rows, columns, 3] or [3, rows, columns]"
    require(is_map or not (shape or symmetric), "output.shape", [*shape], wish)
    require(not (symmetric and contract.mirror), "output.mirror", "given", "none with symmetric")
    count = len(contract.mirror)
    mirror = np.array(contract.mirror, dtype=np.int64)
    involution = sorted(contract.mirror) == list(range(count)) and (mirror[mirror] == range(count))
    require(bool(np.all(involution)), "output.mirror", f"{count} numbers", "an involution")
    last = count - 1 if count else np.prod(shape or (2**31,)) // 3 - 1
    level = len(contract.level) in (0, 2) and all(0 <= point <= last for point in contract.level)
    require(level, "crop.level", [*contract.level], f"two points, 0 to {last}")
    for name in ("crop.side", "output.unit_px"):
        value = getattr(contract, name.partition(".")[2])
        require(value > 0, name, value, "above 0")
    require(bool(np.min(contract.scale) > 0), "input.scale", contract.scale, "above 0")
    require(contract.size_px >= 16, "input.size_px", contract.size_px, "at least 16")
    return contract
