"""Tests of lrsr/pages.py."""

import base64
import io

import numpy as np
import pytest
from matplotlib.image import imread

from lrsr.errors import ImageContractError
from lrsr.pages import encode_face


def decode(uri: str) -> np.ndarray:
    kind, content = uri.split(",")
    assert kind == "data:image/png;base64"
    return np.asarray(imread(io.BytesIO(base64.b64decode(content))))


def test_a_face_keeps_every_pixel() -> None:
    face = np.random.default_rng(0).integers(0, 256, size=(3, 5, 7)) / 255
    assert decode(encode_face(face))[..., :3] == pytest.approx(face.transpose(1, 2, 0), abs=1e-6)


def test_a_face_beyond_the_range_is_clipped_for_the_picture() -> None:
    face = np.stack([np.full((1, 1), value) for value in (-0.5, 0.5, 1.5)])
    assert (decode(encode_face(face))[0, 0, :3] * 255).round().tolist() == [0, 128, 255]


@pytest.mark.parametrize("shape", [(1, 4, 4), (4, 4), (1, 3, 4, 4), (3, 0, 4)])
def test_what_is_no_face_is_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(ImageContractError, match="wanted"):
        encode_face(np.zeros(shape))


def test_a_face_with_a_nan_is_refused() -> None:
    with pytest.raises(ImageContractError, match="NaN"):
        encode_face(np.full((3, 2, 2), np.nan))
