"""Photographs of one's own, here painted ones: rates where people are known, candidates always."""

import csv
import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from fakes.configurations import composed
from fakes.painted import PaintedMaker

from lrsr.camera import Camera
from lrsr.errors import InputError
from lrsr.evaluation.delong import estimate_auc
from lrsr.experiments.conditions import Condition
from lrsr.experiments.own import Own
from lrsr.identities.roster import IdentityRange
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.folder import read_manifest, write_manifest
from lrsr.pictures.image_files import write_png
from lrsr.pictures.sitting import Sitting
from lrsr.pictures.to_folder import RenderSettings, render_to_folder
from lrsr.presets import preset
from lrsr.recognition.settings import RecognitionSettings
from lrsr.rendering.scene import Film, Quality, Scene

PEOPLE, QUALITY = IdentityRange(count=6), Quality(samples_per_pixel=4, texture_size=64)
FRONTAL = Scene(preset("lighting", "frontal"))


@pytest.fixture
def folders(tmp_path: Path) -> dict[str, Path]:
    """Painted probes and enrolled pictures, with their true landmarks."""
    found = {}
    for kind, ipd_px in (("probe", 8.0), ("gallery", 16.0)):
        sitting = Sitting(PEOPLE, FRONTAL, Film(ipd_px), QUALITY, kind, 5)  # type: ignore[arg-type]  # a kind
        settings = RenderSettings(tmp_path / kind, sitting, Camera())
        cache = RenderCache(tmp_path / "cache")
        render_to_folder(settings, cache, progress=False, maker=PaintedMaker())
        found[kind] = settings.out
    return found


@pytest.fixture
def asked(folders: dict[str, Path], tone_model: Path) -> Own:
    return Own(
        name="own",
        question="Who is it?",
        conditions=(Condition(1, None, "", 8.0),),
        upscalers={name: preset("sr", name) for name in ("base", "bicubic2")},
        people=PEOPLE,
        quality=QUALITY,
        seed=5,
        gallery=Sitting(PEOPLE, FRONTAL, Film(16.0), QUALITY, "gallery", 5),
        camera=Camera(),
        recognition=RecognitionSettings(tone_model),
        probes_folder=folders["probe"],
        gallery_folder=folders["gallery"],
        candidates=3,
    )


def run(asked: Own, tmp_path: Path) -> dict[str, Any]:
    (tmp_path / "run").mkdir(exist_ok=True)
    place = asked.run(tmp_path / "run", RenderCache(tmp_path / "cache"), progress=False)
    results: dict[str, Any] = json.loads((place / "results.json").read_text())
    return results


def scores_of(folder: Path) -> list[dict[str, str]]:
    with (folder / "run" / "scores.csv").open() as file:
        return list(csv.DictReader(file))


def renamed(folder: Path, change: Any) -> None:
    write_manifest(folder, [change(k, row) for k, row in enumerate(read_manifest(folder))])


def test_known_people_give_rates_by_the_scores_that_are_written(asked: Own, tmp_path: Path) -> None:
    results = run(asked, tmp_path)
    assert [row["method"] for row in results["rows"]] == ["base", "bicubic2"]
    lines = scores_of(tmp_path)
    for row in results["rows"]:
        own, other = (
            np.array([float(x["score"]) for x in lines
                      if (x["method"], x["mated"]) == (row["method"], mated)])
            for mated in ("1", "0")
        )  # fmt: skip
        assert (row["n_genuine"], row["n_impostor"]) == (6, 30)
        assert row["auc"] == pytest.approx(estimate_auc(own, other).auc, abs=1e-12)
    assert [test["method"] for test in results["comparisons"]] == ["bicubic2"]
    page = (tmp_path / "run" / "report.html").read_text()
    assert "Likelihood ratios</h2>" not in page  # six people are too few
    assert "Photographs, probe: 6 compared." in page


