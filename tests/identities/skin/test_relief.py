import numpy as np
import pytest
from numpy.typing import NDArray

from lrsr.identities.skin.relief import displace


def _sphere(n: int = 40) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    polar, azimuth = np.meshgrid(
        np.linspace(0.3, np.pi - 0.3, n), np.linspace(0, 2 * np.pi, n), indexing="ij"
    )
    vertices = np.stack(
        [np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)], axis=-1
    ).reshape(-1, 3)
    first = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    faces = np.concatenate(
        [
            np.stack([first, first + n, first + 1], axis=1),
            np.stack([first + 1, first + n, first + n + 1], axis=1),
        ]
    )
    return 50.0 * vertices, faces


def test_a_raised_sphere_is_a_larger_sphere() -> None:
    vertices, faces = _sphere()
    raised = displace(vertices, faces, np.full(len(vertices), 2.0))
    inner = np.linalg.norm(raised, axis=1).reshape(40, 40)[1:-1, 1:-1]
    np.testing.assert_allclose(inner, 52.0, atol=0.02)


def test_a_negative_height_lowers() -> None:
    vertices, faces = _sphere()
    lowered = displace(vertices, faces, np.full(len(vertices), -1.0))
    assert np.linalg.norm(lowered, axis=1).max() < 50


def test_what_has_no_height_stays_exactly() -> None:
    vertices, faces = _sphere()
    height = np.zeros(len(vertices))
    height[:100] = 1.0
    moved = displace(vertices, faces, height)
    np.testing.assert_array_equal(moved[100:], vertices[100:])
    assert (moved[:100] != vertices[:100]).any(axis=1).all()


def test_a_vertex_without_faces_stays() -> None:
    vertices, faces = _sphere()
    lonely = np.concatenate([vertices, [[1.0, 2.0, 3.0]]])
    moved = displace(lonely, faces, np.ones(len(lonely)))
    assert moved[-1] == pytest.approx([1.0, 2.0, 3.0])
