import numpy as np
import pytest

from lrsr.identities.photographs.light import _harmonics, estimate_cast, estimate_shading
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


def two_lamps(size: int = 64) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Skin of one hue between a lamp of candles on the left and the sky on the right."""
    normals = half_sphere(size)
    left, right = (np.clip(0.6 + 0.4 * side * normals[..., 0], 0, None) for side in (-1, 1))
    light = left[..., None] * [2.4, 1.0, 0.2] + right[..., None] * [0.5, 1.0, 2.4]
    lit = np.array([0.45, 0.29, 0.22]) * light
    hue = np.log(lit[..., [0, 2]] / lit[..., [1]])
    return hue.astype(np.float32), np.log(lit[..., 1]).astype(np.float32), normals


def test_skin_between_lamps_of_two_colours_gets_one_hue() -> None:
    hue, tone, normals = two_lamps()
    core = np.zeros(tone.shape, bool)
    core[20:44, 20:44] = True
    cast = estimate_cast(hue, tone, normals, np.ones_like(tone), core)
    assert ((hue - cast).std(axis=(0, 1)) < 0.4 * hue.std(axis=(0, 1))).all()
    np.testing.assert_allclose(cast[core].mean(axis=0), 0, atol=1e-3)  # white is for white.py


def test_a_blush_is_no_light() -> None:
    hue, tone, normals = two_lamps()
    everywhere, hue = np.ones_like(tone), hue * np.float32(0.2)
    assert not estimate_cast(hue, tone, normals, everywhere, everywhere > 0).any()


def test_lips_and_a_mole_are_no_light() -> None:
    hue, tone, normals = two_lamps()
    everywhere = np.ones_like(tone)
    usual = estimate_cast(hue, tone, normals, everywhere, everywhere > 0)
    hue[30:36, 20:44] += [0.8, 0.2]
    with_them = estimate_cast(hue, tone, normals, everywhere, everywhere > 0)
    assert np.abs(with_them - usual).max() < 0.05


def test_a_tone_curve_that_yellows_the_dark_is_undone() -> None:
    normals = half_sphere()
    tone = np.log(np.clip(0.5 + 0.5 * normals[..., 1], 0.1, None)).astype(np.float32)
    hue = np.stack([-0.4 * tone, 0.4 * tone], axis=-1)
    core = np.abs(tone - np.median(tone)) < 0.3
    cast = estimate_cast(hue, tone, normals, np.ones_like(tone), core)
    assert ((hue - cast).std(axis=(0, 1)) < 0.4 * hue.std(axis=(0, 1))).all()


SKIN = np.array([0.45, 0.29, 0.22])


def test_skin_under_white_light_is_left_alone() -> None:
    assert np.abs(light_colour(SKIN)).max() < 0.02


def test_skin_whose_hue_a_tone_curve_made_stronger_is_not_tinted() -> None:
    assert np.abs(light_colour(SKIN**1.5)).max() < 0.05


@pytest.mark.parametrize("sign", [1, -1], ids=["orange", "blue"])
def test_a_strong_tint_is_taken_out_for_the_most_part(sign: int) -> None:
    tint = sign * np.array([0.5, -0.8])
    tinted = SKIN * np.exp([tint[0], 0, tint[1]])
    found = np.array(light_colour(tinted))
    assert (found / tint > 0.5).all()
    assert (found / tint < 1.1).all()
