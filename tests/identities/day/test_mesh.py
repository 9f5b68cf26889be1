import numpy as np
import pytest

from lrsr.identities.day.mesh import Mesh, join, sheet, tube


def volume(mesh: Mesh) -> float:
    """By the divergence theorem; positive if all triangles are seen from outside."""
    a, b, c = (mesh.vertices[corner] for corner in mesh.faces.T)
    return float((a * np.cross(b, c)).sum() / 6)


def test_a_straight_rod_has_the_volume_of_its_section_times_its_length() -> None:
    path = np.stack([np.linspace(0, 50, 20), np.zeros(20), np.zeros(20)], axis=1)
    rod = tube(path, (0, 0, 1), (1.5, 2.5), sides=64)
    assert volume(rod) == pytest.approx(np.pi * 1.5 * 2.5 * 50, rel=0.01)


def test_a_ring_has_pappus_volume() -> None:
    angle = np.linspace(0, 2 * np.pi, 128, endpoint=False)
    path = 20 * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    ring = tube(path, (0, 0, 1), (1.0, 2.0), closed=True, sides=48)
    assert volume(ring) == pytest.approx(np.pi * 1.0 * 2.0 * 2 * np.pi * 20, rel=0.01)


def test_a_sheet_faces_who_sees_its_columns_go_right_and_its_rows_down() -> None:
    x, y = np.meshgrid(np.arange(3.0), -np.arange(4.0))
    flat = sheet(np.stack([x, y, 0 * x], axis=-1))
    a, b, c = (flat.vertices[corner] for corner in flat.faces.T)
    normal = np.cross(b - a, c - a)
    assert (normal[:, 2] > 0).all()
    assert normal[:, 2].sum() / 2 == pytest.approx(6)
    assert flat.uv.min() == 0
    assert flat.uv.max() == 1


def test_joined_meshes_keep_their_triangles() -> None:
    path = np.stack([np.linspace(0, 5, 5), np.zeros(5), np.zeros(5)], axis=1)
    one = tube(path, (0, 0, 1), (1, 1))
    other = one._replace(vertices=one.vertices + 10)
    assert volume(join([one, other])) == pytest.approx(2 * volume(one))
