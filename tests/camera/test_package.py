"""What `from lrsr.camera import ...` gives: the camera, and every stage that a preset may name."""

import re
from fractions import Fraction
from inspect import signature
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from omegaconf import ListConfig
from torch import nn

import lrsr.camera
from lrsr.errors import ImageContractError, InputError
from lrsr.paths import config_folder

PRESETS = sorted((config_folder() / "camera").glob("*.yaml"))


@pytest.mark.parametrize("name", lrsr.camera.__all__)
def test_every_name_is_a_module_of_the_chain(name: str) -> None:
    stage = getattr(lrsr.camera, name)
    assert stage.__name__ == name
    assert issubclass(stage, nn.Module)
    assert stage.__module__.startswith("lrsr.camera.")


@pytest.mark.parametrize("preset", PRESETS, ids=lambda path: path.stem)
def test_whatever_a_preset_is_made_of_is_exported(preset: Path) -> None:
    for target in re.findall(r"_target_: (\S+)", preset.read_text()):
        module, _, name = target.rpartition(".")
        assert name in lrsr.camera.__all__
        stage = getattr(lrsr.camera, name)
        assert module in {stage.__module__, "lrsr.camera"}


STAGES = [getattr(lrsr.camera, name) for name in lrsr.camera.__all__]
NUMBERS = [
    pytest.param(stage, name, one.default, id=f"{stage.__name__}-{name}")
    for stage in STAGES
    for name, one in signature(stage).parameters.items()
    if isinstance(one.default, int | float) and not isinstance(one.default, bool)
]
LISTS = [
    pytest.param(stage, name, one.default, id=f"{stage.__name__}-{name}")
    for stage in STAGES
    for name, one in signature(stage).parameters.items()
    if isinstance(one.default, tuple)
]
FLAGS = [
    pytest.param(stage, name, id=f"{stage.__name__}-{name}")
    for stage in STAGES
    for name, one in signature(stage).parameters.items()
    if isinstance(one.default, bool)
]


@pytest.mark.parametrize(("stage", "name", "value"), NUMBERS)
def test_numbers_of_any_type_are_the_same_setting(
    stage: type[nn.Module], name: str, value: float
) -> None:
    usual = vars(stage())
    kinds = [np.float64, float, Fraction]
    if float(value).is_integer() and name != "denoise_luma_level":
        kinds += [np.float32, np.int64, np.int32, np.float16]
    for kind in kinds:
        if name != "qualities" or kind is not Fraction:
            built = vars(stage(**{name: kind(value)}))
            assert {key: built[key] for key in usual if not key.startswith("_")} == {
                key: one for key, one in usual.items() if not key.startswith("_")
            }
            if name in built:
                assert type(built[name]) in (int, float, tuple)


BROKEN = [True, float("nan"), float("inf"), -float("inf"), "3", "", [1], {}, 10**400, 1j, None]


@pytest.mark.parametrize(("stage", "name", "value"), NUMBERS)
def test_what_is_no_number_is_refused_by_its_setting(
    stage: type[nn.Module], name: str, value: float
) -> None:
    for broken in BROKEN:
        if name == "qualities" and broken == [1]:
            continue
        match = r"^(quality|qualities)" if name == "qualities" else name
        with pytest.raises(InputError, match=match):
            stage(**{name: broken})


@pytest.mark.parametrize(("stage", "name", "value"), LISTS)
def test_lists_of_any_type_are_the_same_setting(
    stage: type[nn.Module], name: str, value: tuple[Any, ...]
) -> None:
    for kind in (list, np.array, ListConfig, lambda rows: list(np.array(rows))):
        assert repr(stage(**{name: kind(list(value))})) == repr(stage())


@pytest.mark.parametrize(("stage", "name", "value"), LISTS)
def test_what_is_no_list_of_numbers_is_refused_by_its_setting(
    stage: type[nn.Module], name: str, value: tuple[Any, ...]
) -> None:
    broken: list[object] = [True, "ab", 3, [], ["a", "b", "c"], {"a": 1, "b": 2}, None]
    for wrong in (*broken, [*value[:-1], float("nan")], [*value[:-1], True], [*value, 1.0]):
        with pytest.raises(InputError, match=name):
            stage(**{name: wrong})


@pytest.mark.parametrize(("stage", "name"), FLAGS)
def test_flags_are_true_or_false(stage: type[nn.Module], name: str) -> None:
    assert repr(stage(**{name: np.bool_(False)})) == repr(stage(**{name: False}))
    for broken in ("false", 2, None, [], 0.5):
        with pytest.raises(InputError, match=f"{name}=.*: wanted true or false"):
            stage(**{name: broken})


@pytest.mark.parametrize("stage", ["optics", "colour", "mosaic", "sensor", "processing", "stored"])
def test_a_stage_is_what_it_is_said_to_be(stage: str) -> None:
    for wrong in (3, "RGGB", nn.Identity(), {"_target_": "lrsr.camera.Sensor"}):
        with pytest.raises(InputError, match=f"{stage}=.*: wanted .*, or null"):
            lrsr.camera.Camera(**{stage: wrong})


def full(codec: str) -> lrsr.camera.Camera:
    stages = {
        "optics": lrsr.camera.Optics(f_number=1.4, natural_vignetting=True),
        "colour": lrsr.camera.Colour(),
        "mosaic": lrsr.camera.Mosaic(),
        "sensor": lrsr.camera.Sensor(),
        "processing": lrsr.camera.Processing(sharpen_amount=0.5),
    }
    return lrsr.camera.Camera("small", codec=codec, **stages, stored=lrsr.camera.Video(crf=20))


@pytest.mark.parametrize("dtype", [torch.float64, torch.float16, torch.bfloat16, torch.uint8])
def test_light_of_another_type_is_refused_with_the_wanted_one(dtype: torch.dtype) -> None:
    light = torch.full((1, 3, 16, 16), 1, dtype=dtype)
    for camera in (lrsr.camera.Camera(), full("true"), full("differentiable")):
        with pytest.raises(ImageContractError, match=f"linear: got {dtype}, wanted torch.float32"):
            camera(light, torch.ones(1), [1])


@pytest.mark.parametrize("light", [np.ones((1, 3, 16, 16)), [[1.0]], None], ids=["array", "l", "n"])
def test_light_that_is_no_tensor_is_refused(light: object) -> None:
    with pytest.raises(ImageContractError, match=r"linear: got .*, wanted a torch\.Tensor"):
        lrsr.camera.Camera()(light, torch.ones(1))


@pytest.mark.parametrize("metered", [1.0, None, [1.0], np.ones(1)], ids=repr)
def test_a_reading_that_is_no_tensor_is_refused(metered: object) -> None:
    with pytest.raises(ImageContractError, match=r"metered: got .*, wanted a torch\.Tensor"):
        lrsr.camera.Camera()(torch.ones(1, 3, 16, 16), metered)


@pytest.mark.parametrize("codec", ["true", "differentiable"])
def test_light_that_wants_a_gradient_gives_the_same_picture(codec: str) -> None:
    light = torch.rand(2, 3, 16, 16, generator=torch.Generator().manual_seed(0))
    reading = torch.ones(2)
    plain = full(codec)(light, reading, [1, 2])
    again = full(codec)(light.clone().requires_grad_(), reading.requires_grad_(), [1, 2])
    assert torch.equal(plain, again.detach())
