"""Lamps: directions, panels that face the eyes, and what is refused."""

import math

import numpy as np
import pytest

from lrsr.errors import InputError
from lrsr.rendering.colour import LUMINANCE
from lrsr.rendering.lights import _NEAREST_MM, Light, Panel


@pytest.mark.parametrize(
    ("azimuth", "elevation", "wanted"),
    [(0, 0, (0, 0, 1)), (90, 0, (1, 0, 0)), (0, 90, (0, 1, 0)), (-90, 0, (-1, 0, 0))],
)
def test_angles_point_as_documented(azimuth: float, elevation: float, wanted: tuple) -> None:
    np.testing.assert_allclose(Light(azimuth, elevation).direction(), wanted, atol=1e-12)


@pytest.mark.parametrize("position", [(0, 0, 900), (500, 300, 700), (0, 900, 0), (0, -400, 1)])
def test_a_panel_faces_the_eyes_and_has_its_size(position: tuple) -> None:
    panel = Panel(position, 300.0, 200.0)
    matrix = panel.to_world()
    corners = np.array([[x, y, 0, 1] for x in (-1, 1) for y in (-1, 1)]) @ matrix.T
    sides = corners[:, None, :3] - corners[None, :, :3]
    lengths = np.unique(np.linalg.norm(sides, axis=2).round(6))
    np.testing.assert_allclose(lengths, [0, 200, 300, math.hypot(200, 300)], atol=1e-5)
    np.testing.assert_allclose(corners[:, :3].mean(axis=0), position, atol=1e-9)
    shines = matrix[:3, 2]
    np.testing.assert_allclose(shines, -np.array(position) / panel.distance_mm, atol=1e-12)
    assert np.linalg.det(matrix[:3, :3]) > 0
    assert matrix[1, 0] == pytest.approx(0, abs=1e-12)  # its width is level


def test_a_colour_temperature_takes_the_place_of_rgb() -> None:
    warm = Light(0, 0, kelvin=2850.0)
    assert warm.colour[0] > 1 > warm.colour[2]
    assert warm.colour @ LUMINANCE == pytest.approx(1)
    assert Panel((0, 0, 900), 1, 1, rgb=(2, 2, 2)).colour == pytest.approx([1, 1, 1])


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"width_mm": 0.0}, "panel at .* sizes and irradiance > 0"),
        ({"irradiance": -1.0}, "panel at .* sizes and irradiance > 0"),
        ({"position_mm": (0, math.nan, 900)}, r"panel\.position_mm=nan: wanted a number"),
        ({"position_mm": (0, 900)}, r"panel\.position_mm=\(0, 900\): wanted three numbers"),
        ({"position_mm": (0, 0, 0.5 * _NEAREST_MM)}, "at least 200 mm away"),
        ({"rgb": (0, 0, 0)}, r"panel: rgb=\(0\.0, 0\.0, 0\.0\); give three numbers"),
        ({"kelvin": 3000.0, "rgb": (1, 0, 0)}, "give one of the two"),
        ({"kelvin": 50.0}, "colour temperature 50.0 K"),
    ],
    ids=["flat", "dark", "nan", "plane", "in the head", "no colour", "two colours", "cold"],
)
def test_a_panel_refuses_what_cannot_be(fields: dict, message: str) -> None:
    with pytest.raises(InputError, match=message):
        Panel(**{"position_mm": (0, 0, 900), "width_mm": 10.0, "height_mm": 10.0, **fields})


@pytest.mark.parametrize(
    "broken",
    [{"irradiance": 0.0}, {"diameter_deg": 0.0}, {"diameter_deg": 200.0}, {"rgb": (1, -1, 0)}],
)
def test_a_light_refuses_what_cannot_be(broken: dict) -> None:
    with pytest.raises(InputError, match="light: irradiance"):
        Light(0, 0, **broken)
