import csv
import html
import io
import json
import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from fakes.painted import PaintedMaker
from fakes.twins import TwinMaker, gate
from matplotlib.image import imread

from lrsr.camera import Camera
from lrsr.errors import InputError
from lrsr.evaluation.distinctness import Distinct
from lrsr.experiments.people import Uniqueness, _answer, _gate_sentence
from lrsr.experiments.report.sheets import _GAP_PX, _LINE_PX
from lrsr.experiments.uniqueness import Findings
from lrsr.identities.gate.gate import tally
from lrsr.identities.morphable import RECIPE_VERSION
from lrsr.identities.roster import IdentityRange, _read_roster
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.sitting import Sitting
from lrsr.presets import preset
from lrsr.rendering.scene import Film, Quality, Scene

FRONTAL = Scene(preset("lighting", "frontal"))
QUALITY = Quality(samples_per_pixel=4, texture_size=64)


def enrolled(people: IdentityRange) -> Sitting:
    return Sitting(people, FRONTAL, Film(16.0), QUALITY, "gallery", seed=3)


SETTINGS = Uniqueness(
    gallery=enrolled(IdentityRange(count=7)),
    encoder="shipped",
    smallest_angle_deg=20.0,
    most_redraws=2,
    camera=Camera(),
)
TWINS = {(4, 0): 1, (6, 0): 1, (6, 1): 1, (6, 2): 1}
SIDE = 64  # px of a picture of 16 px between the pupils


def run(
    folder: Path,
    model: Path,
    maker: TwinMaker | None = None,
    cache: Path | None = None,
    **changes: Any,
) -> Path:
    return replace(SETTINGS, model=model, **changes).run(
        folder / "run",
        RenderCache(cache or folder / "cache"),
        maker=maker or TwinMaker(TWINS),
        progress=False,
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, tone_model: Path) -> Path:
    """Of a run in which person 4 was redrawn and person 6 could not be told from person 1."""
    return run(tmp_path_factory.mktemp("people"), tone_model)


def test_photographed_people_are_compared_and_not_drawn_again(
    tmp_path: Path, tone_model: Path
) -> None:
    looks = {"ann": 1, "kim": 2, "eve": 3, "mia": 2}
    told = {"file": "a.png", "five_px": [[0, 0]] * 5, "hair": "none", "expression": "neutral"}
    people = [
        told | {"who": who, "sha256": f"{look:09x}{who.encode().hex():0>55}"}
        for who, look in looks.items()
    ]
    (tmp_path / "people.json").write_text(json.dumps({"format": 2, "people": people}))
    gallery = enrolled(IdentityRange(photographs=str(tmp_path)))
    place = run(tmp_path, tone_model, PaintedMaker(), gallery=gallery)
    results = json.loads((place / "results.json").read_text())
    assert (results["people"], results["angles_deg"]["pairs"]) == (4, 6)
    nearest = results["nearest_pairs"][0]
    assert (nearest["first"], nearest["second"]) == ("kim", "mia")
    assert nearest["angle_deg"] < 1
    assert results["unresolved"] == ["mia"]
    assert not (place / "roster.json").exists()
    page = html.unescape((place / "report.html").read_text())
    assert "Nearer than 20°, so perhaps one person by two names: kim and mia." in page
    assert "drawn again" not in page


class Resumed(NamedTuple):
    folder: Path
    stopped: TwinMaker
    rest: TwinMaker


@pytest.fixture(scope="module")
def resumed(tmp_path_factory: pytest.TempPathFactory, tone_model: Path) -> Resumed:
    """The same run, stopped by Ctrl-C after three pictures and begun again."""
    place = tmp_path_factory.mktemp("resumed")
    stopped, rest = TwinMaker(TWINS, patience=3), TwinMaker(TWINS)
    with pytest.raises(KeyboardInterrupt):
        run(place, tone_model, stopped)
    assert not (place / "run").exists()
    return Resumed(run(place, tone_model, rest), stopped, rest)


@pytest.fixture(scope="module")
def results(folder: Path) -> dict[str, Any]:
    loaded: dict[str, Any] = json.loads((folder / "results.json").read_text())
    return loaded


@pytest.fixture(scope="module")
def page(folder: Path) -> str:
    return (folder / "report.html").read_text(encoding="utf-8")


def findings(angles_deg: list[float], **changes: Any) -> Findings:
    angles = np.array(angles_deg, dtype=np.float32)
    count = round((1 + math.sqrt(1 + 8 * len(angles))) / 2)
    drawn = tuple((index, 0) for index in range(count))
    nobody = Distinct((0,) * count, (), ())
    found = Findings(drawn, {}, (), angles, angles, (), nobody)
    return replace(found, **changes)


def size(path: Path) -> tuple[int, int]:
    height, width = imread(io.BytesIO(path.read_bytes())).shape[:2]
    return height, width


def sheet_size(count: int) -> tuple[int, int]:
    columns = min(count, math.ceil(math.sqrt(1.6 * count)))
    rows = math.ceil(count / columns)
    return rows * (SIDE + _LINE_PX + _GAP_PX), _GAP_PX + columns * (SIDE + _GAP_PX)


