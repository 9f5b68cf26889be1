"""Which of the landmark network's points go around the face, the eyes and the mouth?

They are MediaPipe's; a network of other points needs its own lists.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

FACE = (
    *(10, 338, 297, 332, 284, 251, 389, 356, 454, 323, 361, 288, 397, 365, 379, 378, 400, 377),
    *(152, 148, 176, 149, 150, 136, 172, 58, 132, 93, 234, 127, 162, 21, 54, 103, 67, 109),
)
LIP_GAP = (13, 14)
"""Middle of the upper and of the lower lip, on the inside."""
EYES = ((33, 133), (362, 263))
"""Corners of the eyes, left in the image first."""

_FRACTION = 4
"""Bits behind the point of what OpenCV fills."""


def filled(
    points_px: NDArray[np.float64], outline: tuple[int, ...], shape: tuple[int, int]
) -> NDArray[np.bool_]:
    """Return what an outline encloses on a picture: ``(H, W)``."""
    drawn = np.zeros(shape, np.uint8)
    corners = np.rint(points_px[list(outline)] * 2**_FRACTION).astype(np.int32)
    cv2.fillPoly(drawn, [corners], (1,), shift=_FRACTION)
    return np.asarray(drawn > 0)
