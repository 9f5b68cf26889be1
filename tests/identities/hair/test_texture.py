import numpy as np
import pytest

from lrsr.identities.hair.texture import SHELL_COLUMNS, TEXTURE_SHAPE, hair_texture, mean_colour

BROWN = {"hair_colour": [0.10, 0.05, 0.02], "grey": 0.0, "curl_mm": 0.5}


def test_texture_is_reflectance_of_fixed_size() -> None:
    texture = hair_texture(BROWN, 0)
    assert texture.shape == (*TEXTURE_SHAPE, 3)
    assert texture.dtype == np.float32
    assert texture.min() >= 0.0
    assert texture.max() <= 0.9


@pytest.mark.parametrize("grey", [0.0, 0.4, 1.0])
@pytest.mark.parametrize("curl_mm", [0.0, 4.0])
def test_mean_of_the_texture_is_the_mean_colour(grey: float, curl_mm: float) -> None:
    parameters = BROWN | {"grey": grey, "curl_mm": curl_mm}
    means = [
        hair_texture(parameters, seed)[:, SHELL_COLUMNS:].mean(axis=(0, 1)) for seed in range(4)
    ]
    np.testing.assert_allclose(np.mean(means, axis=0), mean_colour(parameters), rtol=0.12)


def test_roots_are_darker_than_tips() -> None:
    texture = hair_texture(BROWN, 0)
    assert texture[:6].mean() < 0.8 * texture[-6:].mean()


def test_strands_run_along_the_columns() -> None:
    lightness = np.log(hair_texture(BROWN, 0)[..., 1])
    across = np.abs(np.diff(lightness, axis=1)).mean()
    along = np.abs(np.diff(lightness, axis=0)).mean()
    assert across > 4 * along


def test_curls_have_no_long_strands() -> None:
    straight, curly = (
        np.log(hair_texture(BROWN | {"curl_mm": curl}, 0)[60, :, 1]) for curl in (0.0, 4.0)
    )
    below = [np.log(hair_texture(BROWN | {"curl_mm": c}, 0)[90, :, 1]) for c in (0.0, 4.0)]
    assert np.corrcoef(straight, below[0])[0, 1] > 0.7
    assert np.corrcoef(curly, below[1])[0, 1] < 0.7


def test_half_grey_hair_mixes_strands() -> None:
    texture = hair_texture(BROWN | {"grey": 0.5}, 0)
    saturation = texture[..., 2] / texture[..., 0]
    assert saturation.min() < 0.4
    assert saturation.max() > 0.85


def test_seed_decides_the_strands() -> None:
    np.testing.assert_array_equal(hair_texture(BROWN, 5), hair_texture(BROWN, 5))
    assert np.abs(hair_texture(BROWN, 5) - hair_texture(BROWN, 6)).max() > 0.01


def test_shell_lies_in_the_shade_of_its_ribbons() -> None:
    texture = hair_texture(BROWN, 0)
    shell, ribbons = texture[:, :SHELL_COLUMNS], texture[:, SHELL_COLUMNS:]
    assert shell.mean() < 0.8 * ribbons.mean()
