import numpy as np
import pytest

from lrsr.identities.hair.anchors import AZIMUTHS, POLARS, SKULL_CENTRE_MM, _chart_directions
from lrsr.identities.hair.chart import (
    _LEVELS_MM,
    flatten,
    measure_ears,
    measure_skin,
    sample_chart,
    sample_level,
)

CENTRE = np.asarray(SKULL_CENTRE_MM)
SPHERE = CENTRE + 90.0 * _chart_directions()


def test_flattened_chart_keeps_the_polar_angle_as_its_radius() -> None:
    flat = flatten(np.array([0.0, 90.0, 180.0]), np.array([60.0, 45.0, 30.0]))
    np.testing.assert_allclose(flat, [[0.0, 60.0], [45.0, 0.0], [0.0, -30.0]], atol=1e-12)


def test_sampling_at_the_grid_gives_the_grid() -> None:
    azimuth, polar = np.meshgrid(
        np.arange(AZIMUTHS) * 3.0, np.arange(POLARS - 1) * 3.0, indexing="ij"
    )
    np.testing.assert_allclose(sample_chart(SPHERE, azimuth, polar), SPHERE[:, :-1], atol=1e-9)


def test_sampling_wraps_around_the_azimuth() -> None:
    polar = np.array([50.0])
    one, same = (sample_chart(SPHERE, np.array([a]), polar) for a in (-1.5, 358.5))
    np.testing.assert_allclose(one, same)


def test_width_of_a_sphere_follows_pythagoras() -> None:
    y = np.array([20.0, -10.0, -30.0])
    radius = sample_level(measure_skin(SPHERE, CENTRE), np.zeros(3), y)
    np.testing.assert_allclose(radius, np.sqrt(90.0**2 - (y - CENTRE[1]) ** 2), atol=0.3)


def test_ears_reach_where_they_are_and_nowhere_else() -> None:
    z, y = (grid.ravel() for grid in np.meshgrid(np.arange(-20, 21, 2), np.arange(-60, 1, 2)))
    left = np.stack([np.full(len(z), 100.0), y, z], axis=1)
    right = np.stack([np.full(len(z), -95.0), y, z], axis=1)
    table = measure_ears((CENTRE + np.concatenate([left, right])).astype(np.float32), CENTRE)
    height = np.full(3, CENTRE[1] - 30.0)
    reach = sample_level(table, np.array([90.0, -90.0, 0.0]), height)
    assert reach[:2] == pytest.approx([100.0, 95.0], rel=0.03)
    assert reach[2] == 0.0
    assert table.shape == (AZIMUTHS, len(_LEVELS_MM))
