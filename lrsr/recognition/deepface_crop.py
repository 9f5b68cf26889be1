"""How does DeepFace cut a face out? By its eyes turned level, in whole pixels, and by its box.

Faithful to ``extract_faces`` of deepface 0.0.103 (``modules/detection.py``) with its border of half
a picture on each side, after a detector has said where box and eyes are, and to ``resize_image``
(``modules/preprocessing.py``), which brings the cut to the embedder's size. Everything is rounded
where DeepFace rounds: box and eyes are cut to whole pixels of the picture, which at 10 px between
the eyes alone leaves 2.3° of roll, and after a fourfold enlargement 0.6°.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

Levels = NDArray[np.uint8]


def cut_face(
    levels: Levels, box_px: NDArray[np.float64], eyes_px: NDArray[np.float64]
) -> Levels | None:
    """Cut a face out as DeepFace does.

    Args:
        levels: ``(H, W, 3)``.
        box_px: ``(4,)`` left, top, right, bottom.
        eyes_px: ``(2, 2)`` (x, y), that on the left of the picture first.

    Returns:
        ``(h, w, 3)``, about as large as the box; None where nothing of it lies on the picture.
    """
    height, width = levels.shape[:2]
    down, across = height // 2, width // 2
    picture = np.pad(levels, ((down, down), (across, across), (0, 0)))
    border = np.array([across, down])
    corners = (box_px.reshape(2, 2) + border).astype(int)  # towards zero, as int() does
    eyes = (eyes_px + border).astype(int)
    left, top, right, bottom = (
        corners.clip(0, [picture.shape[1], picture.shape[0]]).ravel().tolist()
    )
    wide, high = right - left, bottom - top
    if wide <= 0 or high <= 0:
        return None
    around = _surroundings(picture, left, top, wide, high)
    angle_deg = float(np.degrees(np.arctan2(*(eyes[1] - eyes[0])[::-1])))
    size = (around.shape[1], around.shape[0])
    turn = cv2.getRotationMatrix2D((size[0] // 2, size[1] // 2), angle_deg, 1.0)
    level = cv2.warpAffine(around, turn, size, flags=cv2.INTER_CUBIC)
    x1, y1, x2, y2 = _turned_box(wide, high, angle_deg, size)
    return level[y1:y2, x1:x2] if x2 > x1 and y2 > y1 else None


def fit_to_square(levels: Levels, side_px: int) -> Levels:
    """Bring a picture to a square: bilinearly, its proportions kept, black beside it."""
    factor = min(side_px / levels.shape[0], side_px / levels.shape[1])
    size = (max(1, int(levels.shape[1] * factor)), max(1, int(levels.shape[0] * factor)))
    fitted = cv2.resize(levels, size)
    spare = [side_px - have for have in fitted.shape[:2]]
    return np.pad(fitted, [*((rest // 2, rest - rest // 2) for rest in spare), (0, 0)])


def _surroundings(picture: Levels, left: int, top: int, wide: int, high: int) -> Levels:
    """Return the box and half as much on each side, black beyond the picture's edge."""
    across, down = int(0.5 * wide), int(0.5 * high)
    x, y = left - across, top - down
    if (
        x >= 0
        and y >= 0
        and x + wide + 2 * across <= picture.shape[1]
        and (y + high + 2 * down <= picture.shape[0])
    ):
        return picture[y : y + high + 2 * down, x : x + wide + 2 * across]
    part = picture[max(0, y) : top + high + down, max(0, x) : left + wide + across]
    result = np.zeros((high + 2 * down, wide + 2 * across, 3), dtype=np.uint8)
    start = max(0, -y), max(0, -x)
    result[start[0] : start[0] + part.shape[0], start[1] : start[1] + part.shape[1]] = part
    return result


def _turned_box(
    wide: int, high: int, angle_deg: float, size: tuple[int, int]
) -> tuple[int, int, int, int]:
    """Return where the box lies after its surroundings were turned about their middle."""
    left, top = int(0.5 * wide), int(0.5 * high)
    if abs(angle_deg) % 360 == 0:
        return left, top, left + wide, top + high
    angle = np.radians(angle_deg)
    x, y = left + wide / 2 - size[0] / 2, top + high / 2 - size[1] / 2
    middle_x = x * np.cos(angle) + y * np.sin(angle) + size[0] / 2
    middle_y = y * np.cos(angle) - x * np.sin(angle) + size[1] / 2
    return (
        max(int(middle_x - wide / 2), 0),
        max(int(middle_y - high / 2), 0),
        min(int(middle_x + wide / 2), size[0]),
        min(int(middle_y + high / 2), size[1]),
    )
