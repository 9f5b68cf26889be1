import numpy as np
import pytest

from lrsr.identities.face.template import template
from lrsr.identities.gate.coarse import coarse_head, coarse_quads, normals
from lrsr.identities.shape.basis import load_basis


def test_the_coarse_head_has_a_quarter_of_the_triangles_and_is_closed_at_its_seams() -> None:
    surface, faces = load_basis().surface, coarse_head().faces
    assert len(faces) == (surface.region == 0).sum() // 4
    assert (surface.twin[faces] == faces).all()


def test_triangles_are_those_of_the_coarse_head() -> None:
    assert coarse_head().faces.max() < len(template().skin)


def test_every_coarse_quad_of_the_mesh_is_listed_in_the_order_of_the_basis() -> None:
    assert len(coarse_quads()) == 4 * len(load_basis().quads)


def test_a_normal_is_as_long_as_twice_the_area_and_looks_to_whom_corners_turn_left() -> None:
    corners = np.array([[[0.0, 0.0, 5.0], [3.0, 0.0, 5.0], [0.0, 2.0, 5.0]]])
    assert normals(corners).tolist() == [[0.0, 0.0, 6.0]]
    assert normals(corners[:, ::-1]).tolist() == [[0.0, 0.0, -6.0]]


def test_centres_are_folded_onto_one_half_of_the_face() -> None:
    aside, up, out = coarse_head().folded()
    assert aside.min() >= 0.0
    np.testing.assert_array_equal(np.stack([up, out], axis=1), coarse_head().centres[:, 1:])
    assert up[np.argmax(out)] == pytest.approx(-41.0, abs=5.0)  # the tip of the nose
