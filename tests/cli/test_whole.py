"""The whole line, tiny and real: render, train, enhance, evaluate, as a user would type it."""

import csv
import json
from pathlib import Path

import cv2
import pytest
from fakes.figures import draw_nothing

from lrsr.cli import main

TINY = ["rendering.samples_per_pixel=16", "rendering.texture_size=64"]


@pytest.fixture(autouse=True)
def somewhere(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    """Run from an empty folder; all tests here share one render cache."""
    shared = tmp_path_factory.getbasetemp() / "whole-cache"
    monkeypatch.setenv("LRSR_CACHE", str(shared))
    monkeypatch.chdir(tmp_path_factory.mktemp("elsewhere"))


@pytest.fixture
def _no_figures(monkeypatch: pytest.MonkeyPatch) -> None:
    draw_nothing(monkeypatch)


without_figures = pytest.mark.usefixtures("_no_figures")
"""Where a command before has drawn them."""


def last_line(capsys: pytest.CaptureFixture[str]) -> Path:
    return Path(capsys.readouterr().out.strip().splitlines()[-1])


def test_render_writes_pictures_and_manifest(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["render", "identities.count=2", "scales=[1,2]", "compression=heavy", "out=probes"]
    assert main([*words, *TINY]) == 0
    folder = last_line(capsys)
    rows = list(csv.DictReader((folder / "manifest.csv").read_text().splitlines()))
    assert [row["scale"] for row in rows].count("2") == 2
    sizes = {row["scale"]: cv2.imread(str(folder / row["file"])).shape for row in rows}
    assert sizes == {"1": (32, 32, 3), "2": (64, 64, 3)}
    assert all(len(row["landmarks_px"].split()) == 10 for row in rows)


def test_eval_writes_results_and_report(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["eval", "+debug=smoke", "options=[1,6]", "methods=[base,bicubic2,srcnn2]"]
    assert main(words) == 0
    folder = last_line(capsys)
    results = json.loads((folder / "results.json").read_text())
    assert [(row["option"], row["landmarks"], row["method"]) for row in results["rows"]] == [
        (option, landmarks, method)
        for option in (1, 6)
        for landmarks in ("shared", "own")
        for method in ("base", "bicubic2", "srcnn2")
    ]
    assert results["recognition"]["detector"]["model"] == "retinaface_mnet025.onnx"
    assert all(row["fta"] < 1 for row in results["rows"] if row["option"] == 1)
    assert {path.name for path in folder.iterdir()} == {
        "config.yaml", "versions.json", "results.json", "scores.csv", "report.html", "faces_1.png",
        "faces_2.png",
    }  # fmt: skip


@without_figures
def test_what_render_made_eval_does_not_make_again(capsys: pytest.CaptureFixture[str]) -> None:
    people, cache = ["identities.count=2", *TINY], Path("cache")
    enrolled = ["gallery.ipd_px=16", "gallery.samples_per_pixel=8"]
    scene = ["pose=left", "lighting=below", "compression=heavy"]
    for words in (
        ["render", *people, *scene, "scales=[1,2]", "out=probes"],
        ["render", *people, "kind=gallery", *enrolled, "out=gallery"],
    ):
        assert main([*words, f"paths.cache={cache}"]) == 0
    made = {path: path.stat().st_mtime_ns for path in cache.rglob("*.safetensors")}
    assert len(made) == 2 * (2 + 1)
    settings = ["methods=[base,bicubic2,srcnn2]", f"paths.cache={cache}"]
    asked = [*people, "options=[6]", *enrolled]
    rows = []
    for words in (asked, ["probes.folder=probes", "gallery.folder=gallery"]):
        assert main(["eval", *settings, *words]) == 0
        rows.append(json.loads((last_line(capsys) / "results.json").read_text())["rows"])
    assert {path: path.stat().st_mtime_ns for path in cache.rglob("*.safetensors")} == made
    of_folder = {"option": 1, "setting": "photographs", "camera": "", "skin": ""}
    assert rows[1] == [row | of_folder for row in rows[0]]


def test_identities_says_who_the_people_of_eval_are(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["identities", "+debug=smoke", "encoder=shipped", "smallest_angle_deg=0"]
    assert main(words) == 0
    folder = last_line(capsys)
    rows = list(csv.DictReader((folder / "manifest.csv").read_text().splitlines()))
    assert {row["sex"] for row in rows} <= {"female", "male"}
    assert all(25 <= float(row["age_years"]) <= 75 for row in rows)
    assert json.loads((folder / "distribution.json").read_text())["people"] == len(rows) == 3


@without_figures
def test_multirun_gives_each_value_a_folder(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["eval", "-m", "+debug=smoke", "methods=[base]", "level=0.9,0.95"]) == 0
    folders = [Path(line) for line in capsys.readouterr().out.strip().splitlines()]
    levels = [json.loads((f / "results.json").read_text())["config"]["level"] for f in folders]
    assert levels == [0.9, 0.95]


@without_figures
def test_train_leaves_weights_that_eval_would_take(capsys: pytest.CaptureFixture[str]) -> None:
    small = ["identities.count=2", "data.views=1", "data.ipd_px=8", "trainer.max_epochs=1"]
    assert main(["train", "sr=srcnn2x", *small, *TINY]) == 0
    folder = last_line(capsys)
    assert {"model.onnx", "best.ckpt", "metrics.json"} <= {path.name for path in folder.iterdir()}
    assert json.loads((folder / "metrics.json").read_text())["settings"]["identities.count"] == 2
    names = {"a": "best.ckpt", "b": "model.safetensors", "c": "model.onnx"}
    weights = [f"sr.{method}.weights={folder / name}" for method, name in names.items()]
    assert main(["eval", "+debug=smoke", "methods=[base,bicubic2,a,b,c]", *weights]) == 0
    rows = json.loads((last_line(capsys) / "results.json").read_text())["rows"]
    assert [row["method"] for row in rows] == ["base", "bicubic2", "a", "b", "c"] * 2
    psnr_db = {row["method"]: row["psnr_y_db"] for row in rows}
    assert psnr_db["a"] == psnr_db["b"] == pytest.approx(psnr_db["c"], abs=1e-3)


@pytest.mark.parametrize(
    "words",
    [
        ["train", "sr=srcnn4x", "recognition=arcface"],
        ["train", "sr=bicubic4"],
        ["train", "recognition=embedder"],
    ],
    ids=" ".join,
)
def test_train_refuses_what_cannot_be_trained(
    words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(words) == 2
    said = capsys.readouterr().err
    assert "give one of" in said or "choose one of arcface, edsr2x" in said
