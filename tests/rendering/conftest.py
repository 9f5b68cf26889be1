"""A stand-in person: an ellipsoid with two eyeballs, of one topology, and every size seeded."""

import numpy as np
import pytest
from numpy.typing import NDArray

from lrsr.identities.head import Head, Part


def ball(rows: int, columns: int) -> tuple[NDArray, NDArray, NDArray]:
    """Unit sphere: vertices, faces counter-clockwise from outside, uv with v = 0 at the top (+y)."""
    v, u = np.meshgrid(np.linspace(0, 1, rows + 1), np.linspace(0, 1, columns + 1), indexing="ij")
    theta, phi = v * np.pi, (u - 0.5) * 2 * np.pi  # u = 0.5 looks to +z, u grows to +x
    vertices = np.stack(
        [np.sin(theta) * np.sin(phi), np.cos(theta), np.sin(theta) * np.cos(phi)], axis=-1
    ).reshape(-1, 3)
    corner = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    a, b, c, d = corner, corner + columns + 1, corner + columns + 2, corner + 1
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return vertices, faces.astype(np.int32), np.stack([u, v], axis=-1).reshape(-1, 2)


def ellipsoid_part(name, material, radii, centre, albedo, rows=24, columns=48) -> Part:
    vertices, faces, uv = ball(rows, columns)
    placed = vertices * np.asarray(radii) + np.asarray(centre)
    return Part(
        name=name,
        material=material,
        vertices=placed.astype(np.float32),
        faces=faces,
        uv=uv.astype(np.float32),
        albedo=np.asarray(albedo, dtype=np.float32),
    )


def stand_in(seed: int = 0, *, ipd_mm: float | None = None, grey: float | None = None) -> Head:
    """Make an egg with eyes whose pupils lie on the plane z = 0."""
    rng = np.random.default_rng(seed)
    ipd = rng.uniform(55, 72) if ipd_mm is None else ipd_mm
    albedo = np.full((8, 8, 3), rng.uniform(0.1, 0.6) if grey is None else grey)
    albedo[:, :, 1:] *= 1.0 if grey is not None else 0.7
    eye = np.full((8, 8, 3), 0.7)
    eye[3:5, 3:5] = 0.05
    pupils = np.array([[-ipd / 2, 0, 0], [ipd / 2, 0, 0]])
    depth = rng.uniform(90, 100)
    parts = (
        ellipsoid_part("skin", "skin", (72, 110, depth), (0, -10, -depth + 12), albedo),
        ellipsoid_part("left_eye_ball", "eye", (12, 12, 12), (-ipd / 2, 0, -12), eye, 12, 24),
        ellipsoid_part("right_eye_ball", "eye", (12, 12, 12), (ipd / 2, 0, -12), eye, 12, 24),
    )
    landmarks = np.array([*pupils, [0, -40, 20], [-25, -70, 0], [25, -70, 0]], dtype=float)
    return Head(f"stand-in-{seed}", parts, pupils, landmarks, {"seed": seed})


@pytest.fixture
def head() -> Head:
    return stand_in()