def test_a_folder_holds_everything_that_was_promised(folder: Path) -> None:
    assert {path.name for path in folder.iterdir()} == {
        "angles.png", "contact_sheet.png", "distribution.json", "distribution.png", "gallery",
        "manifest.csv", "nearest_pairs.png", "report.html", "results.json", "roster.json",
    }  # fmt: skip


def test_results_hold_pairs_angles_histogram_and_distribution(results: dict[str, Any]) -> None:
    assert results["angles_deg"]["pairs"] == sum(results["histogram"]["pairs"]) == 21
    assert results["angles_deg"]["min"] == pytest.approx(results["nearest_pairs"][0]["angle_deg"])
    assert results["distribution"]["people"] == results["people"] == 7
    assert results["config"]["seed"] == 3
    assert results["config"]["gallery"]["people"]["count"] == 7
    assert "lrsr" in results["versions"]


def test_who_was_redrawn_and_who_stays_alike_is_in_the_results(results: dict[str, Any]) -> None:
    first = results["rejected"][0]
    assert (first["who"], first["too_near_to"]) == ("test-00004", "test-00001")
    (stuck,) = results["unresolved"]
    assert stuck.startswith("test-00006")
    nearest = results["nearest_pairs"][0]
    assert (nearest["first"], nearest["second"]) == ("test-00001", stuck)


def test_the_distribution_is_that_of_the_people_left(folder: Path, results: dict[str, Any]) -> None:
    alone = json.loads((folder / "distribution.json").read_text())
    assert alone == results["distribution"]
    assert alone["sex"] == {"female": 4, "male": 3}  # by turns
    assert alone["age_years"]["youngest"] == 25.0


def test_the_roster_is_read_back(folder: Path) -> None:
    roster = _read_roster(folder / "roster.json")
    assert (roster.split, roster.start, roster.count) == ("test", 0, 7)
    assert (roster.recipe, roster.encoder, roster.angle_deg) == (RECIPE_VERSION, "shipped", 20.0)
    assert roster.draws[4] == 1
    assert roster.unresolved == (6,)


def test_whoever_uses_the_roster_meets_the_same_people(
    folder: Path, tmp_path: Path, tone_model: Path
) -> None:
    people = IdentityRange(count=5, roster=str(folder / "roster.json"))
    again = run(tmp_path, tone_model, gallery=enrolled(people), cache=folder.parent / "cache")
    told = json.loads((again / "results.json").read_text())
    assert told["rejected"] == []
    assert _read_roster(again / "roster.json").draws == {4: 1}
    for name in ("test-00003", "test-00004-draw1"):
        (picture,) = (again / "gallery").glob(f"{name}_*.png")
        assert picture.read_bytes() == (folder / "gallery" / picture.name).read_bytes()


def test_more_people_than_the_roster_are_refused(folder: Path) -> None:
    with pytest.raises(InputError, match=r"covers test 0 to 6, not 7: .* longer roster"):
        IdentityRange(count=8, roster=str(folder / "roster.json"))


def test_everybody_left_has_a_picture_in_the_manifest(folder: Path) -> None:
    rows = list(csv.DictReader((folder / "manifest.csv").read_text().splitlines()))
    names = [row["identity_id"] for row in rows]
    assert names[:5] == ["test-00000", "test-00001", "test-00002", "test-00003", "test-00004-draw1"]
    assert len(names) == 7
    for row in rows:
        assert row["kind"] == "gallery"
        assert size(folder / row["file"]) == (SIDE, SIDE)
    assert [row["sex"] for row in rows[:2]] == ["female", "male"]
    assert len(list((folder / "gallery").iterdir())) == 7  # nobody who was dismissed


def test_the_contact_sheet_has_a_place_for_everybody(folder: Path) -> None:
    assert size(folder / "contact_sheet.png") == sheet_size(7)


def test_the_contact_sheet_ends_with_the_first_people(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, tone_model: Path
) -> None:
    monkeypatch.setattr("lrsr.experiments.people._SHEET", 3)
    people = IdentityRange(count=4)
    again = run(tmp_path, tone_model, gallery=enrolled(people), cache=folder.parent / "cache")
    assert size(again / "contact_sheet.png") == sheet_size(3)
    assert len(list((again / "gallery").iterdir())) == 4


def test_the_report_loads_nothing_from_outside(page: str) -> None:
    sources = re.findall(r'(?:src|href)="([^"]*)"', page)
    assert len(sources) == 2 + 7 + 2 * 10  # figures, portraits, pairs
    assert all(re.match("data:image/(png|webp);base64,", source) for source in sources)
    assert not re.search(r"https?://|@import|url\(|<script .|<link", page)


def test_the_report_describes_every_picture(page: str) -> None:
    alts = re.findall(r'<img [^>]*alt="([^"]*)"', page)
    assert len(alts) == page.count("<img ")
    assert all(alts)


