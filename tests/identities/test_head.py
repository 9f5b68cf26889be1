import numpy as np
import pytest

from lrsr.identities.head import LANDMARK_NAMES, Head, Part


def make_head() -> Head:
    part = Part(
        name="skin",
        material="skin",
        vertices=np.zeros((3, 3), np.float32),
        faces=np.array([[0, 1, 2]], np.int32),
        uv=np.zeros((3, 2), np.float32),
        albedo=np.zeros((4, 4, 3), np.float32),
    )
    return Head(
        identity_id="made-up",
        parts=(part,),
        pupils=np.array([[-30.0, 0.0, 0.0], [30.0, 0.0, 0.0]]),
        landmarks=np.zeros((5, 3)),
    )


def test_the_interpupillary_distance_is_that_of_the_pupils() -> None:
    assert make_head().ipd_mm == 60.0


def test_a_part_is_found_by_its_name() -> None:
    head = make_head()
    assert head.part("skin") is head.parts[0]


def test_a_part_that_is_not_there_is_named() -> None:
    with pytest.raises(KeyError, match=r"made-up has no part 'hat'"):
        make_head().part("hat")


def test_landmarks_come_in_the_order_of_arcface() -> None:
    assert LANDMARK_NAMES == ("left_eye", "right_eye", "nose", "mouth_left", "mouth_right")