def test_candidates_are_the_most_alike_in_order(asked: Own, tmp_path: Path) -> None:
    results = run(asked, tmp_path)
    lines = [x for x in scores_of(tmp_path) if x["method"] == "base"]
    probe = lines[0]["probe"]
    best = sorted((x for x in lines if x["probe"] == probe), key=lambda x: -float(x["score"]))
    told = [x for x in results["candidates"] if (x["probe"], x["method"]) == (probe, "base")]
    assert [x["gallery"] for x in told] == [x["gallery"] for x in best[:3]]
    assert [x["rank"] for x in told] == [1, 2, 3]
    assert [x["mated"] for x in told] == [x["mated"] == "1" for x in best[:3]]


def test_unknown_people_give_candidates_and_no_rates(
    asked: Own, folders: dict[str, Path], tmp_path: Path
) -> None:
    renamed(folders["probe"], lambda k, row: replace(row, identity_id=f"unknown {k}"))
    results = run(asked, tmp_path)
    assert results["rows"] == []
    assert "likelihood_ratios" not in results
    assert "Nobody said who the photographs show" in results["unrated"]
    assert {one["mated"] for one in results["candidates"]} == {None}
    lines = scores_of(tmp_path)
    assert "mated" not in lines[0]
    assert len(lines) == 2 * 6 * 6
    page = re.sub('data:[^"]*', "", (tmp_path / "run" / "report.html").read_text())
    assert "Error rates</h2>" not in page
    assert "AUC" not in page


def test_what_is_said_of_identities_counts(asked: Own, tmp_path: Path) -> None:
    assert run(replace(asked, identified=False), tmp_path)["rows"] == []


def test_pages_call_the_condition_photographs(asked: Own, tmp_path: Path) -> None:
    rows = run(asked, tmp_path)["rows"]
    assert {(row["option"], row["setting"]) for row in rows} == {(1, "photographs")}
    page = (tmp_path / "run" / "report.html").read_text()
    assert "Photographs, IPD" in page
    assert "Option 1" not in page


def test_one_mated_pair_is_too_few_for_rates(
    asked: Own, folders: dict[str, Path], tmp_path: Path
) -> None:
    renamed(folders["probe"], lambda k, row: replace(row, identity_id=f"u{k}") if k else row)
    results = run(asked, tmp_path)
    assert results["unrated"].startswith("1 pairs of pictures show one person and 35 two")
    mated = [one for one in results["candidates"] if one["mated"]]
    first = read_manifest(folders["probe"])[0]
    told = {(one["probe"], one["identity_id"]) for one in mated}
    assert told == {(first.file, first.identity_id)}
    ranked = [(one["recogniser"], one["method"], one["landmarks"]) for one in mated]
    assert len(set(ranked)) == len(ranked) > 0


def test_broken_files_are_named_and_all_others_finished(
    asked: Own, folders: dict[str, Path], tmp_path: Path
) -> None:
    first = read_manifest(folders["probe"])[0].file
    (folders["probe"] / first).write_bytes(b"broken")
    with pytest.raises(ExceptionGroup, match="some photographs were refused") as raised:
        run(asked, tmp_path)
    (error,) = raised.value.exceptions
    assert first in str(error)
    results = json.loads((tmp_path / "run" / "results.json").read_text())
    assert results["rows"][0]["n_genuine"] == 5
    refused = [one for one in results["photographs"] if one["status"] == "refused"]
    assert [first in one["why"] for one in refused] == [True]
    assert first in (tmp_path / "run" / "report.html").read_text()


def test_a_photograph_without_a_face_is_listed_and_counted(
    asked: Own, folders: dict[str, Path], tmp_path: Path
) -> None:
    lost = read_manifest(folders["probe"])[2].file
    renamed(folders["probe"], lambda k, row: replace(row, landmarks_px=None) if k == 2 else row)
    results = run(asked, tmp_path)
    assert [row["fta"] for row in results["rows"]] == [pytest.approx(1 / 6)] * 2
    assert [one["probes"] for one in results["failures"]] == [[lost]] * 2
    assert lost not in {one["probe"] for one in results["candidates"]}
    assert f"no face on 1 probes ({lost})" in (tmp_path / "run" / "report.html").read_text()


