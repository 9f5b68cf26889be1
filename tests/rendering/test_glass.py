"""Glasses against the numbers that their makers print."""

import numpy as np
import pytest
from oracles.abbe import C_LINE_NM, F_LINE_NM, abbe_number

from lrsr.errors import InputError
from lrsr.rendering.glass import (
    _SELLMEIER,
    AIR,
    index_of_ray,
    refractive_index,
)

CATALOGUE = {
    "N-BK7": (1.51680, 64.17),
    "N-SK16": (1.62041, 60.32),
    "N-BAF10": (1.67003, 47.11),
    "K-LaK11": (1.65830, 57.3),
    "N-LAF3": (1.71700, 47.96),
    "F2": (1.62004, 36.37),
    "F5": (1.60342, 38.03),
    "N-SF11": (1.78472, 25.68),
    "N-SF15": (1.69892, 30.20),
}
"""n_d and V_d as printed (Schott 2017, Sumita 2017)."""


@pytest.mark.parametrize("glass", CATALOGUE)
def test_the_index_at_the_d_line_is_the_catalogues(glass: str) -> None:
    assert refractive_index(glass) == pytest.approx(CATALOGUE[glass][0], abs=1e-5)


@pytest.mark.parametrize("glass", CATALOGUE)
def test_the_abbe_number_is_the_catalogues(glass: str) -> None:
    printed = CATALOGUE[glass][1]
    assert abbe_number(glass) == pytest.approx(printed, abs=0.02 if glass == "K-LaK11" else 0.01)


def test_other_lines_are_the_data_sheets() -> None:
    # N-BK7, SCHOTT data sheet 2017: n_F, n_C, n_g (435.8343 nm)
    wanted = [1.52238, 1.51432, 1.52668]
    index = refractive_index("N-BK7", [F_LINE_NM, C_LINE_NM, 435.8343])
    np.testing.assert_allclose(index, wanted, atol=1e-5)


def test_every_glass_bends_blue_more_than_red_and_air_bends_nothing() -> None:
    nm = np.linspace(380, 780, 50)
    for glass in _SELLMEIER:
        change = np.diff(refractive_index(glass, nm))
        assert (change == 0).all() if glass == AIR else (change < 0).all()


def test_the_formula_for_rays_is_the_same() -> None:
    seen = index_of_ray(_SELLMEIER["N-SF11"], 0.55, np.sqrt)
    assert seen == pytest.approx(float(refractive_index("N-SF11", 550)), abs=1e-14)


def test_an_unknown_glass_names_the_known() -> None:
    with pytest.raises(InputError, match="glass 'jam' is not known; choose one of air, N-BK7"):
        refractive_index("jam")
