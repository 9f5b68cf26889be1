"""The double Gauss of ``conf/lens`` is the one that its sources print."""

import math

import numpy as np
import pytest
from fakes.scenes import LENSES
from oracles.abbe import abbe_number

from lrsr.rendering.glass import refractive_index
from lrsr.rendering.lens import biconvex
from lrsr.rendering.surfaces import focal_length_mm, image_of, trace

DOUBLE_GAUSS = LENSES["double_gauss"].surfaces
PRINTED = ((1.670, 47.1), (1.670, 47.1), (1.699, 30.1), (1.603, 38.0), (1.658, 57.3), (1.717, 48.0))
"""n_d and V_d of the six elements, Smith 1992 p. 312."""


def test_the_glasses_of_the_double_gauss_are_those_of_the_table() -> None:
    glasses = [surface.glass for surface in DOUBLE_GAUSS if surface.glass != "air"]
    seen = [(float(refractive_index(glass)), abbe_number(glass)) for glass in glasses]
    assert (np.abs(np.subtract(seen, PRINTED)) <= (5e-4, 0.15)).all()


@pytest.mark.parametrize("height_mm", [8.0, 12.0, 16.0])
def test_the_double_gauss_is_sharper_than_one_lens(height_mm: float) -> None:
    """How far from the paraxial focus do the rays of that height arrive, at 100 mm?"""
    errors = []
    for surfaces in (DOUBLE_GAUSS, biconvex(100.0, 15.0, 25.0, "N-BK7")):
        scale = 100 / focal_length_mm(surfaces)
        lens = tuple(surface.scaled(scale) for surface in surfaces)
        film_mm = image_of(lens, np.inf)[0] + sum(surface.thickness_mm for surface in lens[:-1])
        origin, ahead = np.array([[0.0, height_mm, -50.0]]), np.array([[0.0, 0.0, 1.0]])
        point, way, through = trace(lens, origin, ahead)
        assert through.all()
        errors.append(abs(point[0, 1] + (film_mm - point[0, 2]) * way[0, 1] / way[0, 2]))
    assert errors[0] < 0.02
    assert errors[1] > 5 * errors[0]


def test_the_edge_of_the_double_gauss_lets_its_widest_ray_through() -> None:
    highest = focal_length_mm(DOUBLE_GAUSS) / 4 * 0.98
    _, _, through = trace(
        DOUBLE_GAUSS, np.array([[0.0, highest, -50.0]]), np.array([[0.0, 0.0, 1.0]])
    )
    assert through.all()
    assert math.isclose(sum(surface.stop for surface in DOUBLE_GAUSS), 1)
