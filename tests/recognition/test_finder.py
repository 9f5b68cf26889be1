from pathlib import Path

import cv2
import numpy as np
import pytest
import torch

from lrsr.errors import InputError
from lrsr.recognition.alignment import TEMPLATE_PX
from lrsr.recognition.detection.detector import Detector
from lrsr.recognition.detection.faces import Detection
from lrsr.recognition.finder import Finder
from lrsr.recognition.memory import Memory


class Told(Detector):
    """Finds what it is told to; counts how often it is asked."""

    def __init__(self, *faces: list[Detection]) -> None:
        super().__init__()
        self.faces, self.calls = faces, 0

    def __call__(self, srgb: torch.Tensor, *, ipd_px: float | None = None) -> list[list[Detection]]:
        self.calls += 1
        return [*self.faces]


def pictures(count: int) -> torch.Tensor:
    return torch.rand(count, 3, 112, 112, generator=torch.Generator().manual_seed(0))


def at(left: float, side: float, points: np.ndarray = TEMPLATE_PX) -> Detection:
    box = np.array([left, left, left + side, left + side], dtype=np.float32)
    return Detection(box, 0.75, points.astype(np.float32))


def test_the_best_face_of_each_picture_is_found() -> None:
    found = Finder(Told([at(0, 20), at(30, 50, TEMPLATE_PX / 2)], []))(pictures(2))
    np.testing.assert_allclose(found.landmarks_px[0], TEMPLATE_PX / 2, rtol=1e-6)
    assert found.boxes_px[0].tolist() == [30, 30, 80, 80]
    assert found.scores.tolist()[:1] == [0.75]
    assert np.isnan(found.landmarks_px[1]).all()
    assert np.isnan(found.scores[1])


def test_the_detector_that_ships_finds_a_rendered_face() -> None:
    levels = cv2.imread(str(Path(__file__).parents[1] / "data" / "rendered_face.png"))[..., ::-1]
    picture = torch.from_numpy(levels.copy()).permute(2, 0, 1)[None].float() / 255
    left, right, nose, *mouth = Finder()(picture).landmarks_px[0]
    assert 24 * 0.8 < right[0] - left[0] < 24 * 1.1
    assert left[1] < nose[1] < mouth[0][1]


def test_nothing_is_looked_at_twice(tmp_path: Path) -> None:
    detector = Told([at(30, 50)], [])
    one, other = (Finder(detector, Memory(tmp_path))(pictures(2)) for _ in range(2))
    assert detector.calls == 1
    np.testing.assert_array_equal(one.landmarks_px, other.landmarks_px)
    detector.score_threshold = 0.6
    Finder(detector, Memory(tmp_path))(pictures(2))
    assert detector.calls == 2


def test_a_detector_of_boxes_alone_is_refused() -> None:
    finder = Finder(Told([at(0, 20, np.full((5, 2), np.nan))]))
    with pytest.raises(InputError, match=r"boxes without landmarks.*give another"):
        finder(pictures(1))
