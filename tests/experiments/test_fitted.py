"""Tests of lrsr/experiments/fitted.py; how cameras are fitted, tests/calibration tries."""

from pathlib import Path
from typing import Any

import pytest
import torch

from lrsr.calibration.from_pictures import FitSettings
from lrsr.experiments import fitted
from lrsr.identities.roster import IdentityRange
from lrsr.paths import config_folder
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.image_files import write_png
from lrsr.pictures.sitting import Sitting
from lrsr.presets import preset
from lrsr.rendering.scene import Film, Quality, Scene


def test_a_camera_is_fitted_once_for_the_same_pictures_and_settings(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fits: list[FitSettings] = []

    def fit(settings: FitSettings, folder: Path, **_: Any) -> Path:
        fits.append(settings)
        text = (config_folder() / "camera" / "webcam.yaml").read_text()
        (folder / "case.yaml").write_text(text)
        return folder

    monkeypatch.setattr(fitted, "fit_to_folder", fit)
    images, cache = tmp_path / "images", RenderCache(tmp_path / "cache")
    for k in range(2):
        write_png(images / f"{k}.png", torch.full((3, 32, 32), k / 2))
    scene = Scene(preset("lighting", "frontal"))
    people = Sitting(IdentityRange(count=20), scene, Film(8.0), Quality())

    def ask(rounds: int = 3) -> str:
        settings = FitSettings(images, {"name": "generic"}, people, "case", 8.0, 0.75, rounds)
        return str(fitted.fit_once(settings, tmp_path / "camera", cache)["name"])

    assert [ask(), ask()] == ["webcam", "webcam"]
    assert len(fits) == 1
    ask(rounds=4)
    assert len(fits) == 2
    write_png(images / "0.png", torch.full((3, 32, 32), 0.9))
    ask(rounds=4)
    assert len(fits) == 3
    (tmp_path / "camera" / "case.yaml").unlink()
    ask(rounds=4)
    assert len(fits) == 4
