"""Tests of lrsr/experiments/scface_study.py, on a made-up copy and painted people."""

import csv
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from fakes.configurations import composed
from fakes.painted import PaintedMaker
from fakes.reconstructions import pretended
from fakes.sets import write_scface

from lrsr.errors import InputError
from lrsr.experiments.scface_study import SCFaceStudy
from lrsr.pictures.cache import RenderCache

WORDS = (
    *("experiment=scface", "identities.count=8", "bootstrap=0", "methods=[base,bicubic2,srcnn2]"),
    *("rendering.samples_per_pixel=4", "rendering.texture_size=64", "recognition.landmarks=shared"),
)
ONE = ("scface.cameras=[1]", "recreations=[scface_cam1]", "ipd_px=13")
SIDES = ("scface.development=[3,6]", "scface.evaluation=[7,10]")


def study(*words: str) -> SCFaceStudy:
    return SCFaceStudy.from_config(composed("eval", *WORDS, *words))


def run(folder: Path, model: Path, *words: str) -> tuple[dict[str, Any], str]:
    asked = study(f"recognition.model={model}", *words)
    cache = RenderCache(folder / "cache")
    place = asked.run(folder, cache, maker=PaintedMaker(), progress=False)
    return json.loads((place / "results.json").read_text()), (place / "report.html").read_text()


@pytest.fixture(scope="module")
def both(
    tmp_path_factory: pytest.TempPathFactory, tone_model: Path, no_figures: None
) -> tuple[dict[str, Any], str]:
    """Run it with a copy of ten people, enrolled by their original mugshots."""
    folder = tmp_path_factory.mktemp("both")
    root = write_scface(folder / "set", range(1, 11))
    words = (f"scface.root={root}", "scface.mugshots=[original]", *ONE, *SIDES)
    with pretended(glasses="003_frontal"):
        found = run(folder, tone_model, *words)
    with (folder / "heads" / "photographs.csv").open(newline="") as file:
        found[0]["photographs"] = list(csv.DictReader(file))
    return found


REAL = "SCface cam1, 4.2 m, original mugshots"
SYN = "SCFace Syn scface_cam1, original mugshots"
MADE = "Recreated scface_cam1"


def test_real_and_recreated_cameras_have_the_same_rows(both: tuple[dict[str, Any], str]) -> None:
    rows = both[0]["rows"]
    assert [row["setting"] for row in rows] == [REAL] * 3 + [SYN] * 3 + [MADE] * 3
    assert [row["option"] for row in rows[::3]] == [1, 2, 3]
    assert [row["n_genuine"] for row in rows[::3]] == [10, 9, 8]
    assert [row["n_impostor"] for row in rows[::3]] == [90, 9 * 9, 56]
    assert [row["ipd_px"] for row in rows[::3]] == [10, 13, 13]  # annotated, and asked for
    assert [row["psnr_y_db"] is None for row in rows[1::3]] == [True, False, False]
    assert [row["camera"] for row in rows[::3]] == ["", "scface_cam1", "scface_cam1"]
    tests = both[0]["comparisons"]
    assert [test["setting"] for test in tests] == [REAL] * 3 + [SYN] * 3 + [MADE] * 3


def test_who_cannot_become_a_head_is_counted_and_told(both: tuple[dict[str, Any], str]) -> None:
    results, page = both
    count = "10 photographs: 9 reconstructed, 1 refused, glasses 1"
    assert count in page
    assert results["config"]["heads"]["mugshots"] == count
    assert results["config"]["heads"]["filters"]["most_glasses_edge"] == 70
    refused = {one["who"]: one["filter"] for one in results["photographs"] if one["why"]}
    assert refused == {"003": "glasses"}


def test_a_threshold_is_judged_on_the_people_that_were_named(
    both: tuple[dict[str, Any], str],
) -> None:
    found = both[0]["transfers"]
    assert len(found) == 3 * 3 * 2  # parts, methods, at EER and at an FMR
    for record in found:
        probes = 3 if record["setting"] == SYN else 4  # person 3 is no head, but enrolled
        assert record["n_genuine"] == 4
        assert record["development_impostor"] == probes * 3
        assert record["n_impostor"] == 4 * 3
        assert record["hter"] == pytest.approx((record["far"] + record["frr"]) / 2)


def test_what_each_part_was_is_recorded(both: tuple[dict[str, Any], str]) -> None:
    told = both[0]["config"]["parts"]
    assert [part["name"] for part in told.values()] == [REAL, SYN, MADE]
    assert told["1"] == {
        "name": REAL,
        "probe_pictures": 10,
        "gallery_pictures": 10,
        "development_people": 4,
        "evaluation_people": 4,
    }
    assert told["2"] == {key: told["1"][key] for key in told["1"] if key != "probe_pictures"} | {
        "name": SYN
    }


def test_the_report_tells_of_both_and_shows_no_face_of_the_set(
    both: tuple[dict[str, Any], str],
) -> None:
    results, page = both
    for words in (REAL, MADE, "A threshold set on other people", "Kendall", SYN):
        assert words in page
    assert page.count("<h3>Faces</h3>") == 1
    assert [one["recreated"] for one in results["agreements"]] == [SYN, MADE]
    assert "scface.org" not in page


