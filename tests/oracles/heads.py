"""Stand-in people: an egg with two eyeballs, of one topology; and black dots at landmarks."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lrsr.identities.head import Head, Material, Part


def ball(rows: int, columns: int) -> tuple[NDArray, NDArray, NDArray]:
    """Make a unit sphere: vertices, faces counter-clockwise from outside, uv with v = 0 at +y."""
    v, u = np.meshgrid(np.linspace(0, 1, rows + 1), np.linspace(0, 1, columns + 1), indexing="ij")
    theta, phi = v * np.pi, (u - 0.5) * 2 * np.pi  # u = 0.5 looks to +z, u grows to +x
    vertices = np.stack(
        [np.sin(theta) * np.sin(phi), np.cos(theta), np.sin(theta) * np.cos(phi)], axis=-1
    ).reshape(-1, 3)
    corner = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    a, b, c, d = corner, corner + columns + 1, corner + columns + 2, corner + 1
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return vertices, faces.astype(np.int32), np.stack([u, v], axis=-1).reshape(-1, 2)


def ellipsoid_part(
    name: str,
    material: Material,
    radii: Any,
    centre: Any,
    albedo: Any,
    rows: int = 24,
    columns: int = 48,
) -> Part:
    """Make an ellipsoid with those half axes, its texture wrapped around the vertical."""
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


def dots(points: NDArray[np.float64], radius_mm: float = 3.0) -> Head:
    """Make black balls that float where the landmarks of somebody are, and nothing else."""
    black = np.zeros((2, 2, 3))
    sizes = (radius_mm,) * 3
    parts = tuple(
        ellipsoid_part(f"dot_{number}", "lash", sizes, point, black, 12, 24)
        for number, point in enumerate(points)
    )
    return Head("dots", parts, points[:2], points)
