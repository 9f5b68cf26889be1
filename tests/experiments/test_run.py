import json
from dataclasses import replace
from pathlib import Path

import pytest
from fakes.painted import PaintedMaker

from lrsr.camera import Camera
from lrsr.errors import InputError
from lrsr.experiments.run import verify
from lrsr.experiments.settings import (
    Condition,
    GallerySettings,
    IdentityRange,
    RenderingSettings,
    VerificationSettings,
)

SETTINGS = VerificationSettings(
    name="painted_people",
    question="Are painted people told apart?",
    conditions=(
        Condition(1, 8.0, "frontal", "frontal", "none"),
        Condition(6, 8.0, "left", "below", "heavy"),
    ),
    methods=("base", "bicubic4", "srcnn4"),
    identities=IdentityRange(count=8),
    gallery=GallerySettings(ipd_px=16.0),
    rendering=RenderingSettings(samples_per_pixel=4, texture_size=8),
    seed=5,
    level=0.9,
)


def run(folder: Path, model: Path, settings: VerificationSettings = SETTINGS) -> Path:
    return verify(
        settings,
        folder / "run",
        cache=folder / "cache",
        camera=Camera(),
        model=model,
        maker=PaintedMaker(),
        progress=False,
    )


def test_results_hold_what_the_stable_surface_promises(tmp_path: Path, tone_model: Path) -> None:
    results = json.loads((run(tmp_path, tone_model) / "results.json").read_text())
    assert set(results) >= {"rows", "config", "versions"}
    assert len(results["rows"]) == 2 * 3
    assert set(results["rows"][0]) >= {
        "experiment", "option", "method", "landmarks", "auc", "std", "low", "high",
        "n_genuine", "n_impostor", "psnr_y_db", "fta",
    }  # fmt: skip
    assert results["config"]["seed"] == 5


def test_report_shows_every_row_and_condition(tmp_path: Path, tone_model: Path) -> None:
    page = (run(tmp_path, tone_model) / "report.html").read_text()
    assert "Are painted people told apart?" in page
    for label in ("Base", "Bicubic 4", "SR 4", "Option 1", "Option 6"):
        assert label in page
    assert "http://" not in page.replace("http://www.w3.org", "")


def test_the_same_settings_give_the_same_numbers(tmp_path: Path, tone_model: Path) -> None:
    first = json.loads((run(tmp_path / "a", tone_model) / "results.json").read_text())
    again = json.loads((run(tmp_path / "b", tone_model) / "results.json").read_text())
    assert first["rows"] == again["rows"]


def test_a_missing_model_is_refused_before_rendering(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"absent\.onnx"):
        run(tmp_path, tmp_path / "absent.onnx")
    assert not (tmp_path / "cache").exists()


def test_an_unknown_method_leaves_no_folder_behind(tmp_path: Path, tone_model: Path) -> None:
    with pytest.raises(InputError, match="magic"):
        run(tmp_path, tone_model, replace(SETTINGS, methods=("magic",)))
    assert not (tmp_path / "cache").exists()
