"""What a score is worth in a case, with painted people in the place of rendered ones."""

import csv
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from fakes.configurations import composed
from fakes.painted import PaintedMaker
from omegaconf import OmegaConf

from lrsr.errors import InputError
from lrsr.evaluation.likelihood import split_people
from lrsr.evaluation.ratio import ratio_of
from lrsr.evaluation.score_files.reading import read_scores
from lrsr.experiments import case as module
from lrsr.experiments.case import Case
from lrsr.experiments.weighing import CASE, REAL
from lrsr.paths import config_folder
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.image_files import write_png

SMALL = ["identities.count=24", "gallery.ipd_px=16", "rendering.texture_size=64", "bootstrap=10"]


def asked(tone_model: Path, *words: str) -> Case:
    given = [f"recognition.recognisers=[{tone_model}]", "recognition.landmarks=shared", *words]
    return Case.from_config(composed("eval", "experiment=case", *SMALL, *given))


def run(case: Case, tmp_path: Path) -> dict[str, Any]:
    (tmp_path / "run").mkdir(exist_ok=True)
    cache = RenderCache(tmp_path / "cache")
    place = case.run(tmp_path / "run", cache, maker=PaintedMaker(), progress=False)
    results: dict[str, Any] = json.loads((place / "results.json").read_text())
    return results


@pytest.fixture(scope="module")
def simulated(
    tone_model: Path, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Path, dict[str, Any]]:
    """A case with a score, simulated once."""
    folder = tmp_path_factory.mktemp("case")
    return folder, run(asked(tone_model, "case.score=0.9", "ipd_px=6"), folder)


def write_scores(path: Path, people: int, signal: float, seed: int, prefix: str) -> Path:
    matrix = np.random.default_rng(seed).normal(size=(people, people)) + signal * np.eye(people)
    with path.open("w") as file:
        writer = csv.writer(file)
        writer.writerow(["probe", "gallery", "mated", "score"])
        for (i, j), score in np.ndenumerate(matrix):
            writer.writerow([f"{prefix}{i}", f"{prefix}g{j}", int(i == j), score])
    return path


def test_a_simulated_case_is_calibrated_on_one_half_and_judged_on_the_other(
    simulated: tuple[Path, dict[str, Any]],
) -> None:
    _, results = simulated
    (row,) = results["rows"]
    assert (row["n_genuine"], row["n_impostor"], row["ipd_px"]) == (24, 24 * 23, 6)
    told = {(one["calibrated_on"], one["judged_on"]): one for one in results["evidence"]}
    assert [*told] == [(CASE, CASE), ("good", CASE), ("mixed", CASE)]
    for one in told.values():
        assert (one["n_development"], one["n_test"], one["n_genuine"]) == (12, 12, 12)
        assert one["cllr_min"] == told[CASE, CASE]["cllr_min"]
    assert [one["calibrated_on"] for one in results["ratios"]] == [CASE, "good", "mixed"]


def test_the_ratio_is_that_of_the_half_that_was_calibrated_on(
    simulated: tuple[Path, dict[str, Any]],
) -> None:
    folder, results = simulated
    (system,) = read_scores([folder / "run" / "scores.csv"]).values()
    learn, _ = split_people(system.source, 0)
    wanted = ratio_of(0.9, system.source.restricted(learn))
    first = results["ratios"][0]
    assert (first["llr"], first["n_people"]) == (pytest.approx(wanted.llr, abs=1e-9), 12)
    assert first["low"] <= first["llr"] <= first["high"]


def test_the_page_says_what_it_cannot_show(simulated: tuple[Path, dict[str, Any]]) -> None:
    page = (simulated[0] / "run" / "report.html").read_text()
    assert "in this case a score of 0.900 has the likelihood ratio" in page
    assert "shows that the calibration suits the simulation" in page
    assert "somebody drawn at random from the simulated population" in page
    assert "Tippett plots, judged on this case" in page


def test_scores_from_elsewhere_need_no_pictures(tmp_path: Path) -> None:
    files = {
        name: write_scores(tmp_path / f"{name}.csv", people, signal, k, prefix)
        for k, (name, people, signal, prefix) in enumerate(
            [("case", 40, 1.5, "p"), ("generic", 40, 5.0, "p"), ("real", 30, 1.5, "r")]
        )
    }
    words = [f"case.{name}_scores={file}" for name, file in files.items() if name != "case"]
    case = Case.from_config(
        composed("eval", "experiment=case", f"case.scores={files['case']}", *words, "bootstrap=0",
                 "case.score=1.2")
    )  # fmt: skip
    results = run(case, tmp_path)
    told = {(one["calibrated_on"], one["judged_on"]): one["cllr"] for one in results["evidence"]}
    assert told["generic", CASE] > told[CASE, CASE]
    assert told["generic", REAL] > told[CASE, REAL]
    assert (REAL, REAL) in told
    assert results["rows"][0]["label"] == "case"
    assert not (tmp_path / "cache").exists()
    page = (tmp_path / "run" / "report.html").read_text()
    assert "suits the simulation" not in page  # real people were asked
    assert "judged on real people: ratios cost (Cllr)" in page


