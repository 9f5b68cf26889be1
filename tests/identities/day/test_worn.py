from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from fakes.scenes import DAYS, EXPRESSIONS
from scipy.spatial import cKDTree

from lrsr.identities.day.another_day import AnotherDay
from lrsr.identities.face.expression import NEUTRAL
from lrsr.identities.head import Head
from lrsr.identities.morphable import sample_head
from lrsr.identities.splits import identity_seed
from lrsr.rendering.live_scene import _fits

Make = Callable[..., Head]

PEOPLE = (0, 1, 5)
KINDS = ("glasses", "cap", "face_mask")
WORN = {"lenses", *KINDS}


def ahead(skin: np.ndarray, points: np.ndarray, within_mm: float = 2.5) -> np.ndarray:
    """Return how far points are before the foremost skin near their x and y, mm."""
    face = skin[skin[:, 2] > -60]
    near = cKDTree(face[:, :2]).query_ball_point(points[:, :2], within_mm)
    reach = [face[found, 2].max() if found else -np.inf for found in near]
    return np.asarray(points[:, 2] - reach)


@pytest.mark.parametrize("index", PEOPLE)
def test_lenses_are_before_the_eyes_and_clear_of_the_face(person: Make, index: int) -> None:
    head = person(index, "glasses")
    lenses = head.part("lenses").vertices
    assert ahead(head.part("skin").vertices, lenses).min() > 0.5
    for pupil in head.pupils:
        near = np.linalg.norm(lenses[:, :2] - pupil[:2], axis=1) < 5
        assert near.any()
        assert (lenses[near, 2] > 13).all()  # 10 mm before the cornea
        assert (lenses[near, 2] < 40).all()


@pytest.mark.parametrize("index", PEOPLE)
def test_a_frame_rests_on_nose_and_ears(person: Make, index: int) -> None:
    head = person(index, "glasses")
    frame, skin = head.part("glasses").vertices, head.part("skin").vertices
    distance = cKDTree(skin).query(frame)[0]
    nose = (np.abs(frame[:, 0]) < 14) & (np.abs(frame[:, 1]) < 25)
    assert distance[nose].min() < 3.5
    for sign in (-1, 1):
        temple = (sign * frame[:, 0] > 45) & (frame[:, 2] < -60)
        assert distance[temple].min() < 4.0


@pytest.mark.parametrize("index", PEOPLE)
def test_hair_lies_under_a_cap(person: Make, index: int) -> None:
    head, bare = person(index, "cap"), person(index)
    cap = head.part("cap").vertices
    dome = cap[cap[:, 2] < -10]
    top = cap[:, 1].max()
    assert head.part("hair").vertices[:, 1].max() < top
    assert head.part("skin").vertices[:, 1].max() < top - 3
    above = head.part("hair").vertices
    above = above[above[:, 1] > 60]
    centre = np.array([0.0, dome[:, 1].min(), dome[:, 2].mean()])
    farthest = np.linalg.norm(dome - centre, axis=1).max()
    assert (np.linalg.norm(above - centre, axis=1) < farthest).all()
    np.testing.assert_array_equal(head.part("skin").vertices, bare.part("skin").vertices)


@pytest.mark.parametrize("index", PEOPLE)
def test_a_cap_leaves_the_eyes_free(person: Make, index: int) -> None:
    cap = person(index, "cap").part("cap").vertices
    assert cap[(np.abs(cap[:, 0]) < 50) & (cap[:, 2] > -20), 1].min() > 12


@pytest.mark.parametrize("expression", ["neutral", "mouth_open"])
@pytest.mark.parametrize("index", PEOPLE)
def test_a_mask_covers_nose_and_mouth_of_a_face_as_it_acts(
    person: Make, index: int, expression: str
) -> None:
    head = person(index, "face_mask", expression)
    cloth = head.part("face_mask").vertices[: 49 * 61].astype(float)
    skin = head.part("skin").vertices
    inside = np.abs(cloth[:, 0]) < 35
    assert ahead(skin, cloth[inside], 1.0).min() > -1.0  # of under the chin
    for landmark in head.landmarks[2:]:
        near = np.linalg.norm(cloth[:, :2] - landmark[:2], axis=1) < 6
        assert (cloth[near, 2] > landmark[2]).any()
    assert cloth[:, 1].max() < 0.3 * head.landmarks[2, 1]
    assert cKDTree(skin).query(cloth)[0].max() < 32  # it spans hollows and does not float


@pytest.mark.parametrize("kind", KINDS)
def test_who_wears_none_has_the_same_parts_out_of_sight(kind: str) -> None:
    seed = identity_seed("test", 1)
    day = AnotherDay("x", **{kind: 0.5})
    days = [day.later(n) for n in range(12)]
    worn = next(one for one in days if one.wears(seed, kind))
    not_worn = next(one for one in days if not one.wears(seed, kind))
    wearing, bare = (
        sample_head(seed, texture_size=64, another_day=one) for one in (worn, not_worn)
    )
    assert _fits(wearing, bare)
    assert kind in wearing.parameters["another_day"]  # type: ignore[operator]
    assert bare.parameters["another_day"] == {}
    for part in bare.parts:
        if part.name in WORN:
            assert np.ptp(part.vertices, axis=0).max() == 0
            assert bare.part("skin").vertices[:, 1].max() > part.vertices[0, 1] > 0


def test_heads_as_enrolled_have_none_of_the_parts(person: Make) -> None:
    assert not {part.name for part in person(0).parts} & WORN


def test_everything_can_be_worn_at_once_and_again_the_same() -> None:
    seed = identity_seed("test", 0)
    day = replace(DAYS["everything"], glasses=1, cap=1, face_mask=1)
    first, again = (
        sample_head(seed, texture_size=64, another_day=day, expression=face)
        for face in (NEUTRAL, EXPRESSIONS["neutral"])
    )
    assert {part.name for part in first.parts} >= WORN
    for one, other in zip(first.parts, again.parts, strict=True):
        np.testing.assert_array_equal(one.vertices, other.vertices)
        assert np.isfinite(one.vertices).all()
