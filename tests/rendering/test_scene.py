"""Scene, film and quality are values: equal numbers are equal, numbers out of range refused."""

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from fakes.scenes import LIGHTINGS, SKINS, scene

from lrsr.errors import InputError
from lrsr.identities.face.expression import NEUTRAL
from lrsr.rendering.lens import PINHOLE
from lrsr.rendering.pose import FRONTAL
from lrsr.rendering.scene import _LEAST_SAMPLES, _SCALES, Film, Quality, Scene
from lrsr.rendering.standpoint import LEVEL


def test_a_scene_needs_light_and_is_plain_otherwise() -> None:
    assert Scene(LIGHTINGS["side"]) == scene(lighting="side")
    assert scene() == Scene(LIGHTINGS["frontal"], FRONTAL, PINHOLE, LEVEL, NEUTRAL)


def test_equal_values_are_equal_whatever_their_numbers_are_made_of() -> None:
    assert Film(8) == Film(8.0, 1, 0) == Film(np.float32(8), np.int64(1), np.uint8(0))
    assert hash(Film(8)) == hash(Film(np.float64(8)))
    assert Quality(np.int64(512)) == Quality(512, 5, 1024) == Quality()
    assert len({scene("left"), scene("left"), scene("up")}) == 2


def test_a_film_that_has_not_moved_is_recorded_as_ever() -> None:
    assert Film(9, 2, 35).record() == {"ipd_px": 9.0, "scale": 2, "bands": 35}
    assert Film(shift_px=[1, 0]).record() == {
        **{"ipd_px": 8.0, "scale": 1, "bands": 0, "shift_px": (1.0, 0.0)}
    }
    assert Film(nearer=0.1).record()["nearer"] == 0.1


def test_a_scene_is_recorded_in_plain_values_with_its_names() -> None:
    asked = scene("left", "room_blue", "double_gauss", "scface_near", "smile", "cap")
    plain = json.loads(json.dumps(asked.describe()))
    names = {group: value["name"] for group, value in plain.items()}
    assert names == {
        "pose": "left",
        "lighting": "room_blue",
        "lens": "double_gauss",
        "standpoint": "scface_near",
        "expression": "smile",
        "another_day": "cap",
    }
    assert plain["pose"]["yaw_deg"] == 30.0
    assert plain["lighting"]["panels"][0]["kelvin"] == 9000.0
    assert len(plain["lens"]["surfaces"]) == 11
    assert plain["expression"]["units"]["mouthSmileLeft"] == 0.6
    assert plain["another_day"]["cap"] == 1.0


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"ipd_px": 0}, "ipd_px=0: wanted a number of pixels > 0 and < 2000"),
        ({"ipd_px": 2000}, "ipd_px=2000: wanted a number of pixels > 0 and < 2000"),
        ({"ipd_px": float("nan")}, "ipd_px=nan: wanted a number"),
        ({"ipd_px": "8"}, "ipd_px=8: wanted a number"),
        ({"scale": 0}, "scale=0: wanted one of"),
        ({"scale": 5}, "scale=5: wanted one of"),
        ({"scale": 8}, "scale=8: wanted one of"),
        ({"scale": 2.0}, "scale=2.0: wanted a whole number"),
        ({"scale": True}, "scale=[Tt]rue: wanted a whole number"),
        ({"bands": -1}, "bands=-1: wanted 0"),
        ({"bands": 6}, "bands=6: wanted 0, or 7 to 350"),
        ({"bands": 351}, "bands=351: wanted 0"),
        ({"shift_px": (0, -2)}, r"shift_px=\(0.0, -2.0\): wanted less than 2 px"),
        ({"shift_px": 1}, r"shift_px=1: wanted two numbers"),
        ({"nearer": 0.6}, "nearer=0.6: wanted -0.5 to 0.5"),
    ],
    ids=str,
)
def test_a_film_out_of_range_is_refused(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Film(**wrong)


@pytest.mark.parametrize("bands", [0, 7, 350])
@pytest.mark.parametrize("scale", _SCALES)
def test_a_film_in_range_is_made(scale: int, bands: int) -> None:
    film = Film(1999.9, scale, bands)
    assert (film.scale, film.bands) == (scale, bands)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"samples_per_pixel": 0}, r"rendering\.samples_per_pixel=0: wanted 1 to"),
        ({"samples_per_pixel": 2**24 + 1}, r"rendering\.samples_per_pixel=16777217: wanted 1 to"),
        ({"samples_per_pixel": 1.5}, r"rendering\.samples_per_pixel=1.5: wanted a whole number"),
        ({"max_depth": 1}, r"rendering\.max_depth=1: wanted 2 to"),
        ({"texture_size": 63}, r"rendering\.texture_size=63: wanted 64 to 8192"),
        ({"texture_size": 8193}, r"rendering\.texture_size=8193: wanted 64 to 8192"),
        ({"texture_size": None}, r"rendering\.texture_size=(None|null): wanted a whole number"),
    ],
    ids=str,
)
def test_a_quality_out_of_range_is_refused(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Quality(**wrong)


@pytest.mark.parametrize(
    ("samples", "ipd_px", "wanted"),
    [
        (512, 4, 512),
        (512, 8, 512),
        (512, 16, 128),
        (512, 64, _LEAST_SAMPLES),
        (2048, 13, 776),
        (16, 64, 16),
    ],
)
def test_a_larger_face_gets_as_many_rays(samples: int, ipd_px: float, wanted: int) -> None:
    slow = Quality(samples, 7, 64, SKINS["volumetric"])
    assert slow.at(ipd_px) == replace(slow, samples_per_pixel=wanted)
