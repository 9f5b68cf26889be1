"""A film says what its channels are."""

from dataclasses import replace

import pytest
import torch

from lrsr.rendering.radiance import Radiance, spectrum_of
from lrsr.spectra import band_edges

PLAIN = Radiance(torch.zeros(3, 2, 2), torch.zeros(5, 2), 8.0, 1, 2.0)
BANDED = replace(
    PLAIN, image=torch.zeros(7, 2, 2), edges_nm=band_edges(7), metered_bands=(1.0,) * 6 + (4.0,)
)


def test_films_of_three_colours_have_no_spectrum() -> None:
    assert spectrum_of([PLAIN, PLAIN]) is None


def test_the_white_of_each_film_is_the_meters_light_over_its_reading() -> None:
    spectrum = spectrum_of([BANDED, replace(BANDED, metered=4.0)])
    assert spectrum is not None
    assert spectrum.edges_nm == band_edges(7)
    assert spectrum.whites == (
        pytest.approx((0.5,) * 6 + (2.0,)),
        pytest.approx((0.25,) * 6 + (1.0,)),
    )
