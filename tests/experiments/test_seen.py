from pathlib import Path
from typing import Any

import numpy as np
import torch

from lrsr.experiments.seen import Seen
from lrsr.pictures.picture import Picture
from lrsr.recognition import Engine
from lrsr.recognition.alignment import TEMPLATE_PX
from lrsr.recognition.finder import Faces, Finder
from lrsr.sr import Bicubic

TRUE = torch.from_numpy(TEMPLATE_PX / 4).float()


class Mistaken(Finder):
    """Finds every second face, 3 px of the picture that it sees too far to the right."""

    def __call__(self, srgb: torch.Tensor) -> Faces:
        points = np.stack([4 * TRUE.numpy() + 1.5 + [3, 0]] * len(srgb)).astype(np.float32)
        points[1::2] = np.nan
        boxes = np.full((len(srgb), 4), np.nan, dtype=np.float32)
        counts = np.resize(np.float32([2, 0]), len(srgb))
        return Faces(points, boxes, boxes[:, 0], counts)


def pictures(count: int, landmarks: Any = TRUE) -> list[Picture]:
    images = torch.rand(count, 3, 28, 28, generator=torch.Generator().manual_seed(0))
    return [Picture(image, "p", landmarks, "") for image in images]


def test_each_source_has_embeddings_and_the_detectors_have_errors(tone_model: Path) -> None:
    seen = Seen(["shared", "own"], Mistaken())
    seen.look(Engine(tone_model), pictures(4), Bicubic(4))
    assert np.isnan(seen.joined("own")[:, 0]).tolist() == [False, True] * 2
    assert np.isfinite(seen.joined("shared")).all()
    eyes_px = float(np.linalg.norm(TEMPLATE_PX[1] - TEMPLATE_PX[0]))
    np.testing.assert_allclose(seen.errors, [3 / eyes_px, np.nan] * 2, rtol=1e-4)
    assert seen.false_faces.tolist() == [1, 0] * 2  # one of two is right; none of none is wrong


def test_without_true_landmarks_nothing_is_known_of_errors(tone_model: Path) -> None:
    seen = Seen(["own"], Mistaken())
    seen.look(Engine(tone_model), pictures(2, None), Bicubic(4))
    assert np.isnan(seen.errors).all()
    np.testing.assert_array_equal(seen.false_faces, [np.nan, 0])


def test_no_detector_runs_where_true_landmarks_do(tone_model: Path) -> None:
    seen = Seen(["shared"])
    engine = Engine(tone_model)
    seen.look(engine, pictures(2), Bicubic(1))
    assert "finder" not in vars(engine)
    assert np.isnan(seen.errors).all()
