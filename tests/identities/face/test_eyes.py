from collections.abc import Mapping

import numpy as np
import pytest

from lrsr.identities.face.eyes import (
    Eyes,
    _cornea_rise,
    eye_chart,
    eyeball_vertices,
    find_eyes,
    rotation_to,
    unit_ball,
)
from lrsr.identities.face.resting import RestingFace
from lrsr.identities.morphable import template
from lrsr.identities.shape.basis import load_basis


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


def test_nobodys_eyes_look_apart_or_aside(
    resting_faces: Mapping[str, list[RestingFace]],
) -> None:
    gazes = np.array([face.eyes.gazes for faces in resting_faces.values() for face in faces])
    left, right = np.degrees(np.arctan2(gazes[..., 0], gazes[..., 2])).T
    assert abs((right - left).mean()) < 2.0
    assert np.abs(right - left).max() < 5.0  # 9 prism dioptres
    assert np.abs(right + left).max() < 3.0


def test_the_ball_is_a_half_sphere_that_faces_outwards() -> None:
    ball = unit_ball()
    distance = np.linalg.norm(ball.vertices, axis=1)
    polar = np.arctan2(np.hypot(*ball.vertices.T[:2]), ball.vertices[:, 2])
    np.testing.assert_allclose(distance, 1 + _cornea_rise(polar))
    assert distance.max() == pytest.approx(1.06)
    assert ball.vertices[:, 2].min() == pytest.approx(0.0, abs=1e-12)
    corners = ball.vertices[ball.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (np.einsum("fc,fc->f", normals, corners.mean(axis=1)) > 0).all()


def test_the_texture_is_azimuthal_equidistant_with_v_downwards() -> None:
    ball = unit_ball()
    polar = np.arctan2(np.hypot(*ball.vertices.T[:2]), ball.vertices[:, 2])
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


def test_the_pole_of_an_eyeball_lies_before_the_pupil() -> None:
    eyes = make_eyes((0.48, -0.6, 0.64))
    for which in (0, 1):
        vertices = eyeball_vertices(eyes, which)
        apex = eyes.pupils[which] + 0.06 * 12 * eyes.gazes[which]
        np.testing.assert_allclose(vertices[0], apex, atol=1e-5)
        assert vertices.dtype == np.float32


def test_the_cornea_is_as_curved_as_gullstrands() -> None:
    angle = np.linspace(0.0, 0.05, 6)
    points = (
        16.6
        * (1 + _cornea_rise(angle))[:, None]
        * np.stack([np.sin(angle), np.cos(angle)], axis=-1)
    )
    sagitta, half = points[0, 1] - points[-1, 1], points[-1, 0]
    assert (half**2 + sagitta**2) / (2 * sagitta) == pytest.approx(7.8, rel=0.03)


def test_the_chart_of_an_eye_agrees_with_its_texture() -> None:
    eyes, ball = make_eyes((0.48, -0.6, 0.64)), unit_ball()
    chart = eye_chart(eyes, 1, eyeball_vertices(eyes, 1))
    np.testing.assert_allclose(chart / np.pi * [1, -1], ball.uv - 0.5, atol=1e-5)
