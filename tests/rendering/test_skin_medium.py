"""The medium of brute force: its numbers, and that a live one changes."""

import numpy as np
import pytest
from fakes.scenes import SKINS, Studio
from oracles.heads import stand_in

from lrsr.rendering.skin_medium import _FROM_OUTSIDE, _medium_numbers


def test_skin1_is_the_same_in_everybody() -> None:
    extinction, scattering = _medium_numbers(SKINS["volumetric"], stand_in(0, grey=0.2).parts[0])
    np.testing.assert_allclose(extinction, [0.772, 1.05, 1.49])
    np.testing.assert_allclose(scattering * extinction, [0.74, 0.88, 1.01])


def test_tone_sets_absorption_and_leaves_scattering() -> None:
    fair, dark = (stand_in(0, grey=grey).parts[0] for grey in (0.5, 0.1))
    for part in (fair, dark):
        extinction, scattering = _medium_numbers(SKINS["volumetric_tone"], part)
        np.testing.assert_allclose(scattering * extinction, [0.74, 0.88, 1.01])
    assert (scattering < _medium_numbers(SKINS["volumetric_tone"], fair)[1]).all()


def test_a_smooth_boundary_reflects_7_68_percent_of_diffuse_light() -> None:
    from lrsr.rendering.reflection import _fresnel

    cosines = (np.arange(4000) + 0.5) / 4000
    exact = 2 * (_fresnel(cosines, 1.4) * cosines).mean()
    assert exact == pytest.approx(_FROM_OUTSIDE, abs=2e-4)


def test_a_darker_head_is_darker_in_the_same_scene() -> None:
    """As its albedo says, within the noise of brute force."""
    brute = Studio("volumetric_tone")
    ask = {"ipd_px": 4, "samples_per_pixel": 64}
    fair, dark = (brute.render(stand_in(0, grey=grey), **ask).image for grey in (0.4, 0.1))
    face = (slice(None), slice(6, 10), slice(6, 10))
    assert 1.5 < float(fair[face].mean() / dark[face].mean()) < 4.5
