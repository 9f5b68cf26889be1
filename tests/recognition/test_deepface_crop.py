import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from oracles.make_alignments import CASES, picture

from lrsr.recognition.deepface_crop import cut_face, fit_to_square

ORACLE: dict[str, Any] = json.loads(
    (Path(__file__).parents[1] / "data" / "alignments_deepface.json").read_text()
)


@pytest.mark.parametrize("name", CASES)
def test_the_face_is_that_of_deepface(name: str) -> None:
    points, box = CASES[name]
    face = cut_face(picture(), np.array(box, dtype=float), np.array(points[:2], dtype=float))
    assert face is not None
    np.testing.assert_array_equal(face, ORACLE[name]["face"])
    square = fit_to_square(face, 112)
    np.testing.assert_allclose(square[4::16, 4::16], ORACLE[name]["square"], atol=1e-3)


def test_eyes_within_one_pixel_are_the_same_eyes() -> None:
    box, eyes = np.array([5.0, 5, 25, 30]), np.array([[10.0, 12], [20, 15]])
    moved = cut_face(picture(), box + 0.9, eyes + 0.9)
    np.testing.assert_array_equal(moved, cut_face(picture(), box, eyes))


def test_of_a_box_beside_the_picture_and_its_border_nothing_is_left() -> None:
    eyes = np.array([[110.0, 12], [120, 12]])
    assert cut_face(picture(), np.array([100.0, 5, 125, 30]), eyes) is None


def test_a_square_keeps_proportions_and_is_black_beside_them() -> None:
    square = fit_to_square(np.full((40, 20, 3), 200, dtype=np.uint8), 112)
    assert square.shape == (112, 112, 3)
    assert (square[:, 28:84] == 200).all()
    assert not square[:, :28].any()
    assert not square[:, 84:].any()
