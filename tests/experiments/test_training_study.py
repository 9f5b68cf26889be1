"""Runs of a multirun side by side."""

import json
from pathlib import Path
from typing import Any

import pytest
from omegaconf import OmegaConf

from lrsr.errors import InputError
from lrsr.experiments.training_study import TrainingStudy
from lrsr.pictures.cache import RenderCache


def write_run(folder: Path, name: str, values: list[float], **settings: Any) -> Path:
    history = [
        {"epoch": epoch, "step": 10 * (epoch + 1), "val/psnr_y_db": value}
        for epoch, value in enumerate(values)
    ]
    told = {"finished": True, "history": history, "settings": {"validation_people": 2, **settings}}
    path = folder / name / "metrics.json"
    path.parent.mkdir(parents=True)
    path.write_text(json.dumps(told))
    return path


@pytest.fixture
def runs(tmp_path: Path) -> Path:
    folder = tmp_path / "study"
    write_run(folder, "0", [30, 33, 34, 34.5], **{"identities.count": 100, "people": 100})
    write_run(folder, "1", [30, 32, 31, 30.5], **{"identities.count": 9, "people": 9})
    return folder


def study(runs: Path, tmp_path: Path, **settings: Any) -> dict[str, Any]:
    (tmp_path / "out").mkdir(exist_ok=True)
    folder = TrainingStudy(runs, **settings).run(tmp_path / "out", RenderCache(tmp_path / "cache"))
    found: dict[str, Any] = json.loads((folder / "results.json").read_text())
    return found


def test_peaks_are_found_and_runs_go_by_the_amount_of_data(runs: Path, tmp_path: Path) -> None:
    few, many = study(runs, tmp_path)["rows"]
    assert few["label"] == "identities.count=9"
    assert (few["best_epoch"], few["best"], few["last"], few["drop"]) == (2, 32, 30.5, 1.5)
    assert (many["best_epoch"], many["drop"], many["steps"]) == (4, 0, 40)
    assert many["values"] == [30, 33, 34, 34.5]


def test_the_page_and_the_picture_show_them(runs: Path, tmp_path: Path) -> None:
    study(runs, tmp_path)
    page = (tmp_path / "out" / "report.html").read_text()
    assert "identities.count=9: val/psnr_y_db is highest after epoch 2 of 4, 32.00" in page
    assert (tmp_path / "out" / "learning.png").read_bytes()[1:4] == b"PNG"


def test_runs_that_differ_in_nothing_are_called_as_their_folders(tmp_path: Path) -> None:
    for name in ("a", "b"):
        write_run(tmp_path / "study", name, [1.0], seed=0)
    assert [row["label"] for row in study(tmp_path / "study", tmp_path)["rows"]] == ["a", "b"]


def test_other_validation_pictures_are_refused(runs: Path, tmp_path: Path) -> None:
    write_run(runs, "2", [1.0], validation_people=5)
    with pytest.raises(InputError, match=r"study/2 has validation_people=5 and 0 2: .*_count=N"):
        study(runs, tmp_path)


def test_a_folder_without_runs_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"holds no run: give paths.run of a lrsr train -m"):
        study(tmp_path, tmp_path)


def test_a_run_without_an_epoch_is_refused(runs: Path, tmp_path: Path) -> None:
    write_run(runs, "2", [])
    with pytest.raises(InputError, match=r"2/metrics.json has no epoch yet"):
        study(runs, tmp_path)


def test_what_is_no_record_is_refused(runs: Path, tmp_path: Path) -> None:
    (runs / "0" / "metrics.json").write_text("{}")
    with pytest.raises(InputError, match=r"0/metrics.json is no record of lrsr train: 'history'"):
        study(runs, tmp_path)


def test_an_unknown_figure_is_refused(runs: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"quantity=val/auc: .* has val/psnr_y_db"):
        study(runs, tmp_path, quantity="val/auc")


def test_the_folder_must_be_given() -> None:
    with pytest.raises(InputError, match="runs must be given"):
        TrainingStudy.from_config(OmegaConf.create({"runs": "???"}))
