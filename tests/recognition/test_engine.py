from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import torch

from lrsr.errors import ImageContractError, InputError
from lrsr.evaluation.scores import CosineScores
from lrsr.recognition import Engine
from lrsr.recognition.alignment import TEMPLATE_PX, align
from lrsr.recognition.embedding import Embedder


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
