from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
import torch

from lrsr.errors import ImageContractError, InputError
from lrsr.evaluation.scores import CosineScores
from lrsr.recognition import Engine
from lrsr.recognition.alignment import TEMPLATE_PX, Template, align, whole_pictures
from lrsr.recognition.detection.detector import Detector
from lrsr.recognition.detection.faces import Detection
from lrsr.recognition.embedding import Embedder
from lrsr.recognition.memory import Memory


def faces(count: int, side: int = 112) -> torch.Tensor:
    return torch.rand(count, 3, side, side, generator=torch.Generator().manual_seed(0))


def test_a_face_is_aligned_and_embedded(tiny_model: Path) -> None:
    landmarks = np.stack([TEMPLATE_PX * 0.5, TEMPLATE_PX * 0.4])
    images = faces(2, 60)
    crops, _ = align(images, landmarks, antialias=False)
    embeddings = Engine(tiny_model).embed(images, landmarks)
    np.testing.assert_array_equal(embeddings, Embedder(tiny_model)(crops))


def test_no_face_found_is_a_row_of_nan_and_its_scores_are_missing(tiny_model: Path) -> None:
    landmarks = np.stack([TEMPLATE_PX, np.full((5, 2), np.nan), TEMPLATE_PX])
    embeddings = Engine(tiny_model).embed(faces(3), landmarks)
    assert np.isnan(embeddings).all(axis=1).tolist() == [False, True, False]
    (tile,) = CosineScores(embeddings, embeddings[[0, 2]], list("abc"), list("ac")).tiles()
    assert np.isnan(tile.filled(np.nan)).tolist() == [[False] * 2, [True] * 2, [False] * 2]


BROKEN = {
    "0..255": (lambda srgb: srgb * 255, r"got values .*wanted \[0, 1\]"),
    "-1..1": (lambda srgb: srgb * 2 - 1, r"got values -0\.99.*wanted \[0, 1\]"),
    "bfloat16": (lambda srgb: srgb.bfloat16(), "got torch.bfloat16, wanted torch.float32"),
    "float64": (lambda srgb: srgb.double(), "got torch.float64, wanted torch.float32"),
    "bytes": (lambda srgb: srgb.mul(255).byte(), "got torch.uint8, wanted torch.float32"),
    "gradient": (
        lambda srgb: srgb.requires_grad_(),
        r"got a tensor that needs a gradient, wanted .*\[0, 1\]",
    ),
    "numpy": (lambda srgb: srgb.numpy(), "got ndarray, wanted a torch.Tensor"),
}


@pytest.mark.parametrize(("broken", "message"), BROKEN.values(), ids=BROKEN)
def test_pictures_of_another_kind_are_refused(
    tiny_model: Path, broken: Callable[[torch.Tensor], object], message: str
) -> None:
    with pytest.raises(ImageContractError, match=f"srgb: {message}"):
        Engine(tiny_model).embed(broken(faces(2)), np.stack([TEMPLATE_PX] * 2))


@pytest.mark.parametrize(("broken", "message"), BROKEN.values(), ids=BROKEN)
def test_crops_of_another_kind_are_refused(
    tiny_model: Path, broken: Callable[[torch.Tensor], object], message: str
) -> None:
    with pytest.raises(ImageContractError, match=f"crops: {message}"):
        Embedder(tiny_model)(broken(faces(2)))


def test_a_masked_face_is_not_found(tiny_model: Path) -> None:
    mask = np.zeros((2, 5, 2), dtype=bool)
    mask[0] = True
    landmarks = np.ma.masked_array(np.stack([TEMPLATE_PX] * 2), mask)
    embeddings = Engine(tiny_model).embed(faces(2), landmarks)
    assert np.isnan(embeddings).all(axis=1).tolist() == [True, False]


@pytest.mark.parametrize(
    "kind",
    [list, lambda p: torch.tensor(p).double(), lambda p: torch.tensor(p).double().requires_grad_()],
    ids=["list", "tensor", "gradient"],
)
def test_landmarks_of_any_kind_are_the_same_landmarks(
    tiny_model: Path, kind: Callable[[object], object]
) -> None:
    engine = Engine(tiny_model)
    points = (TEMPLATE_PX[None] * 4).round() / 4
    given = engine.embed(faces(1), kind(points.tolist()))
    np.testing.assert_array_equal(given, engine.embed(faces(1), points))


def test_nobody_found_is_no_error(tiny_model: Path) -> None:
    embeddings = Engine(tiny_model).embed(faces(2), np.full((2, 5, 2), np.nan))
    assert np.isnan(embeddings).all()


