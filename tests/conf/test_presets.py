"""The files of the groups hold the numbers that lrsr has always had; every one builds."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lrsr.identities.face.expression import Expression
from lrsr.paths import config_folder
from lrsr.presets import preset
from lrsr.rendering.backend import _start
from lrsr.rendering.lens import Lens, biconvex
from lrsr.rendering.lighting import Lighting
from lrsr.rendering.lights import Light, Panel
from lrsr.rendering.pose import Pose
from lrsr.rendering.skin import Skin
from lrsr.rendering.standpoint import Standpoint
from lrsr.rendering.surfaces import Surface

WINDOW = (1500.0, 900.0, 900.0)
SKIN1 = {
    "absorption_per_mm": (0.032, 0.17, 0.48),
    "scattering_per_mm": (0.74, 0.88, 1.01),
    "refractive_index": 1.4,
    "reach_mm": 10.0,
}


def softbox(azimuth_deg: float, elevation_deg: float) -> dict[str, Any]:
    """Return what the paper's lightings have in common."""
    light = Light(azimuth_deg, elevation_deg, 27.0, math.pi, (1.0, 1.0, 1.0), None)
    return {"lights": (light,), "fill_share": 0.25, "fill_rgb": (1.0, 1.0, 1.0)}


def room(rgb: tuple[float, float, float], kelvin: float) -> dict[str, Any]:
    window = Panel(WINDOW, 1200.0, 1500.0, math.pi, (1.0, 1.0, 1.0), kelvin)
    return {"lights": (), "fill_share": 0.4, "fill_rgb": rgb, "panels": (window,)}


DOUBLE_GAUSS = (
    Surface(58.950, 7.520, "N-BAF10", 25.2),
    Surface(169.660, 0.240, "air", 25.2),
    Surface(38.550, 8.050, "N-BAF10", 23.0),
    Surface(81.540, 6.550, "N-SF15", 23.0),
    Surface(25.500, 11.410, "air", 18.0),
    Surface(0.0, 9.000, "air", 17.1, stop=True),
    Surface(-28.990, 2.360, "F5", 17.0),
    Surface(81.540, 12.130, "K-LaK11", 20.0),
    Surface(-40.770, 0.380, "air", 20.0),
    Surface(874.130, 6.440, "N-LAF3", 20.0),
    Surface(-79.460, 72.228, "air", 20.0),
)
SMILE = {
    "mouthSmile": 0.6,
    "mouthDimple": 0.15,
    "mouthStretch": 0.1,
    "cheekSquint": 0.5,
    "eyeSquint": 0.3,
}
GRIN = {
    "mouthSmile": 0.75,
    "mouthUpperUp": 0.55,
    "mouthLowerDown": 0.3,
    "jawOpen": 0.08,
    "cheekSquint": 0.6,
    "eyeSquint": 0.45,
}
SURPRISE = {"browInnerUp": 0.7, "browOuterUp": 0.7, "eyeWide": 0.5, "jawOpen": 0.2}
FROWN = {"browDown": 0.8, "mouthFrown": 0.5, "mouthPress": 0.3, "eyeSquint": 0.2}

WANTED: dict[str, dict[str, Any]] = {
    "pose": {
        "frontal": Pose("frontal", 0.0, 0.0, 0.0),
        "up": Pose("up", 0.0, 20.0, 0.0),
        "down": Pose("down", 0.0, -20.0, 0.0),
        "left": Pose("left", 30.0, 0.0, 0.0),
    },
    "lighting": {
        "frontal": Lighting("frontal", **softbox(0.0, 10.0)),
        "above": Lighting("above", **softbox(0.0, 60.0)),
        "below": Lighting("below", **softbox(0.0, -50.0)),
        "side": Lighting("side", **softbox(70.0, 10.0)),
        "room_yellow": Lighting("room_yellow", **room((1.0, 0.78, 0.45), 5000.0)),
        "room_blue": Lighting("room_blue", **room((0.7, 0.9, 1.3), 9000.0)),
    },
    "lens": {
        "pinhole": Lens("pinhole", (), None, None, False),
        "thin": Lens("thin", (), 1.4, None, False),
        "single": Lens("single", biconvex(3.0, 1.0, 1.05, "N-BK7"), 4.0, None, False),
        "double_gauss": Lens("double_gauss", DOUBLE_GAUSS, None, None, False),
    },
    "standpoint": {
        "level": Standpoint("level", None, None, 1.6),
        "scface_far": Standpoint("scface_far", 4.2, 2.25, 1.6),
        "scface_middle": Standpoint("scface_middle", 2.6, 2.25, 1.6),
        "scface_near": Standpoint("scface_near", 1.0, 2.25, 1.6),
    },
    "expression": {
        "neutral": Expression("neutral", {}),
        "smile": Expression("smile", SMILE),
        "grin": Expression("grin", GRIN),
        "mouth_open": Expression("mouth_open", {"jawOpen": 0.25}),
        "blink": Expression("blink", {"eyeBlink": 1.0}),
        "squint": Expression("squint", {"eyeSquint": 0.9, "cheekSquint": 0.5, "browDown": 0.3}),
        "frown": Expression("frown", FROWN),
        "surprise": Expression("surprise", SURPRISE),
    },
    "rendering/skin": {
        "reflective": Skin("reflective", "reflective"),
        "jensen_skin1": Skin("jensen_skin1", "subsurface", "coefficients", **SKIN1),
        "tone": Skin("tone", "subsurface", "scattering", **SKIN1),
        "volumetric": Skin("volumetric", "volumetric", "coefficients", **SKIN1),
    },
}
ASKED_FOR = {"lighting": {"lamp", "map"}}
"""What is there to be changed: no table has ever held it."""


@pytest.mark.parametrize(
    ("group", "name"), [(group, name) for group, values in WANTED.items() for name in values]
)
def test_a_preset_is_what_it_was(group: str, name: str) -> None:
    assert preset(group, name) == WANTED[group][name]


@pytest.mark.parametrize("group", WANTED)
def test_there_is_no_other_file(group: str) -> None:
    files = {path.stem for path in (config_folder() / group).glob("*.yaml")}
    assert files == {*WANTED[group], *ASKED_FOR.get(group, ())}


def test_a_lamp_is_there_to_be_changed() -> None:
    assert preset("lighting", "lamp").panels == (Panel((600, 500, 900), 300, 300, kelvin=2850),)


def test_a_map_is_a_file(tmp_path: Path) -> None:
    room_map = tmp_path / "room.exr"
    _start().Bitmap(np.ones((4, 8, 3), np.float32)).write(str(room_map))
    lighting = preset("lighting", "map", map=str(room_map), map_deg=90)
    assert lighting == Lighting("map", (), 1.0, map=str(room_map), map_deg=90.0)
