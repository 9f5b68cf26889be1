import numpy as np
import pytest

from lrsr.identities.face.teeth import (
    _LOWER_WIDTHS_MM,
    _UPPER_WIDTHS_MM,
    build_jaws,
    paint_jaws,
)


def test_widths_are_those_of_wheelers_tables() -> None:
    # Nelson and Ash 2010: upper 8.5 6.5 7.5 7 7 10, lower 5 5.5 7 7 7 11 mm.
    np.testing.assert_allclose(_UPPER_WIDTHS_MM, (8.5, 6.5, 7.5, 7.0, 7.0, 10.0), atol=0.4)
    np.testing.assert_allclose(_LOWER_WIDTHS_MM, (5.0, 5.5, 7.0, 7.0, 7.0, 11.0), atol=0.4)


def test_both_sides_are_mirror_images() -> None:
    points = build_jaws().vertices
    mirrored = points * [-1.0, 1.0, 1.0]
    for point in mirrored[::17]:
        assert np.linalg.norm(points - point, axis=1).min() < 1e-3


def test_upper_front_teeth_overlap_the_lower_from_before() -> None:
    # Overjet and overbite of 1 to 3 mm are normal (Proffit, Contemporary Orthodontics).
    jaws = build_jaws()
    middle = np.abs(jaws.vertices[:, 0]) < 4
    upper, lower = (jaws.vertices[middle & (jaws.lower == below)] for below in (False, True))
    lower = lower[lower[:, 2] > -4]  # without the tongue
    assert 1 < upper[:, 2].max() - lower[:, 2].max() < 4
    assert 0.5 < lower[:, 1].max() - upper[:, 1].min() < 3


def test_faces_of_the_front_look_forward() -> None:
    jaws = build_jaws()
    a, b, c = (jaws.vertices[jaws.faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    crown = (jaws.uv[jaws.faces, 1] < 0.7).all(axis=1)  # not the backs of the teeth
    front = crown & (np.abs(a[:, 0]) < 6) & (np.abs(normal[:, 2]) > np.abs(normal[:, 1]))
    assert front.sum() > 20
    assert (normal[front, 2] > 0).mean() > 0.9


def test_it_is_a_small_mesh_with_a_layout_inside_the_texture() -> None:
    jaws = build_jaws()
    assert len(jaws.faces) < 3000
    assert jaws.faces.max() == len(jaws.vertices) - 1
    assert ((jaws.uv >= 0) & (jaws.uv <= 1)).all()


@pytest.mark.parametrize("age", [0.0, 1.0])
def test_reflectance_is_that_of_ivory_and_gums(age: float) -> None:
    texture = paint_jaws(age, 0.0)
    tooth, gum = texture[34, 16], texture[8, 16]
    assert 0.25 < tooth[1] < 0.55
    assert tooth[0] > tooth[1] > tooth[2]
    assert gum[0] > 2 * gum[1]