def test_a_probe_that_is_enrolled_is_left_out(
    asked: Own, folders: dict[str, Path], tmp_path: Path
) -> None:
    rows = read_manifest(folders["probe"])
    copy = folders["gallery"] / read_manifest(folders["gallery"])[0].file
    (folders["probe"] / rows[0].file).write_bytes(copy.read_bytes())
    results = run(asked, tmp_path)
    (left,) = [one for one in results["photographs"] if one["status"] == "left out"]
    assert left["file"] == rows[0].file
    assert results["rows"][0]["n_genuine"] == 5


def test_a_second_run_finds_the_same(asked: Own, tmp_path: Path) -> None:
    one, again = run(asked, tmp_path), run(asked, tmp_path)
    assert one == again


def test_faces_are_found_where_nobody_marked_them(tmp_path: Path, asked: Own) -> None:
    plain = tmp_path / "plain"
    for k in range(2):
        write_png(plain / f"p{k}.png", torch.rand(3, 24, 24))
    both = RecognitionSettings(asked.recognition.model, landmarks=("shared", "own"))
    results = run(replace(asked, probes_folder=plain, recognition=both), tmp_path)
    assert {one["landmarks"] for one in results["failures"]} == {"own"}
    assert results["failures"][0]["probes"] == ["p0.png", "p1.png"]  # of noise
    assert "No probe has a score." in (tmp_path / "run" / "report.html").read_text()


def test_true_landmarks_that_nobody_knows_are_refused(tmp_path: Path, asked: Own) -> None:
    write_png(tmp_path / "plain" / "a.png", torch.rand(3, 24, 24))
    with pytest.raises(InputError, match=r"no picture in .*plain has landmarks_px"):
        run(replace(asked, probes_folder=tmp_path / "plain"), tmp_path)


def test_identities_that_are_said_to_be_known_must_meet(
    asked: Own, folders: dict[str, Path], tmp_path: Path
) -> None:
    renamed(folders["probe"], lambda k, row: replace(row, identity_id=f"u{k}"))
    with pytest.raises(InputError, match="identified=true: wanted false: no identity is in both"):
        run(replace(asked, identified=True), tmp_path)


def test_folders_without_anything_to_compare_are_refused(
    asked: Own, folders: dict[str, Path], tmp_path: Path
) -> None:
    renamed(folders["gallery"], lambda k, row: replace(row, kind=""))
    with pytest.raises(InputError, match=r"every photograph is in the gallery, too"):
        run(replace(asked, probes_folder=folders["gallery"], gallery_folder=folders["gallery"],
                    identified=False), tmp_path)  # fmt: skip
    (tmp_path / "bad").mkdir()
    (tmp_path / "bad" / "x.png").write_bytes(b"")
    with pytest.raises(InputError, match=r"probe\.folder=.*bad: .*x\.png is no picture"):
        run(replace(asked, probes_folder=tmp_path / "bad"), tmp_path)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ([], r"probes\.folder=null: wanted a folder of photographs: probes=DIR"),
        (["probes.folder=."], r"gallery\.folder=null: wanted a folder .*: gallery=DIR"),
        (["probes.folder={p}", "gallery.folder={g}", "candidates=0"], "candidates=0: wanted at"),
        (["probes.folder={p}", "gallery.folder={g}", "+cut.ipd=4"], "cut=ipd: wanted one of ipds"),
        (["probes.folder={p}", "gallery.folder={g}", "identified=maybe"], "true or false"),
    ],
)
def test_wrong_settings_are_refused(words: list[str], says: str, folders: dict[str, Path]) -> None:
    given = [word.format(p=folders["probe"], g=folders["gallery"]) for word in words]
    with pytest.raises(InputError, match=says):
        Own.from_config(composed("eval", "experiment=own", *given))


def test_the_configuration_is_read(folders: dict[str, Path]) -> None:
    given = [f"probes.folder={folders['probe']}", f"gallery.folder={folders['gallery']}"]
    asked = Own.from_config(composed("eval", "experiment=own", *given, "cut.ipds=4"))
    assert (asked.cut.ipds, asked.candidates, asked.identified) == (4, 5, None)
    assert asked.probes_folder == folders["probe"]
    assert list(asked.upscalers) == ["base", "bicubic4", "srcnn4"]
