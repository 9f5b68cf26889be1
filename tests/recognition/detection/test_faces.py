import cv2
import numpy as np
import pytest

from lrsr.recognition.detection.faces import Candidates, Detection, _suppress, best_face


def boxes(count: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    corners = rng.uniform(0, 60, (count, 2))
    return np.hstack([corners, corners + rng.uniform(5, 40, (count, 2))]), rng.random(count)


@pytest.mark.parametrize("iou", [0.0, 0.3, 0.5, 1.0])
def test_suppression_is_that_of_opencv(iou: float) -> None:
    corners, scores = boxes(60)
    sides = np.hstack([corners[:, :2], corners[:, 2:] - corners[:, :2]])
    oracle = cv2.dnn.NMSBoxes(sides.tolist(), scores.tolist(), 0.0, iou)
    assert _suppress(corners, scores, iou).tolist() == np.ravel(oracle).tolist()


def test_what_is_kept_overlaps_nothing_that_is_kept() -> None:
    corners, scores = boxes(60)
    first = _suppress(corners, scores, 0.3)
    assert _suppress(corners[first], scores[first], 0.3).tolist() == list(range(len(first)))


def test_boxes_that_name_pixels_are_a_pixel_wider() -> None:
    two = np.array([[0.0, 0, 9, 9], [5, 0, 14, 9]])  # overlap 5 of 15 columns, or 4 of 14
    scores = np.array([0.9, 0.8])
    assert len(_suppress(two, scores, 0.3)) == 2
    assert len(_suppress(two, scores, 0.3, inclusive=True)) == 1


def test_nothing_to_suppress_is_no_error() -> None:
    assert _suppress(np.empty((0, 4)), np.empty(0), 0.4).shape == (0,)


def test_the_least_score_is_a_face() -> None:
    candidates = Candidates(
        np.array([[0.5, 0.4999]]),
        np.array([[[0, 0, 9, 9], [50, 0, 59, 9]]]),
        np.zeros((1, 2, 5, 2)),
    )
    ((face,),) = candidates.kept(0.5, 0.4, inclusive=False)
    assert face.score == 0.5


def face(left: float, top: float, side: float, score: float = 0.9) -> Detection:
    box = np.array([left, top, left + side, top + side], dtype=np.float32)
    return Detection(box, score, np.zeros((5, 2), dtype=np.float32))


@pytest.mark.parametrize(
    ("faces", "best"),
    [
        ([face(0, 40, 20), face(40, 40, 20)], 1),  # as large, but in the middle
        ([face(20, 20, 60, 0.6), face(45, 45, 10, 0.99)], 0),  # larger, though less sure
        ([face(0, 0, 40), face(40, 40, 20)], 1),  # 40² - 2·(30² + 30²) < 20²
    ],
    ids=["in the middle", "larger", "far away"],
)
def test_the_best_face_is_large_and_in_the_middle(faces: list[Detection], best: int) -> None:
    assert best_face(faces, 100, 100) is faces[best]


def test_of_no_face_none_is_the_best() -> None:
    assert best_face([], 10, 10) is None
