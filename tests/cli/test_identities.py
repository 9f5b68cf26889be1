"""``lrsr identities`` as a user types it, with people made of paint."""

import csv
import json
from pathlib import Path

import pytest
from fakes.dlib_parts import install_dlib, remove_dlib
from fakes.twins import TwinMaker

from lrsr.cli import main
from lrsr.identities.morphable import RECIPE_VERSION
from lrsr.identities.population import Population
from lrsr.identities.roster import Roster, write_roster

SMALL = ["encoder=shipped", "smallest_angle_deg=0", "gallery.ipd_px=16"]


@pytest.fixture(autouse=True)
def maker(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> TwinMaker:
    """Run from an empty folder, with a cache of its own, and paint in place of Mitsuba."""
    painted = TwinMaker()
    monkeypatch.setenv("LRSR_CACHE", str(tmp_path / "cache"))
    for module in ("lrsr.experiments.people", "lrsr.pictures.to_folder"):
        monkeypatch.setattr(f"{module}.MitsubaMaker", lambda: painted)
    (tmp_path / "empty").mkdir()
    monkeypatch.chdir(tmp_path / "empty")
    return painted


def names(folder: Path) -> list[str]:
    rows = csv.DictReader((folder / "manifest.csv").read_text().splitlines())
    return [row["identity_id"] for row in rows]


def last_line(capsys: pytest.CaptureFixture[str]) -> Path:
    return Path(capsys.readouterr().out.strip().splitlines()[-1])


def test_the_last_line_is_the_folder_that_holds_the_report(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["identities", "identities.count=3", *SMALL]) == 0
    folder = last_line(capsys)
    held = {path.name for path in folder.iterdir()}
    assert {"report.html", "results.json", "roster.json", "contact_sheet.png"} <= held
    assert {"config.yaml", "versions.json"} <= held
    assert json.loads((folder / "results.json").read_text())["people"] == 3


def test_a_roster_gives_the_same_people_to_every_command(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    redrawn = Roster("test", 0, 2, Population("female"), RECIPE_VERSION, "shipped", 9.0, {1: 2})
    path = write_roster(tmp_path / "roster.json", redrawn)
    people = ["identities.count=2", "identities.sex=female", f"identities.roster={path}"]
    drawn = []
    for words in (["identities", *SMALL], ["render", "out=pictures", "kind=gallery"]):
        assert main([*words, *people]) == 0
        drawn.append(names(last_line(capsys)))
    assert drawn[0] == drawn[1] == ["test-00000-female", "test-00001-female-draw2"]


def test_help_lists_the_settings(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["identities", "--help"]) == 0
    page = capsys.readouterr().out
    for setting in ("encoder:", "smallest_angle_deg:", "most_redraws:", "roster:", "sex:"):
        assert setting in page


def test_cfg_job_prints_the_settings_and_does_nothing(
    maker: TwinMaker, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["identities", "--cfg", "job", "identities.count=9"]) == 0
    assert "count: 9" in capsys.readouterr().out
    assert list(Path.cwd().iterdir()) == []
    assert maker.rendered == []


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["encoder=facenet"], "encoder=facenet: wanted one of auto, dlib, shipped"),
        (["encoder=dlib"], "pip install 'lrsr[dlib]', or give encoder=shipped"),
        (["recognition.model=none.onnx"], "none.onnx"),
        (["recognition.landmarks=own"], "recognition.landmarks=own: wanted shared"),
        (["recognition.fallback=whole_image"], "wanted recognition.model and .device alone"),
        (["idnetities.count=3"], "idnetities"),
    ],
    ids=lambda value: value[0] if isinstance(value, list) else None,
)
def test_wrong_input_is_one_line_and_status_2(
    words: list[str],
    says: str,
    maker: TwinMaker,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    remove_dlib(monkeypatch)
    assert main(["identities", *words]) == 2
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert line.startswith("lrsr: ")
    assert says in line
    assert maker.rendered == []


def test_a_model_for_dlib_is_refused_with_the_words_to_add(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    install_dlib(monkeypatch, tmp_path / "site")
    assert main(["identities", "recognition.model=mine.onnx"]) == 2
    assert "add encoder=shipped" in capsys.readouterr().err


def test_ctrl_c_is_status_130_and_the_same_words_go_on(
    maker: TwinMaker, capsys: pytest.CaptureFixture[str]
) -> None:
    maker.patience, words = 1, ["identities", "identities.count=2", *SMALL]
    assert main(words) == 130
    assert "run the same command again" in capsys.readouterr().err
    maker.patience = None
    assert main(words) == 0
    assert maker.rendered == ["test-00000", "test-00001"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["pose=left"], "lrsr: pose: only export=DIR reads it; leave it"),
        (
            ["rendering.samples_per_pixel=8"],
            "lrsr: rendering.samples_per_pixel: enrolled pictures have gallery.samples_per_pixel; "
            "give that",
        ),
        (["another_day.cap=1"], "lrsr: another_day.cap: only export=DIR reads it; leave it"),
        (["export=x", "encoder=dlib"], "lrsr: encoder: export=DIR does not read it; leave it"),
        (["export=x", "lens=single"], "lrsr: lens=single: depth and normals are those of"),
        (["export=x", "another_day.cap=2"], "lrsr: another_day.cap=2: wanted 0 to 1"),
        (["export=x", "another_day=hat"], "lrsr: another_day=hat: no such option"),
    ],
)
def test_what_would_not_be_read_or_cannot_be_exported_is_refused_in_one_line(
    words: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["identities", "identities.count=2", *words]) == 2
    lines = capsys.readouterr().err.strip().splitlines()
    assert lines[-1].startswith(message)
