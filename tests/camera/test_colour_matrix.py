"""Colour matrices for filters that cannot be undone, and what they leave."""

import numpy as np
import pytest
from skimage.color import deltaE_ciede2000, rgb2lab

from lrsr.camera.colour_matrix import fit_matrix, observed
from lrsr.camera.sensitivities import colorchecker, find_sensitivities
from lrsr.camera.spectral import SpectralColour
from lrsr.errors import InputError
from lrsr.spectra import band_edges, daylight, srgb_weights

EDGES = band_edges(35)
LIGHT = daylight(EDGES)
RNG = np.random.default_rng(0)


def rendered(weights: np.ndarray, matrix: np.ndarray, patches: np.ndarray) -> np.ndarray:
    """Return linear sRGB that a camera makes of reflectances in LIGHT, not clipped."""
    return np.asarray((patches * LIGHT) @ weights.T / (weights @ LIGHT) @ matrix.T)


def missed(shown: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Return ΔE00 between colours in linear sRGB, by scikit-image."""
    curved = [
        np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear.clip(0) ** (1 / 2.4) - 0.055)
        for linear in (shown, wanted)
    ]
    return np.asarray(deltaE_ciede2000(*map(rgb2lab, curved)))


def test_what_can_be_undone_is_undone() -> None:
    mixing = np.array([[0.7, 0.2, 0.1], [0.1, 0.8, 0.1], [0.0, 0.3, 0.7]])
    colours = RNG.uniform(0, 1, (24, 3))
    np.testing.assert_allclose(fit_matrix(colours @ mixing.T, colours), np.linalg.inv(mixing))


def test_white_stays_white_whatever_the_colours() -> None:
    matrix = fit_matrix(RNG.uniform(0, 1, (30, 3)), RNG.uniform(0, 1, (30, 3)))
    np.testing.assert_allclose(matrix.sum(axis=1), 1, atol=1e-12)


def test_no_other_matrix_that_keeps_white_is_nearer() -> None:
    balanced, wanted = RNG.uniform(0, 1, (2, 24, 3))
    matrix = fit_matrix(balanced, wanted)
    least = ((balanced @ matrix.T - wanted) ** 2).sum()
    for _ in range(50):
        step = RNG.normal(0, 0.05, (3, 3))
        other = matrix + step - step.mean(axis=1, keepdims=True)
        assert ((balanced @ other.T - wanted) ** 2).sum() > least


def test_greys_alone_make_no_matrix() -> None:
    greys = np.linspace(0.1, 1, 6)[:, None] * np.ones(3)
    with pytest.raises(InputError, match="at least two hues"):
        fit_matrix(greys, greys)


def test_an_observer_of_srgb_needs_no_matrix() -> None:
    patches = colorchecker(EDGES)
    same = rendered(srgb_weights(EDGES), np.eye(3), patches)
    np.testing.assert_allclose(same, observed(EDGES, LIGHT, patches), atol=1e-12)


def test_a_colorchecker_has_its_published_colours() -> None:
    # sRGB of "light skin", "orange", "foliage", "neutral 5" (X-Rite, 2009; D50 adapted to D65).
    srgb = np.array([[194, 150, 130], [214, 126, 44], [87, 108, 67], [122, 122, 121]]) / 255
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    seen = observed(EDGES, LIGHT, colorchecker(EDGES)[[1, 6, 3, 21]])
    assert missed(seen, linear).max() < 4  # another chart, another light


def test_the_nikons_matrix_is_nearly_the_one_that_adobe_measured() -> None:
    to_raw = np.array([[8198, -2239, -724], [-4871, 12389, 2798], [-1043, 2050, 7181]])
    srgb = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    balanced = to_raw @ srgb
    adobe = np.linalg.inv(balanced / balanced.sum(axis=1, keepdims=True))
    found = SpectralColour("nikon_d5100").rendition(EDGES).matrix
    assert np.abs(found - adobe).max() < 0.1
    # Were the curves per quantum, its distance would be larger: they are per energy.
    nikon = find_sensitivities("nikon_d5100")
    assert nikon.per == "energy"
    weights = nikon.weights(EDGES) * (np.array(EDGES[:-1]) + 5)
    patches = colorchecker(EDGES)
    raw = (patches * LIGHT) @ weights.T / (weights @ LIGHT)
    other = fit_matrix(raw, observed(EDGES, LIGHT, patches))
    assert np.linalg.norm(other - adobe) > 1.4 * np.linalg.norm(found - adobe)


def test_the_nikon_misses_the_colours_of_a_colorchecker_by_about_one() -> None:
    patches, look = colorchecker(EDGES), SpectralColour("nikon_d5100").rendition(EDGES)
    weights = find_sensitivities("nikon_d5100").weights(EDGES)
    shown = rendered(weights, look.matrix, patches)
    away = missed(shown, observed(EDGES, LIGHT, patches))
    assert float(away.mean()) == pytest.approx(0.86, abs=0.01)
    assert 3.0 < float(away.max()) < 3.5
