import cv2
import numpy as np
import pytest
from skimage.data import astronaut

from lrsr.identities.photographs.quality import glasses_edge
from lrsr.identities.photographs.reconstructor import shared_reconstructor

FIVE_PX = np.array([[205.0, 101.0], [247.0, 103.0], [224.0, 129.0], [202.0, 138.0], [244.0, 141.0]])
EYES_PX = ((205, 103), (247, 105))
RADIUS_PX = 17


@pytest.fixture(scope="module")
def points_px() -> np.ndarray:
    return shared_reconstructor().landmarker(as_floats(astronaut()), FIVE_PX).points_px


def as_floats(picture: np.ndarray) -> np.ndarray:
    return picture.astype(np.float32) / np.float32(255)


def with_frame(colour: tuple[int, int, int]) -> np.ndarray:
    picture = astronaut().copy()
    for eye in EYES_PX:
        cv2.circle(picture, eye, RADIUS_PX, colour, 2, cv2.LINE_AA)
    (left, y), (right, _) = EYES_PX
    cv2.line(picture, (left + RADIUS_PX, y), (right - RADIUS_PX, y + 2), colour, 2, cv2.LINE_AA)
    return as_floats(picture)


@pytest.mark.parametrize("colour", [(20, 20, 20), (110, 70, 40)], ids=["black", "brown"])
def test_frames_have_more_edges_than_a_face(
    points_px: np.ndarray, colour: tuple[int, int, int]
) -> None:
    bare = glasses_edge(as_floats(astronaut()), points_px)
    assert bare < 50
    assert glasses_edge(with_frame(colour), points_px) > bare + 40


def test_the_exposure_makes_no_difference(points_px: np.ndarray) -> None:
    framed = with_frame((60, 50, 50))
    light, dim = (
        glasses_edge(framed * share, points_px) for share in (np.float32(1), np.float32(0.6))
    )
    np.testing.assert_allclose(dim, light, rtol=0.15)


def test_brows_that_meet_are_no_glasses(points_px: np.ndarray) -> None:
    picture = astronaut().copy()
    cv2.line(picture, (212, 92), (240, 93), (40, 30, 20), 3, cv2.LINE_AA)
    one_edge = glasses_edge(as_floats(picture), points_px)
    assert one_edge < glasses_edge(with_frame((40, 30, 20)), points_px)
