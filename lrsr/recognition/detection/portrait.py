"""Which faces of a large picture count? Those that are not much smaller than the largest."""

from typing import Any

import cv2
import numpy as np
import torch
from numpy.typing import NDArray

from lrsr.recognition.detection.detector import Detector
from lrsr.recognition.detection.faces import Detection

_ANOTHER_FACE = 0.15
"""A second face of more than this share of the first one's area makes it two."""


def portrait_faces(
    pixels: NDArray[Any], detector: Detector, largest_px: int = 1280
) -> list[Detection]:
    """Return the faces of a picture that count, the largest first, in its own px.

    Args:
        pixels: ``(H, W, 3)`` of 8 or 16 bits, RGB.
        detector: Finds them.
        largest_px: Larger pictures are reduced to this for the detector: a face that counts is not
            small on them.
    """
    height, width = pixels.shape[:2]
    factor = min(1.0, largest_px / max(height, width))
    size = (max(1, round(width * factor)), max(1, round(height * factor)))
    small = cv2.resize(pixels, size, interpolation=cv2.INTER_AREA) if factor < 1 else pixels
    srgb = small.astype(np.float32) / np.float32(np.iinfo(pixels.dtype).max)
    batch = torch.from_numpy(np.ascontiguousarray(srgb.transpose(2, 0, 1)))[None]

    def area(face: Detection) -> float:
        left, top, right, bottom = face.box_px
        return float((right - left) * (bottom - top))

    faces = sorted(detector(batch)[0], key=area, reverse=True)
    back = np.array([width / size[0], height / size[1]], np.float32)
    return [
        Detection(
            ((face.box_px.reshape(2, 2) + 0.5) * back - 0.5).ravel(),
            face.score,
            (face.landmarks_px + 0.5) * back - 0.5,
        )
        for face in faces
        if area(face) > _ANOTHER_FACE * area(faces[0])
    ]
