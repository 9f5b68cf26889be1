import numpy as np
import pytest

from lrsr.identities.face.expression import NEUTRAL, Expression
from lrsr.identities.face.eyes import Eyes
from lrsr.identities.face.resting import RestingFace, _head_frame, act, rest_face
from lrsr.identities.shape.basis import load_basis


@pytest.fixture(scope="module")
def face() -> RestingFace:
    return rest_face(load_basis().neutral)


def test_the_pupils_of_a_face_lie_on_the_x_axis_around_the_origin(face: RestingFace) -> None:
    np.testing.assert_allclose(face.eyes.pupils.mean(axis=0), 0.0, atol=1e-9)
    np.testing.assert_allclose(face.eyes.pupils[:, 1:], 0.0, atol=1e-9)


def test_a_head_frame_is_a_rotation() -> None:
    forwards = np.array([[0.0, 0.0, 1.0]] * 2)
    tilted = Eyes(
        np.array([[-30.0, 5.0, 1.0], [31.0, 9.0, -2.0]]), np.array([12.0, 12.0]), forwards
    )
    rotation, origin = _head_frame(tilted)
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(rotation) == pytest.approx(1.0)
    moved = tilted.moved(rotation, origin).pupils
    np.testing.assert_allclose(moved[0], -moved[1], atol=1e-12)
    np.testing.assert_allclose(moved[:, 1:], 0.0, atol=1e-12)


def test_a_neutral_expression_changes_nothing(face: RestingFace) -> None:
    weights, skin = act(face, NEUTRAL)
    assert weights is face.weights
    assert skin is face.skin


def test_an_open_jaw_moves_the_chin_down_and_leaves_the_forehead(face: RestingFace) -> None:
    _, skin = act(face, Expression("open", {"jawOpen": 1.0}))
    moved = skin - face.skin
    forehead = (face.skin[:, 1] > 30.0) & (face.skin[:, 2] > -20.0)
    assert moved[:, 1].min() < -10.0
    np.testing.assert_allclose(moved[forehead], 0.0, atol=0.01)


def test_shape_and_skin_are_in_one_frame(face: RestingFace) -> None:
    smooth = load_basis().surface.matrix @ face.shape.skin
    assert np.abs(smooth - face.skin).max() < 1.0  # but for lids that make way for eyes
