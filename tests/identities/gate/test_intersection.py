import numpy as np
import pytest
from numpy.typing import NDArray

from lrsr.identities.face.expression import Expression
from lrsr.identities.face.resting import act, rest_face
from lrsr.identities.face.template import template
from lrsr.identities.gate.intersection import (
    _crossing_pairs,
    _edges_cross,
    _nose_faces,
    count_nose_crossings,
    lip_overlap_mm,
)
from lrsr.identities.shape.basis import load_basis

Points = NDArray[np.float64]

FLAT = np.array([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]])
APART = np.diag([0.0, 9.0, 18.0])
"""Where centres of three triangles lie on the template: far from each other."""
THROUGH = np.array([[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [1.5, 1.0, 1.0]])


def skin() -> Points:
    return template().skin.copy()


def exact_crossing(one: Points, other: Points) -> bool:
    """Solve for the point where each edge meets the other's plane: slow and obvious."""
    for start, end in zip(one, np.roll(one, -1, axis=0), strict=True):
        matrix = np.stack([end - start, other[0] - other[1], other[0] - other[2]], axis=1)
        if abs(np.linalg.det(matrix)) > 1e-9:
            t, u, v = np.linalg.solve(matrix, other[0] - start)
            if 0 <= t <= 1 and u >= 0 and v >= 0 and u + v <= 1:
                return True
    return False


def test_an_edge_through_a_triangle_crosses_it() -> None:
    assert _edges_cross(THROUGH[None], FLAT[None]).tolist() == [True]


@pytest.mark.parametrize(
    "other", [np.add(THROUGH, (9.0, 0.0, 0.0)), np.add(THROUGH, (0.0, 0.0, 5.0)), FLAT], ids=str
)
def test_triangles_beside_above_and_in_one_plane_do_not_cross(other: Points) -> None:
    assert not _edges_cross(other[None], FLAT[None]).any()


def test_crossings_of_chance_triangles_are_those_of_linear_algebra() -> None:
    rng = np.random.default_rng(1)
    one, other = rng.normal(size=(2, 300, 3, 3))
    wanted = [exact_crossing(a, b) for a, b in zip(one, other, strict=True)]
    assert 50 < sum(wanted) < 250
    assert _edges_cross(one, other).tolist() == wanted


def test_pairs_that_cross_are_found_and_neighbours_are_none() -> None:
    vertices = np.concatenate([FLAT, THROUGH, np.add(FLAT[1:2], (0.0, 4.0, 0.5))])
    faces = np.array([[0, 1, 2], [3, 4, 5], [1, 6, 2]])
    assert _crossing_pairs(vertices, faces, APART, reach_mm=10.0, apart_mm=0.0).tolist() == [[0, 1]]


def test_pairs_out_of_reach_are_not_compared() -> None:
    vertices, faces = np.concatenate([FLAT, THROUGH]), np.array([[0, 1, 2], [3, 4, 5]])
    assert len(_crossing_pairs(vertices, faces, APART, reach_mm=0.01, apart_mm=0.0)) == 0


def test_creases_do_not_count() -> None:
    vertices, faces = np.concatenate([FLAT, THROUGH]), np.array([[0, 1, 2], [3, 4, 5]])
    usual = np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]])
    near, far = (
        _crossing_pairs(vertices, faces, usual, reach_mm=10.0, apart_mm=apart)
        for apart in (2.9, 3.1)
    )
    assert (len(near), len(far)) == (1, 0)


def test_the_templates_nose_does_not_cross_itself() -> None:
    assert count_nose_crossings(skin()) == 0


def test_a_nose_whose_wings_collapse_through_the_septum_crosses_itself() -> None:
    collapsed = skin()
    faces, _ = _nose_faces()
    nose = np.unique(faces)
    wing = nose[np.abs(collapsed[nose, 0]) > 8.0]
    collapsed[wing, 0] -= 14.0 * np.sign(collapsed[wing, 0])
    assert count_nose_crossings(collapsed) > 20


def test_the_templates_lips_hardly_press() -> None:
    assert lip_overlap_mm(skin()) < 0.5


def test_lips_pushed_into_each_other_overlap_by_as_much() -> None:
    pressed, more = skin(), skin()
    lower = (pressed[:, 1] < -73.5) & (pressed[:, 1] > -100.0) & (np.abs(pressed[:, 0]) < 30.0)
    pressed[lower, 1] += 4.0
    more[lower, 1] += 6.0
    assert lip_overlap_mm(pressed) > 3.5
    assert lip_overlap_mm(more) > lip_overlap_mm(pressed) + 1.0


def test_open_lips_meet_in_the_corners_of_the_mouth_alone() -> None:
    _, opened = act(rest_face(load_basis().neutral), Expression("open", {"jawOpen": 1.0}))
    assert lip_overlap_mm(opened) < 0.5


def test_lips_that_never_face_each_other_do_not_overlap() -> None:
    parted = skin()
    parted[parted[:, 1] < -76.0, 0] += 100.0
    parted[(parted[:, 1] >= -76.0) & (parted[:, 1] < -60.0), 1] += 40.0
    assert lip_overlap_mm(parted) < 0.5