def test_the_report_shows_people_angles_and_the_dismissed(
    page: str, results: dict[str, Any]
) -> None:
    assert "<h1>7 people</h1>" in page
    for name in ("test-00000  f 25", "test-00004-draw1  f 30"):
        assert name in page
    for value in ("min", "median", "max"):
        assert f"<td>{results['angles_deg'][value]:.1f}</td>" in page
    assert '<th scope="row">test-00004</th><td>test-00001</td>' in page
    assert "smallest_angle_deg" in page


def test_the_report_answers_first(page: str) -> None:
    told = page[: page.index("<h2>")]
    assert "7 people, 21 pairs" in told
    assert "1 person could not be brought 20° away from everybody in 2 redraws" in told


def test_an_interrupted_run_renders_what_is_left(resumed: Resumed) -> None:
    assert len(resumed.stopped.rendered) == 3
    assert not set(resumed.stopped.rendered) & set(resumed.rest.rendered)


def test_an_interrupted_run_ends_as_one_that_was_not(
    folder: Path, results: dict[str, Any], resumed: Resumed
) -> None:
    for name in ("roster.json", "manifest.csv", "contact_sheet.png", "nearest_pairs.png"):
        assert (resumed.folder / name).read_bytes() == (folder / name).read_bytes()
    told = json.loads((resumed.folder / "results.json").read_text())
    assert told | {"versions": None} == results | {"versions": None}  # the commit may be another


def test_what_a_finished_run_rendered_is_not_rendered_again(
    folder: Path, tmp_path: Path, tone_model: Path
) -> None:
    idle, people = TwinMaker(patience=0), IdentityRange(count=2)
    run(tmp_path, tone_model, idle, gallery=enrolled(people), cache=folder.parent / "cache")
    assert idle.rendered == []


def test_one_person_alone_makes_a_report_without_pairs(tmp_path: Path, tone_model: Path) -> None:
    alone = run(tmp_path, tone_model, gallery=enrolled(IdentityRange(count=1)))
    text = (alone / "report.html").read_text(encoding="utf-8")
    assert "1 person, nobody to compare with." in text
    assert "There is no pair to compare." in text
    assert size(alone / "contact_sheet.png") == sheet_size(1)
    assert not (alone / "nearest_pairs.png").exists()


def test_a_missing_model_is_refused_before_rendering(tmp_path: Path) -> None:
    maker = TwinMaker()
    with pytest.raises(InputError, match=r"absent\.onnx"):
        run(tmp_path, tmp_path / "absent.onnx", maker)
    assert maker.rendered == []


def test_a_file_in_place_of_the_cache_is_named(tmp_path: Path, tone_model: Path) -> None:
    (tmp_path / "cache").write_text("in the way")
    with pytest.raises(InputError, match=r"cache folder .* is a file: choose another folder"):
        run(tmp_path, tone_model)


def test_a_folder_that_cannot_be_written_is_named(tmp_path: Path, tone_model: Path) -> None:
    (tmp_path / "run").write_text("in the way")
    with pytest.raises(InputError, match=r"cannot write .*run"):
        run(tmp_path, tone_model, gallery=enrolled(IdentityRange(count=1)))


def test_an_answer_says_that_everybody_is_far_enough_away() -> None:
    first, second = _answer(SETTINGS, findings([30.0, 40.0, 50.0]))
    assert first == (
        "3 people, 3 pairs: the nearest two are 30.0° apart, the median is 40.0° (shipped encoder)."
    )
    assert second == "Everybody is at least 20° from everybody else; nobody had to be redrawn."


@pytest.mark.parametrize(
    ("outcome", "settings", "says"),
    [
        (Distinct((0, 1, 2), (), ()), {}, "from everybody else; 2 redrawn for that."),
        (
            Distinct((0, 1, 2), (1, 2), ()),
            {"smallest_angle_deg": 11.2},
            "2 people could not be brought 11.2° away from everybody in 2 redraws; 2 redrawn.",
        ),
        (
            Distinct((0, 0, 0), (), ()),
            {"smallest_angle_deg": 0.0},
            "Nobody was redrawn, as no smallest angle was asked for.",
        ),
    ],
    ids=["redrawn", "unresolved", "not asked"],
)
def test_an_answer_says_who_was_redrawn(
    outcome: Distinct, settings: dict[str, float], says: str
) -> None:
    found = findings([30.0, 40.0, 50.0], outcome=outcome)
    assert _answer(replace(SETTINGS, **settings), found)[1].endswith(says)


@pytest.mark.parametrize(
    ("people", "redrawn", "says"),
    [
        (1, 0, "0 of 1 person had a face or hair drawn again as implausible."),
        (7, 2, "2 of 7 people had a face or hair drawn again as implausible."),
    ],
    ids=["one", "some"],
)
def test_a_sentence_says_whose_face_or_hair_was_drawn_again(
    people: int, redrawn: int, says: str
) -> None:
    assert _gate_sentence({"people": people, "redrawn": redrawn}) == says


def test_results_and_report_tell_of_the_gate(page: str, results: dict[str, Any]) -> None:
    assert results["gate"] == tally(gate(index) for index in range(7))
    assert _gate_sentence(results["gate"]) in page[: page.index("<h2>")]
    told = html.unescape(page)
    assert all(f'<th scope="row">{reason}</th>' in told for reason in results["gate"]["reasons"])
