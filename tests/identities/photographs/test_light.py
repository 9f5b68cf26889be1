import numpy as np
import pytest

from lrsr.identities.photographs.light import _harmonics, estimate_shading
from lrsr.identities.photographs.white import light_colour


def half_sphere(size: int = 64) -> np.ndarray:
    x, y = np.meshgrid(np.linspace(-0.9, 0.9, size), np.linspace(0.9, -0.9, size))
    z = np.sqrt(np.maximum(0.05, 1 - x * x - y * y))
    normals = np.stack([x, y, z], axis=-1)
    return np.asarray(normals / np.linalg.norm(normals, axis=-1, keepdims=True), np.float32)


def test_harmonics_are_orthogonal_over_the_sphere() -> None:
    rng = np.random.default_rng(0)
    normals = rng.standard_normal((200_000, 3))
    values = _harmonics(normals / np.linalg.norm(normals, axis=1, keepdims=True))
    products = values.T @ values / len(values)
    assert np.abs(products - np.diag(np.diag(products))).max() < 0.01


def test_a_matte_surface_under_smooth_light_is_even_again() -> None:
    normals = half_sphere()
    light = np.array([1.0, 0.25, 0.1, 0.3, 0.02, 0.0, 0.0, 0.05, 0.05])
    luminance = (0.3 * _harmonics(normals) @ light).astype(np.float32)
    everywhere = np.ones(luminance.shape, bool)
    shading, unevenness = estimate_shading(
        luminance, normals, everywhere.astype(np.float32), everywhere
    )
    flat = np.log(luminance / shading)
    assert flat.std() < 0.05 < np.log(luminance).std()
    assert unevenness < 0.05


def test_a_highlight_does_not_pull_the_light() -> None:
    normals = half_sphere()
    luminance = (0.3 + 0.1 * normals[..., 0]).astype(np.float32)
    everywhere = np.ones(luminance.shape, bool)
    weight = everywhere.astype(np.float32)
    usual, _ = estimate_shading(luminance, normals, weight, everywhere)
    luminance[28:34, 28:34] = 3.0
    with_one, _ = estimate_shading(luminance, normals, weight, everywhere)
    assert np.abs(np.log(with_one / usual)).max() < 0.05


SKIN = np.array([0.45, 0.29, 0.22])


def test_skin_under_white_light_is_left_alone() -> None:
    assert np.abs(light_colour(SKIN)).max() < 0.02


@pytest.mark.parametrize("sign", [1, -1], ids=["orange", "blue"])
def test_a_strong_tint_is_taken_out_for_the_most_part(sign: int) -> None:
    tint = sign * np.array([0.5, -0.8])
    tinted = SKIN * np.exp([tint[0], 0, tint[1]])
    found = np.array(light_colour(tinted))
    assert (found / tint > 0.5).all()
    assert (found / tint < 1.1).all()
