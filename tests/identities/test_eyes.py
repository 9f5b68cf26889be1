import numpy as np
import pytest

from lrsr.identities.basis import load_basis
from lrsr.identities.eyes import (
    Eyes,
    clear_lids,
    eyeball_vertices,
    find_eyes,
    find_lids,
    make_lashes,
    rotation_to,
    unit_ball,
)
from lrsr.identities.morphable import template


def make_eyes(gaze: tuple[float, float, float] = (0.0, 0.0, 1.0)) -> Eyes:
    return Eyes(
        np.array([[-30.0, 0.0, -12.0], [30.0, 0.0, -12.0]]),
        np.array([12.0, 12.0]),
        np.array([gaze, gaze]),
    )


def test_pupils_lie_on_the_surface_of_the_eye_not_in_its_centre() -> None:
    np.testing.assert_allclose(make_eyes().pupils, [[-30, 0, 0], [30, 0, 0]])


def test_moving_eyes_moves_their_pupils_along() -> None:
    turn = rotation_to([0.6, 0.0, 0.8])
    eyes, origin = make_eyes((0.0, 0.6, 0.8)), np.array([1.0, 2.0, 3.0])
    np.testing.assert_allclose(
        eyes.moved(turn, origin).pupils, (eyes.pupils - origin) @ turn.T, atol=1e-12
    )


def test_eyeballs_of_the_template_are_makehumans() -> None:
    basis = load_basis()
    head = basis.shape(np.zeros(len(basis.names)))
    eyes = find_eyes(basis, head)
    np.testing.assert_allclose(eyes.radii, 14.95, atol=0.02)  # helper-l-eye of base.obj
    assert eyes.centres[0, 0] < 0 < eyes.centres[1, 0]
    np.testing.assert_allclose(np.linalg.norm(eyes.gazes, axis=1), 1.0)


def test_both_eyes_look_equally_high_and_nearly_straight_ahead() -> None:
    gazes = template().eyes.gazes
    np.testing.assert_allclose(gazes[0] * [-1, 1, 1], gazes[1], atol=1e-6)
    assert (gazes[:, 2] > 0.98).all()


def test_the_ball_is_a_half_sphere_that_faces_outwards() -> None:
    ball = unit_ball()
    np.testing.assert_allclose(np.linalg.norm(ball.vertices, axis=1), 1.0)
    assert ball.vertices[:, 2].min() == pytest.approx(0.0, abs=1e-12)
    corners = ball.vertices[ball.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (np.einsum("fc,fc->f", normals, corners.mean(axis=1)) > 0).all()


def test_the_texture_is_azimuthal_equidistant_with_v_downwards() -> None:
    ball = unit_ball()
    polar = np.arccos(np.clip(ball.vertices[:, 2], -1, 1))
    offset = ball.uv - 0.5
    np.testing.assert_allclose(np.linalg.norm(offset, axis=1), polar / np.pi, atol=1e-6)
    up = ball.vertices[:, 1].argmax()
    assert offset[up, 1] == pytest.approx(-0.5)


@pytest.mark.parametrize(
    "direction", [(0.0, 0.0, 1.0), (0.6, 0.0, 0.8), (0.48, -0.6, 0.64)], ids=str
)
def test_the_rotation_carries_z_to_the_direction(direction: tuple[float, float, float]) -> None:
    turn = rotation_to(direction)
    np.testing.assert_allclose(turn @ [0, 0, 1], direction, atol=1e-12)
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(turn) == pytest.approx(1.0)


def test_the_pole_of_an_eyeball_is_the_pupil() -> None:
    eyes = make_eyes((0.48, -0.6, 0.64))
    for which in (0, 1):
        vertices = eyeball_vertices(eyes, which)
        np.testing.assert_allclose(vertices[0], eyes.pupils[which], atol=1e-5)
        assert vertices.dtype == np.float32


def test_lids_that_clear_the_eye_stay_and_pierced_ones_are_pushed_out() -> None:
    eyes = make_eyes()
    usual = np.array([[-30.0, 0.0, 1.0], [-30.0, 9.0, -2.0], [-30.0, 60.0, 0.0]])
    lids = find_lids(usual, eyes)
    pierced = usual.copy()
    pierced[0, 2] = -2.0
    moved = clear_lids(pierced, eyes, lids)
    assert np.linalg.norm(moved[0] - eyes.centres[0]) == pytest.approx(12.36)  # 1.03 radii
    np.testing.assert_array_equal(moved[1:], usual[1:])


def test_rims_that_dip_into_the_eye_keep_doing_so() -> None:
    eyes = make_eyes()
    usual = np.array([[-30.0, 0.0, -0.6]])  # 0.95 radii
    floating = np.array([[-30.0, 0.0, 2.0]])
    moved = clear_lids(floating, eyes, find_lids(usual, eyes))
    assert np.linalg.norm(moved[0] - eyes.centres[0]) == pytest.approx(0.985 * 12)


def test_clearing_the_template_changes_next_to_nothing() -> None:
    average = template()
    moved = clear_lids(average.skin, average.eyes, average.lids)
    assert np.abs(moved - average.skin).max() < 0.3


def test_lashes_stand_on_the_lids_and_point_away_from_the_eye() -> None:
    basis = load_basis()
    head = basis.shape(basis.neutral)
    eyes = find_eyes(basis, head)
    lashes = make_lashes(basis, head, eyes)
    corners = lashes.place(head.lashes)[lashes.faces].astype(float)
    side = (corners[:, 0, 0] > eyes.centres[:, 0].mean()).astype(int)
    distance = np.linalg.norm(corners - eyes.centres[side][:, None], axis=2)
    assert (distance[:, 2] > distance[:, :2].max(axis=1)).all()
    assert len(lashes.faces) == 230
    np.testing.assert_allclose(lashes.weights.sum(axis=1), 1.0)
