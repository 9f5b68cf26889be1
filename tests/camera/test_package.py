"""What `from lrsr.camera import ...` gives: the camera, and every stage that a preset may name."""

import re
from pathlib import Path

import pytest
from torch import nn

import lrsr.camera
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