def test_a_camera_is_fitted_to_the_pictures_of_the_case(
    tone_model: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fit(settings: Any, folder: Path, *_: Any, **__: Any) -> Any:
        assert (settings.images, settings.ipd_px, settings.rounds) == (tmp_path / "images", 8.0, 3)
        assert (settings.preset["name"], settings.strangers) == ("generic", case.probes)
        assert folder == tmp_path / "camera"
        return OmegaConf.to_container(OmegaConf.load(config_folder() / "camera" / "webcam.yaml"))

    monkeypatch.setattr(module, "fit_once", fit)
    case = asked(tone_model, f"case.images={tmp_path / 'images'}", "case.rounds=3")
    simulation = case._simulation(tmp_path, RenderCache(tmp_path), None, progress=False)
    assert (simulation.camera.name, simulation.camera.compression) == ("webcam", "none")


def test_the_pair_of_the_case_gets_its_own_score(
    tone_model: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("a", "b"):
        write_png(tmp_path / f"{name}.png", torch.full((3, 40, 40), 0.5))
    words = [f"case.probe={tmp_path / 'a.png'}", f"case.enrolled={tmp_path / 'b.png'}"]
    case = replace(asked(tone_model, *words, "recognition.landmarks=both"), generic={})
    monkeypatch.setattr(module, "score_of", lambda one: 0.5)
    results = run(case, tmp_path)
    assert {(one["landmarks"], one["score"]) for one in results["ratios"]} <= {("own", 0.5)}
    assert [one["file"] for one in results["pair"]] == ["a.png", "b.png"]
    assert results["pair"][0]["ipd_px"] is None  # nobody is on it


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["identities.count=19"], "identities.count=19: wanted at least 20"),
        (["case.score=0.1", "methods=[base,bicubic2]"], r"case\.score=0\.1: wanted one recogniser"),
        (["case.score=0.1", "recognition.landmarks=both"], r"case\.score=0\.1: wanted one recogn"),
        (["case.probe=x"], r"case\.probe=\.\.\.: wanted both case\.probe and case\.enrolled"),
        (["case.probe=x", "case.enrolled=y"], "landmarks=shared: wanted own"),
        (["case.generic_scores=x"], r"case\.generic_scores=.*x: wanted case\.scores besides"),
        (["case.scores=x", "case.images=y"], r"case\.images=\.\.\.: wanted null"),
        (["gallery.folder=x"], r"gallery\.folder=x: wanted null: people are rendered"),
        (["ipd_px=3"], "ipd_px=3.0: wanted at least 4"),
        (["generic.good=[]"], r"generic\.good=\[\]: wanted at least one way"),
        (["generic.good=[{size: 3}]"], r"generic\.good\.0=size: wanted one of ipd_px"),
        (["compression=some"], "compression"),
    ],
)  # fmt: skip
def test_wrong_settings_are_refused(words: list[str], says: str, tone_model: Path) -> None:
    with pytest.raises(InputError, match=says):
        asked(tone_model, *words)


def test_a_score_of_several_systems_of_a_file_is_refused(tmp_path: Path) -> None:
    path = write_scores(tmp_path / "s.csv", 24, 1.5, 0, "p")
    lines = path.read_text().splitlines()
    body = [f"{line},{method}" for method in ("x", "y") for line in lines[1:]]
    path.write_text("\n".join([lines[0] + ",method", *body]))
    case = Case.from_config(composed("eval", "experiment=case", f"case.scores={path}"))
    with pytest.raises(InputError, match=r"case\.score=0\.3: wanted scores of one system"):
        run(replace(case, facts=replace(case.facts, score=0.3)), tmp_path)


def test_what_scores_from_elsewhere_make_needless_is_unread() -> None:
    config = composed("eval", "experiment=case")
    assert "camera" not in Case.unread(config)
    assert "conditions" in Case.unread(config)
    config.case.scores = "x"
    assert {"camera", "identities", "pose", "recognition"} <= {*Case.unread(config)}
