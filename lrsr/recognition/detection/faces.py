"""What is found on a picture, and which of several faces is meant?"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Detection:
    """One face, in the coordinates of :mod:`lrsr.images`; nothing is rounded or cut at the edge.

    Attributes:
        box_px: ``(4,)`` left, top, right, bottom, px.
        score: How sure the detector is, [0, 1].
        landmarks_px: ``(5, 2)`` (x, y) of the eye on the left of the picture, the one on its right,
            nose, left and right corner of the mouth, px; NaN where only boxes are found.
    """

    box_px: Array
    score: float
    landmarks_px: Array


@dataclass(frozen=True, eq=False)
class Candidates:
    """What a network says at every place where a face could be, for a batch of images.

    Attributes:
        scores: ``(B, N)``, [0, 1].
        boxes_px: ``(B, N, 4)`` left, top, right, bottom.
        landmarks_px: ``(B, N, 5, 2)``.
    """

    scores: Array
    boxes_px: Array
    landmarks_px: Array

    def kept(
        self, score_threshold: float, nms_iou: float, *, inclusive: bool
    ) -> list[list[Detection]]:
        """Return the faces of each image, the surest first.

        Args:
            score_threshold: Least score.
            nms_iou: Of two boxes that overlap by more, intersection over union, the surer stays.
            inclusive: A box from pixel 0 to pixel 1 is 2 px wide, as where boxes name pixels.
        """
        found = []
        for scores, boxes, landmarks in zip(
            self.scores, self.boxes_px, self.landmarks_px, strict=True
        ):
            sure = np.flatnonzero(scores >= score_threshold)
            stay = sure[_suppress(boxes[sure], scores[sure], nms_iou, inclusive=inclusive)]
            found.append([Detection(boxes[k], float(scores[k]), landmarks[k]) for k in stay])
        return found


def _suppress(
    boxes_px: Array, scores: Array, nms_iou: float, *, inclusive: bool = False
) -> NDArray[np.intp]:
    """Choose boxes by non-maximum suppression: the surest, then what overlaps none chosen.

    Args:
        boxes_px: ``(N, 4)`` left, top, right, bottom.
        scores: ``(N,)``; of equal ones the first is the surer.
        nms_iou: Overlap, intersection over union, up to which both stay.
        inclusive: See :meth:`Candidates.kept`.

    Returns:
        Their numbers, the surest first.

    Example:
        >>> boxes = np.array([[0, 0, 10, 10], [0, 0, 10, 9], [20, 0, 30, 10]])
        >>> _suppress(boxes, np.array([0.8, 0.9, 0.7]), 0.4).tolist()
        [1, 2]
    """
    more = 1.0 if inclusive else 0.0
    left, top, right, bottom = boxes_px.astype(np.float64).T
    areas = (right - left + more) * (bottom - top + more)
    order = np.argsort(-scores, kind="stable")
    chosen = []
    while order.size:
        first, others = order[0], order[1:]
        chosen.append(first)
        wide = np.minimum(right[first], right[others]) - np.maximum(left[first], left[others])
        high = np.minimum(bottom[first], bottom[others]) - np.maximum(top[first], top[others])
        common = np.maximum(0, wide + more) * np.maximum(0, high + more)
        order = others[common <= nms_iou * (areas[first] + areas[others] - common)]
    return np.array(chosen, dtype=np.intp)


def best_face(faces: Sequence[Detection], height: int, width: int) -> Detection | None:
    """Return the face that a picture is of, by insightface's rule; None where there is none.

    It has the largest area of its box less twice the squared distance of the box's middle from the
    picture's (``FaceAnalysis.get`` with ``max_num=1``); the score decides only whether it is one.

    Args:
        faces: On one picture.
        height: Of the picture, px.
        width: Of the picture, px.
    """

    def prominence(face: Detection) -> float:
        left, top, right, bottom = face.box_px.astype(np.float64)
        away = ((left + right) / 2 - width // 2, (top + bottom) / 2 - height // 2)
        return float((right - left) * (bottom - top) - 2 * np.square(away).sum())

    return max(faces, key=prominence, default=None)
