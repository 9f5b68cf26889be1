"""Lightings: names, configuration, what is recorded of them, and what is refused."""

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fakes.scenes import LIGHTINGS, ROOMS
from hydra.utils import instantiate
from omegaconf import OmegaConf

from lrsr.errors import InputError
from lrsr.paths import config_folder
from lrsr.rendering.backend import _start
from lrsr.rendering.colour import rgb_of_kelvin
from lrsr.rendering.lighting import Lighting
from lrsr.rendering.lights import Light, Panel

WINDOW = Panel((1500.0, 900.0, 900.0), 1200.0, 1500.0)


def test_a_lamp_is_given_on_the_command_line() -> None:
    config = OmegaConf.load(config_folder() / "lighting" / "lamp.yaml")
    config.panels[0].kelvin = 3000
    lighting = instantiate(config)
    assert lighting.panels == (Panel((600, 500, 900), 300, 300, kelvin=3000),)
    np.testing.assert_allclose(lighting.panels[0].colour, rgb_of_kelvin(3000))


def test_lights_from_a_configuration_are_values() -> None:
    config = OmegaConf.create(
        {
            "_target_": "lrsr.rendering.Lighting",
            "name": "window",
            "lights": [
                {"azimuth_deg": 40, "elevation_deg": 50, "rgb": [1, 0.9, 0.7]},
            ],
        }
    )
    light = Light(azimuth_deg=40, elevation_deg=50, rgb=(1, 0.9, 0.7))
    lighting = instantiate(config)
    assert lighting == Lighting("window", (light,))
    assert hash(lighting) == hash(Lighting("window", (light,)))


def test_the_window_of_a_room_is_above_and_to_the_right() -> None:
    for room in ROOMS.values():
        (window,) = room.panels
        assert window.position_mm[0] > 0
        assert window.position_mm[1] > 0
    yellow, blue = (ROOMS[f"room_{hue}"].fill_colour for hue in ("yellow", "blue"))
    assert yellow[0] > 1 > yellow[2]
    assert blue[2] > 1 > blue[0]


def test_records_of_before_stay_true() -> None:
    """What lrsr 0.1.0 kept of the paper's "side"; cache keys and seeds hang on every word."""
    rgb = (1.0, 1.0, 1.0)
    side = {"azimuth_deg": 70.0, "elevation_deg": 10.0, "diameter_deg": 27.0}
    side |= {"irradiance": 3.141592653589793, "rgb": rgb}
    wanted = {"name": "side", "lights": [side], "fill_share": 0.25, "fill_rgb": rgb}
    assert LIGHTINGS["side"].record() == wanted


@pytest.mark.parametrize(
    "change",
    [
        {"panels": (WINDOW,)},
        {"fill_kelvin": 3000.0},
        {"map_deg": 5.0},
        {"lights": (Light(0.0, 0.0, kelvin=3000.0),)},
    ],
    ids=lambda change: next(iter(change)),
)
def test_what_is_new_is_recorded_where_it_is_used(change: dict[str, Any]) -> None:
    plain = Lighting("mine", (Light(0.0, 0.0),))
    changed = replace(plain, **change)
    assert changed.record() != plain.record()
    assert set(plain.record()) == {"name", "lights", "fill_share", "fill_rgb"}


def test_a_map_is_recorded_by_its_content(tmp_path: Path) -> None:
    first = tmp_path / "a.exr"
    _start().Bitmap(np.ones((4, 8, 3), np.float32)).write(str(first))
    second = Path(shutil.copy(first, tmp_path / "b.exr"))
    same, other = (Lighting("m", (), 1.0, map=str(path)) for path in (first, second))
    assert same.record() == other.record()
    _start().Bitmap(np.full((4, 8, 3), 2, np.float32)).write(str(second))
    assert same.record() != other.record()


@pytest.mark.parametrize(
    ("lights", "share", "fill"),
    [
        ((), 0.5, (1, 1, 1)),
        ((Light(0, 0),), 1.0, (1, 1, 1)),
        ((Light(0, 0),), -0.1, (1, 1, 1)),
        ((Light(0, 0),), 0.2, (0, 0, 0)),
    ],
    ids=["dark", "no room for the light", "negative", "no colour"],
)
def test_a_lighting_refuses_what_cannot_be(lights: tuple, share: float, fill: tuple) -> None:
    with pytest.raises(InputError, match="lighting 'bad'"):
        Lighting("bad", lights, share, fill)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"map": "no/such.exr"}, "map=no/such.exr is no file; give an .exr"),
        ({"map_deg": float("nan")}, r"lighting\.map_deg=nan: wanted a number"),
        ({"fill_kelvin": 100.0}, "colour temperature 100.0 K: give 2000 to 25000"),
        ({"fill_kelvin": 3000.0, "fill_rgb": (1, 0, 0)}, "give one of the two"),
        ({"fill_share": 1.0, "panels": (WINDOW,)}, "fill_share=1.0 with 1 lights"),
    ],
    ids=["no file", "nan", "too cool", "two colours", "no room for the window"],
)
def test_a_lighting_refuses_what_is_new_and_cannot_be(fields: dict, message: str) -> None:
    with pytest.raises(InputError, match=message):
        Lighting(**{"name": "bad", "fill_share": 1.0, **fields})