def test_the_contract_says_whether_to_antialias_unless_the_user_does(tiny_model: Path) -> None:
    assert Engine(tiny_model).describe()["antialias"] is False
    assert Engine(tiny_model, antialias=True).describe()["antialias"] is True


def test_a_report_can_say_which_model_it_was(tiny_model: Path) -> None:
    told = Engine(tiny_model).describe()
    assert (told["model"], told["licence"], told["dimension"]) == ("tiny.onnx", "MIT", 6)


def test_a_missing_model_is_the_users_to_mend(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"gone\.onnx is missing"):
        Engine(tmp_path / "gone.onnx")


def test_the_part_has_no_other_names() -> None:
    import lrsr.recognition

    with pytest.raises(AttributeError, match="has no attribute 'engin'"):
        lrsr.recognition.engin  # noqa: B018 - asking is the test


class Finder(Detector):
    """Finds what it is told to; counts how often it is asked."""

    def __init__(self, *faces: list[Detection]) -> None:
        super().__init__()
        self.faces, self.calls = faces, 0

    def __call__(self, srgb: torch.Tensor, *, ipd_px: float | None = None) -> list[list[Detection]]:
        self.calls += 1
        return [*self.faces]


def at(left: float, side: float, points: np.ndarray = TEMPLATE_PX) -> Detection:
    box = np.array([left, left, left + side, left + side], dtype=np.float32)
    return Detection(box, 0.75, points.astype(np.float32))


def test_the_best_face_of_each_picture_is_found(tiny_model: Path) -> None:
    engine = Engine(tiny_model, detector=Finder([at(0, 20), at(30, 50, TEMPLATE_PX / 2)], []))
    found = engine.find(faces(2))
    np.testing.assert_allclose(found.landmarks_px[0], TEMPLATE_PX / 2, rtol=1e-6)
    assert found.boxes_px[0].tolist() == [30, 30, 80, 80]
    assert found.scores.tolist()[:1] == [0.75]
    assert np.isnan(found.landmarks_px[1]).all()
    assert np.isnan(found.scores[1])


def test_the_detector_that_ships_finds_a_rendered_face(tiny_model: Path) -> None:
    level = cv2.imread(str(Path(__file__).parents[1] / "data" / "rendered_face.png"))[..., ::-1]
    picture = torch.from_numpy(level.copy()).permute(2, 0, 1)[None].float() / 255
    left, right, nose, *mouth = Engine(tiny_model).find(picture).landmarks_px[0]
    assert 24 * 0.8 < right[0] - left[0] < 24 * 1.1
    assert left[1] < nose[1] < mouth[0][1]


def test_what_is_not_found_may_be_the_whole_picture(tiny_model: Path) -> None:
    images, nowhere = faces(2, 60), np.full((2, 5, 2), np.nan)
    nowhere[0] = TEMPLATE_PX / 2
    some = Engine(tiny_model, fallback="whole_image").embed(images, nowhere)
    np.testing.assert_array_equal(some[0], Engine(tiny_model).embed(images, nowhere)[0])
    np.testing.assert_array_equal(some[1:], Embedder(tiny_model)(whole_pictures(images[1:])))


@pytest.mark.parametrize("template", ["eyes", "deepface"])
def test_the_user_may_align_in_another_way_than_the_contract(
    tiny_model: Path, template: Template
) -> None:
    images, points = faces(1, 60), TEMPLATE_PX[None] / 2
    engine = Engine(tiny_model, template=template)
    crops, _ = align(images, points, antialias=False, template=template)
    np.testing.assert_array_equal(engine.embed(images, points), Embedder(tiny_model)(crops))
    assert engine.describe()["alignment"] == template


def test_nothing_is_looked_at_twice(tiny_model: Path, tmp_path: Path) -> None:
    finder, images = Finder([at(30, 50)], [at(30, 40)]), faces(2)
    rows = []
    for _ in range(2):
        engine = Engine(tiny_model, detector=finder, memory=Memory(tmp_path))
        found = engine.find(images)
        rows.append(engine.embed(images, found.landmarks_px, found.boxes_px))
    assert finder.calls == 1
    np.testing.assert_array_equal(*rows)
    other = Engine(tiny_model, template="eyes", detector=finder, memory=Memory(tmp_path))
    assert (other.embed(images, found.landmarks_px) != rows[0]).any()


def test_a_detector_of_boxes_alone_is_refused(tiny_model: Path) -> None:
    engine = Engine(tiny_model, detector=Finder([at(0, 20, np.full((5, 2), np.nan))]))
    with pytest.raises(InputError, match=r"boxes without landmarks.*give another"):
        engine.find(faces(1))
