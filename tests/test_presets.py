"""A name becomes a value once, by its file; what is wrong is told in one line."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
import torch
from hydra.errors import InstantiationException
from omegaconf import OmegaConf

from lrsr.configuration import settle
from lrsr.errors import InputError
from lrsr.paths import config_folder
from lrsr.presets import build, preset, value_of
from lrsr.rendering.lighting import Lighting
from lrsr.rendering.lights import Light
from lrsr.rendering.pose import Pose
from lrsr.rendering.skin import Skin

GROUPS = ("pose", "lighting", "lens", "standpoint", "expression", "rendering/skin", "camera")
NEEDS_A_FILE = ("lighting", "map")
POSE = {"_target_": "lrsr.rendering.Pose", "name": "mine"}


def presets() -> list[tuple[str, str]]:
    files = [
        (group, path.stem)
        for group in GROUPS
        for path in sorted((config_folder() / group).glob("*.yaml"))
    ]
    return [pair for pair in files if pair != NEEDS_A_FILE]


@pytest.mark.parametrize(("group", "name"), presets())
def test_every_file_of_a_group_builds_and_has_its_name(group: str, name: str) -> None:
    assert preset(group, name).name == name


def test_a_file_over_another_changes_what_it_says() -> None:
    base, tone = preset("rendering/skin", "jensen_skin1"), preset("rendering/skin", "tone")
    assert (tone.fixed, base.fixed) == ("scattering", "coefficients")
    assert tone.scattering_per_mm == base.scattering_per_mm


def test_fields_can_be_replaced() -> None:
    assert preset("pose", "left", pitch_deg=5) == Pose("left", 30.0, 5.0)
    lights = [{"azimuth_deg": 40, "elevation_deg": 50}]
    assert preset("lighting", "side", lights=lights, fill_share=0) == Lighting(
        "side", (Light(40, 50),), 0.0
    )
    assert preset("pose", "left") == Pose("left", 30.0), "nothing is kept between calls"


@pytest.mark.parametrize(
    ("group", "name", "message"),
    [
        ("pose", "sideways", "pose=sideways: there is none; choose one of down, frontal, left, up"),
        ("pose", "lefft", r"pose=lefft: there is none; did you mean left\?"),
        ("lens", None, "lens=None: there is none; choose one of double_gauss, pinhole"),
        ("pose", "../pose/left", "there is none"),
        ("rendering/skin", "wax", "rendering/skin=wax: there is none; choose one of jensen_skin1"),
        ("lighting", "map", r"lighting\.map must be given: add lighting\.map=\.\.\."),
    ],
)
def test_a_preset_that_there_is_not_is_named(group: str, name: str, message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        preset(group, name)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"tilt_deg": 3}, "pose: got an unexpected keyword argument 'tilt_deg'; --cfg job"),
        ({"yaw_deg": "steep"}, r"pose\.yaw_deg=steep: wanted a number"),
        ({"yaw_deg": float("nan")}, r"pose\.yaw_deg=nan: wanted a number"),
    ],
    ids=str,
)
def test_a_wrong_field_is_named(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        preset("pose", "left", **changes)


def test_a_value_is_named_given_or_changed() -> None:
    assert value_of("pose", "left") == preset("pose", "left")
    assert value_of("pose", OmegaConf.create({**POSE, "yaw_deg": 3})) == Pose("mine", 3.0)
    assert value_of("pose", {"yaw_deg": 3}) == Pose("own", 3.0)
    assert value_of("lighting", {"fill_share": 0.5}).lights == preset("lighting", "frontal").lights
    assert value_of("expression", {"units": {"jawOpen": 0.2}}).units == {"jawOpen": 0.2}
    assert value_of("rendering/skin", {"name": "matt"}) == Skin("matt")


@pytest.mark.parametrize("node", [None, 3, True, ["left"]], ids=str)
def test_a_value_of_anything_else_is_refused(node: object) -> None:
    with pytest.raises(InputError, match=r"pose=.*: wanted a name"):
        value_of("pose", node)


def test_what_a_file_names_is_built_with_more() -> None:
    assert build(POSE, "pose", yaw_deg=2) == Pose("mine", 2.0)
    node = OmegaConf.create({"angle": 7, "pose": {**POSE, "yaw_deg": "${angle}"}})
    assert build(node.pose, "pose") == Pose("mine", 7.0)


def test_a_part_of_what_is_built_can_be_wrong() -> None:
    lens = OmegaConf.load(config_folder() / "lens" / "single.yaml")
    lens.surfaces.thickness_mm = 9.0
    with pytest.raises(InputError, match=r"biconvex lens of 3\.0 mm.*do not fit"):
        build(lens, "lens")


def test_a_missing_setting_is_named_once() -> None:
    config = OmegaConf.create({"pose": {**POSE, "yaw_deg": "???"}})
    with pytest.raises(InputError, match=r"^pose\.yaw_deg must be given: add pose\.yaw_deg="):
        build(config.pose, "pose")


def test_a_target_that_is_not_there_is_a_fault() -> None:
    with pytest.raises(InstantiationException, match=r"lrsr\.rendering\.Nothing"):
        build({"_target_": "lrsr.rendering.Nothing"}, "pose")


@dataclass(frozen=True)
class Numbers:
    one: float | None = 1
    many: tuple[float, float] = (1, 2)

    def __post_init__(self) -> None:
        settle(self, "numbers")


def test_settled_numbers_are_floats_and_lists_tuples() -> None:
    values = [Numbers(), Numbers(1.0, [1, 2]), Numbers(np.float32(1), np.array([1, 2]))]
    values += [Numbers(np.int8(1), OmegaConf.create([1.0, 2.0]))]
    assert len(set(values)) == 1
    assert repr(values[0]) == repr(values[-1]) == "Numbers(one=1.0, many=(1.0, 2.0))"
    assert Numbers(None).one is None


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"one": "1"}, r"numbers\.one=1: wanted a number"),
        ({"one": True}, r"numbers\.one=[Tt]rue: wanted a number"),
        ({"one": float("inf")}, r"numbers\.one=inf: wanted a number"),
        ({"one": 10**400}, r"numbers\.one=1000"),
        ({"one": 1j}, r"numbers\.one=1j: wanted a number"),
        ({"many": [1, "x"]}, r"numbers\.many=x: wanted a number"),
        ({"many": [1, None]}, r"numbers\.many=.*: wanted a number"),
        ({"many": "12"}, r"numbers\.many=12: wanted two numbers, e\.g\. numbers\.many=\[1,1\]"),
        ({"many": 1}, r"numbers\.many=1: wanted two numbers"),
        ({"many": [1, 2, 3]}, r"numbers\.many=\[1, 2, 3\]: wanted two numbers"),
        ({"many": {"a": 1}}, r"numbers\.many=.*: wanted two numbers"),
        ({"many": None}, r"numbers\.many=null: wanted two numbers"),
    ],
    ids=lambda value: str(value)[:20],
)
def test_what_is_no_number_is_named(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Numbers(**wrong)


@pytest.mark.parametrize(
    "degrees", [np.float32(8), np.int64(8), torch.tensor(8.0).requires_grad_(), np.array(8.0), 8]
)
def test_a_change_may_be_a_number_of_any_type(degrees: Any) -> None:
    assert preset("pose", "left", yaw_deg=degrees) == preset("pose", "left", yaw_deg=8.0)