def test_without_a_copy_it_says_where_to_ask_and_does_the_rest(
    tmp_path: Path, tone_model: Path, no_figures: None, caplog: pytest.LogCaptureFixture
) -> None:
    results, page = run(tmp_path, tone_model, *ONE, "methods=[base]")
    assert [row["setting"] for row in results["rows"]] == [MADE]
    assert "ask for SCface at scface.org, then give scface.root=DIR" in caplog.text
    assert "ask for SCface at scface.org" in page
    assert "agreements" not in results


def test_heads_can_be_left_out_and_a_single_one_is_too_few(tmp_path: Path) -> None:
    root = write_scface(tmp_path / "set", [1, 2])
    asked = study(f"scface.root={root}", "scface.mugshots=[original]", *ONE, "heads=null")
    assert [part.name for part in asked.parts()] == [REAL, MADE]
    assert asked.sentences()[1][0] == "SCFace Syn, heads made from the mugshots: heads=null."
    alone = ({"filter": "", "why": ""}, {"filter": "face", "why": "no face found"})
    told = replace(study(f"scface.root={root}", *ONE), looked=alone).sentences()[1][0]
    assert "too few of them could be made, of 2 photographs: 1 reconstructed, 1 refused" in told


def test_cropped_mugshots_have_no_true_landmarks(tmp_path: Path, tone_model: Path) -> None:
    root = write_scface(tmp_path / "set", [1, 2])
    with pytest.raises(InputError, match=r"recognition\.landmarks=own"):
        run(tmp_path, tone_model, f"scface.root={root}")
    assert not (tmp_path / "cache").exists()


def test_several_options_are_told_apart_by_their_light() -> None:
    parts = study("options=[1,2]").parts()
    assert [part.name for part in parts[1:3]] == [
        "Recreated scface_cam1, pose frontal, light above, compression none",
        "Recreated scface_cam3, pose frontal, light frontal, compression none",
    ]
    assert [part.design.camera.name[-1] for part in parts] == ["1", "1", "3", "3"]
    (condition,) = parts[3].design.conditions
    assert (condition.option, condition.ipd_px) == (4, 9)
    assert condition.scene is not None
    assert condition.scene.standpoint.distance_m == 4.2


def test_half_of_the_synthetic_people_set_the_threshold() -> None:
    part = study("identities.count=9").parts()[0]
    assert (len(part.development), len(part.evaluation)) == (4, 5)
    assert not part.development & part.evaluation


@pytest.mark.parametrize(
    ("word", "message"),
    [
        ("scface.cameras=[9]", r"scface\.cameras=\[9\]: wanted some of 1, 2"),
        ("scface.cameras=[1,1]", "each once"),
        ("scface.distances=[]", r"scface\.distances=\[\]"),
        ("scface.mugshots=[left]", r"some of original, cropped"),
        ("scface.development=[1]", r"scface\.development=\[1\]"),
        ("scface.evaluation=[80,130]", r"not among scface\.development=\[44, 87\]"),
        ("recreations=[scface_cam1]", None),
        ("ipd_px=[13,9,8]", "as many sizes as recreations, 2"),
        ("gallery.folder=photos", r"gallery\.folder=photos: wanted null"),
        ("recreations=[scface_cam7]", "did you mean scface_cam"),
    ],
)
def test_wrong_settings_are_refused(word: str, message: str | None) -> None:
    if message is None:  # two sizes for one camera are two conditions of it
        assert len(study(word).parts()) == 2
        return
    with pytest.raises(InputError, match=message):
        study(word)


def row(setting: str, label: str, auc: float | None) -> dict[str, Any]:
    return {
        **{"recogniser": "shipped", "landmarks": "own", "setting": setting},
        **{"label": label, "auc": auc},
    }


def agree(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    return study("scface.root=copy").compared(rows)["agreements"]


def test_agreement_is_kendalls_tau_of_the_methods() -> None:
    labels = ("Base", "Bicubic 2", "SR 2", "SR 4")
    real = [row(REAL, label, auc) for label, auc in zip(labels, (0.5, 0.6, 0.7, 0.8), strict=True)]
    made = [row(MADE, label, auc) for label, auc in zip(labels, (0.6, 0.5, 0.8, 0.9), strict=True)]
    (found,) = agree([*real, *made, row("Recreated scface_cam3", "Base", 0.5)])
    assert (found["real"], found["recreated"], found["methods"]) == (REAL, MADE, 4)
    assert found["kendall_tau"] == pytest.approx(4 / 6)  # 5 pairs agree, 1 does not


def test_an_order_of_ties_agrees_with_nothing() -> None:
    tied = [row(name, label, 1.0) for name in (REAL, MADE) for label in "abc"]
    assert agree(tied)[0]["kendall_tau"] is None
    assert agree(tied[:2] + tied[3:5]) == []  # of two methods no order is told
