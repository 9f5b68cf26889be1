"""Skin's spectra have skin's features and exactly the texture's colour."""

import numpy as np
import pytest

from lrsr.rendering.skin_spectrum import _skin_curves, _skins
from lrsr.spectra import srgb_curves

SKIN = np.array([0.45, 0.28, 0.2])


def test_curves_give_back_the_colour_under_daylight() -> None:
    _, curves = _skin_curves()
    np.testing.assert_allclose(srgb_curves() @ curves.T, np.eye(3), atol=1e-9)


def test_skins_of_the_model_are_recovered_from_their_colours() -> None:
    nm, curves = _skin_curves()
    spectra = _skins(nm)
    errors = (spectra @ srgb_curves().T @ curves - spectra)[:, (nm >= 400) & (nm <= 700)]
    assert float(np.sqrt((errors**2).mean())) < 0.006
    assert float(np.abs(errors).max()) < 0.04


def test_skin_has_the_dips_of_haemoglobin() -> None:
    nm, curves = _skin_curves()
    spectrum = dict(zip(nm.tolist(), (SKIN @ curves).tolist(), strict=True))
    # Oxyhaemoglobin absorbs most at 542 and 577 nm (S. Prahl's tables) and lets 560 nm through.
    assert spectrum[540] < spectrum[560] > spectrum[575]
    assert spectrum[620] > 1.4 * spectrum[575]
    assert 0 < min(spectrum.values()) < max(spectrum.values()) < 1


def test_fair_skin_reflects_more_than_dark_skin() -> None:
    spectra = _skins(np.array([450.0, 550.0, 650.0]))
    assert spectra.shape == (50, 3)
    assert (spectra[:5] > spectra[-5:]).all()


def test_the_texture_shows_those_curves_and_that_colour(traced: dict[str, np.ndarray]) -> None:
    nm, curves = _skin_curves()
    at = np.array([np.interp(traced["nm"], nm, curve) for curve in curves])
    np.testing.assert_allclose(traced["skin"], SKIN @ at, atol=1e-4)
    assert traced["skin_seen"] == pytest.approx(SKIN, rel=3e-3)


def test_a_head_that_comes_back_is_the_same_light(traced: dict[str, np.ndarray]) -> None:
    first, other, again = traced["turns"]
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)
