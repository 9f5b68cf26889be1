"""Where is the face that each picture is of? One answer for all who recognise, found once."""

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray

from lrsr.errors import InputError
from lrsr.images import check_srgb
from lrsr.recognition.detection.detector import Detector
from lrsr.recognition.detection.faces import best_face
from lrsr.recognition.memory import Memory


@dataclass(frozen=True, eq=False)
class Faces:
    """The best face of each picture; NaN where none was found.

    Attributes:
        landmarks_px: ``(B, 5, 2)`` (x, y), px.
        boxes_px: ``(B, 4)`` left, top, right, bottom, px.
        scores: ``(B,)`` of the detector, [0, 1].
        counts: ``(B,)`` how many faces there were, the best one among them.
    """

    landmarks_px: NDArray[np.float32]
    boxes_px: NDArray[np.float32]
    scores: NDArray[np.float32]
    counts: NDArray[np.float32]


class Finder:
    """Finds the best face of each picture.

    Args:
        detector: Default: the one that ships.
        memory: Where detections are kept; default: nowhere.
    """

    def __init__(self, detector: Detector | None = None, memory: Memory | None = None) -> None:
        self.detector, self._memory = detector or Detector(), memory or Memory()

    def __call__(self, srgb: torch.Tensor) -> Faces:
        """Find the face that each picture is of, if any.

        It is chosen by :func:`lrsr.recognition.detection.faces.best_face`.

        Args:
            srgb: ``(B, 3, H, W)`` float32, srgb, [0, 1].

        Raises:
            ImageContractError: The pictures break the contract of :mod:`lrsr.images`.
            InputError: The detector finds boxes alone.
        """
        pixels = check_srgb(srgb).numpy(force=True)
        about = {"find and count": self.detector.describe()}
        rows = self._memory.recall(about, [pixels], lambda: self._find(srgb))
        return Faces(rows[:, :10].reshape(-1, 5, 2), rows[:, 10:14], rows[:, 14], rows[:, 15])

    def _find(self, srgb: torch.Tensor) -> NDArray[np.float32]:
        """Return landmarks, box and score of each best face, and of how many, ``(B, 16)``.

        Raises:
            InputError: The detector finds boxes alone.
        """
        rows = np.full((len(srgb), 16), np.nan, dtype=np.float32)
        for row, faces in zip(rows, self.detector(srgb), strict=True):
            row[15] = len(faces)
            best = best_face(faces, *srgb.shape[-2:])
            if best is None:
                continue
            row[:15] = [*best.landmarks_px.ravel(), *best.box_px, best.score]
            if np.isnan(row).any():
                raise InputError(
                    f"{self.detector.model}: finds boxes without landmarks, by which nothing can be"
                    " aligned; give another recognition.detector"
                )
        return rows
