"""The meter's light has the spectra that Mitsuba gives to lights."""

import numpy as np
import pytest
from fakes.scenes import LIGHTINGS, ROOMS

from lrsr.rendering.environment import environment
from lrsr.spectra import _observer, band_edges, daylight, photometric_unit, srgb_weights

Seen = dict[str, np.ndarray]
EDGES = band_edges(35)


def test_lights_have_mitsubas_spectra(traced: Seen) -> None:
    unit = float(traced["unit"]) * photometric_unit()
    theirs = (traced["lights"] * unit).reshape(5, 35, 10).mean(axis=2)
    np.testing.assert_allclose(traced["light_bands"], theirs, rtol=2e-3, atol=1e-6)


def test_their_colours_are_those_that_were_given(traced: Seen) -> None:
    colours = traced["light_bands"] @ srgb_weights(EDGES).T
    given = [[1.0, 1.0, 1.0], [1.0, 0.78, 0.45], [0.3, 2.0, 0.1], [0.0, 0.0, 0.5], [0, 0, 0]]
    np.testing.assert_allclose(colours, given, atol=0.01)
    np.testing.assert_allclose(traced["light_bands"][0], daylight(EDGES), rtol=1e-6)


def test_filters_lie_between_black_and_white(traced: Seen) -> None:
    filters = traced["filters"]
    assert filters.min() >= 0
    assert filters.max() <= 1
    assert filters[0] == pytest.approx(np.full(350, 0.5), abs=1e-6)


@pytest.mark.parametrize("name", ["yellow", "above"])
def test_the_luminance_of_the_meters_bands_is_its_reading(traced: Seen, name: str) -> None:
    _, metered = environment({**LIGHTINGS, "yellow": ROOMS["room_yellow"]}[name])
    luminance = _observer(EDGES)[1] @ traced[f"metered_{name}"]
    assert luminance == pytest.approx(metered, rel=2e-3)


def test_the_meter_reads_in_each_band_what_a_grey_sphere_sends(traced: Seen) -> None:
    # Each band of the sphere is known to 0.2 %.
    assert traced["sphere"] / 0.18 == pytest.approx(traced["sphere_metered"], rel=0.01)
    assert traced["backdrop"] == pytest.approx(traced["sphere_metered"], rel=0.01)


def test_white_light_is_metered_as_daylight(traced: Seen) -> None:
    above = traced["metered_above"]
    np.testing.assert_allclose(
        above / above.sum(), daylight(EDGES) / daylight(EDGES).sum(), rtol=1e-5
    )
