import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import cv2
import pytest
from fakes.painted import PaintedMaker

from lrsr.camera import Camera
from lrsr.camera.sensor import Sensor
from lrsr.errors import InputError
from lrsr.experiments.asked import Asked
from lrsr.experiments.conditions import Condition
from lrsr.experiments.scoring import Scoring
from lrsr.experiments.verification import Verification
from lrsr.identities.roster import IdentityRange
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.sitting import Sitting
from lrsr.presets import preset
from lrsr.recognition.settings import RecognitionSettings
from lrsr.rendering.scene import Film, Quality, Scene

PEOPLE, QUALITY = IdentityRange(count=8), Quality(samples_per_pixel=4, texture_size=64)
FRONTAL = Scene(preset("lighting", "frontal"))
TURNED = Scene(preset("lighting", "below"), preset("pose", "left"))


CONDITIONS = (Condition(1, FRONTAL, "none", 8.0), Condition(6, TURNED, "heavy", 8.0))
METHODS = ("base", "bicubic4", "srcnn4")


def run(
    folder: Path,
    model: Path | None,
    recognition: Mapping[str, Any] | None = None,
    conditions: tuple[Condition, ...] = CONDITIONS,
    methods: tuple[str, ...] = METHODS,
    **settings: Any,
) -> Path:
    design = Verification(
        name="painted_people",
        question="Are painted people told apart?",
        conditions=conditions,
        upscalers={name: preset("sr", name) for name in methods},
        people=PEOPLE,
        quality=QUALITY,
        seed=5,
        gallery=Sitting(PEOPLE, FRONTAL, Film(16.0), QUALITY, "gallery", 5),
        camera=Camera(),
        level=0.9,
        recognition=RecognitionSettings(model=model, **(recognition or {})),
        **settings,
    )
    cache = RenderCache(folder / "cache")
    return design.run(folder / "run", cache, maker=PaintedMaker(), progress=False)


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory, tone_model: Path) -> Path:
    return run(tmp_path_factory.mktemp("done"), tone_model)


def test_results_hold_what_the_stable_surface_promises(done: Path) -> None:
    results = json.loads((done / "results.json").read_text())
    assert set(results) >= {"rows", "config", "versions"}
    assert len(results["rows"]) == 2 * 3
    assert set(results["rows"][0]) >= {
        "experiment", "option", "method", "landmarks", "auc", "std", "low", "high",
        "n_genuine", "n_impostor", "psnr_y_db", "fta",
    }  # fmt: skip
    assert results["config"]["seed"] == 5


def test_scores_that_were_written_down_give_the_same_rows(done: Path, tmp_path: Path) -> None:
    asked = Asked(level=0.9, bootstrap=0, seed=5, calibration="logistic")
    again = Scoring((done / "scores.csv",), asked).run(tmp_path / "again")
    rows, same = (
        json.loads((place / "results.json").read_text())["rows"] for place in (done, again)
    )
    numbers = ("option", "ipd_px", "method", "landmarks", "auc", "std", "subject_std", "fta", "eer")
    for name in (*numbers, "rank_1", "fnmr", "partial_auc"):
        assert [row[name] for row in same] == [row[name] for row in rows]


def test_report_shows_every_row_and_condition(done: Path) -> None:
    page = (done / "report.html").read_text()
    assert "Are painted people told apart?" in page
    for label in ("Base", "Bicubic 4", "SR 4", "Option 1", "Option 6"):
        assert label in page
    assert "http://" not in page.replace("http://www.w3.org", "")


def test_the_same_settings_give_the_same_numbers_with_or_without_scores(
    done: Path, tmp_path: Path, tone_model: Path
) -> None:
    other = run(tmp_path, tone_model, save_scores=False)
    first, again = (json.loads((each / "results.json").read_text()) for each in (done, other))
    assert first["rows"] == again["rows"]
    assert not (other / "scores.csv").exists()


def test_several_recognisers_have_a_table_each(tmp_path: Path, tone_model: Path) -> None:
    names = ("shipped", str(tone_model))
    folder = run(tmp_path, None, {"recognisers": names})
    results = json.loads((folder / "results.json").read_text())
    told = [row["recogniser"] for row in results["rows"]]
    assert told == ["shipped"] * 6 + ["tones"] * 6
    assert results["recognition"]["recognisers"]["tones"]["model"] == "tones.onnx"
    told = [test["recogniser"] for test in results["comparisons"]]
    assert told == ["shipped"] * 6 + ["tones"] * 6
    assert results["rows"][0]["d_prime"] != results["rows"][6]["d_prime"]
    page = (folder / "report.html").read_text()
    for name in ("shipped", "tones"):
        assert page.count(f"<h3>Recogniser: {name}</h3>") == 3
        assert f"<h2>{name}. Option 6" in page
    assert page.count("<h3>Faces</h3>") == 2
    assert "its figures do not say how well people can be recognised" in page


def test_a_missing_model_is_refused_before_rendering(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"absent\.onnx"):
        run(tmp_path, tmp_path / "absent.onnx")
    assert not (tmp_path / "cache").exists()


def test_scores_of_true_and_of_found_landmarks_are_kept_with_what_the_detector_said(
    tmp_path: Path, tone_model: Path
) -> None:
    folder = run(tmp_path, tone_model, {"landmarks": ("shared", "own")})
    header, *lines = (folder / "scores.csv").read_text().splitlines()
    assert header.endswith("detector_score")
    rows = json.loads((folder / "results.json").read_text())["rows"]
    assert [row["landmarks"] for row in rows] == (["shared"] * 3 + ["own"] * 3) * 2
    assert len(lines) == len(rows) * PEOPLE.count**2


def test_an_axis_is_told_tested_and_shown(tmp_path: Path, tone_model: Path) -> None:
    noisy = Camera(sensor=Sensor(200.0), name="noisy")
    conditions = (
        Condition(1, FRONTAL, "none", 8.0, varied={"camera": "plain"}),
        Condition(
            2, FRONTAL, "none", 8.0, camera=noisy, varied={"camera": "noisy"}, rival=(1, 8.0)
        ),
    )
    folder = run(tmp_path, tone_model, conditions=conditions, methods=("base",), details=False)
    results = json.loads((folder / "results.json").read_text())
    assert [(row["setting"], row["camera"]) for row in results["rows"]] == [
        ("camera plain", "reference"),
        ("camera noisy", "noisy"),
    ]
    (test,) = results["comparisons"]
    areas = [row["auc"] for row in results["rows"]]
    assert (test["option"], test["against_option"], test["method"]) == (2, 1, "base")
    assert test["difference"] == pytest.approx(areas[1] - areas[0])
    page = (folder / "report.html").read_text()
    assert "Against camera plain" in page
    assert "<h3>Camera</h3>" in page
    assert "ROC curves" not in page
    assert not [*folder.glob("faces_*.png")]
    sheet = cv2.imread(str(folder / "conditions.png"))
    assert sheet is not None
    heading_px = 24 + 17  # two lines: which one, of which axis
    assert sheet.shape == (heading_px + 4 + 6 * 132, 4 + 128 + 2 * 132, 3)  # people, cameras


def test_a_share_of_the_people_is_rendered_and_nothing_else_is_done(
    tmp_path: Path, tone_model: Path
) -> None:
    folder = run(tmp_path, tone_model, methods=("base",), share=(1, 4))
    assert not folder.exists()
    made = [*(tmp_path / "cache").rglob("*.safetensors")]
    assert len(made) == 2 * (1 + 2)  # two of eight people: an enrolled picture, two probes
