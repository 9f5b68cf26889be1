import csv
import json
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from fakes.configurations import composed
from fakes.maker import FakeMaker
from fakes.sets import write_face
from PIL import Image
from skimage.data import astronaut

from lrsr.errors import InputError
from lrsr.experiments.intake import Intake
from lrsr.experiments.reconstruction import Reconstructing
from lrsr.identities.photographs.person import Network, Photographed, read_photographed
from lrsr.identities.photographs.quality import Filters, Quality
from lrsr.identities.photographs.reconstructor import Reconstructor
from lrsr.paths import asset
from lrsr.pictures.cache import RenderCache
from lrsr.recognition.detection.detector import Detector
from lrsr.recognition.detection.portrait import portrait_faces

FACE = astronaut()[:280, 60:400]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A lab's folder with wrong pictures in it."""
    root = tmp_path_factory.mktemp("pictures")
    Image.fromarray(FACE).save(root / "a.png")
    Image.fromarray(FACE).save(root / "again.png")
    Image.fromarray(np.concatenate([FACE, FACE], axis=1)).save(root / "two.png")
    Image.fromarray(np.full((200, 200, 3), 90, np.uint8)).save(root / "none.png")
    Image.fromarray(FACE[:, :10]).save(root / "thin.png")
    Image.fromarray(FACE).resize((170, 140)).save(root / "small.png")
    (root / "broken.jpg").write_bytes(b"no picture")
    (root / "notes.txt").write_text("no picture either")
    return root


@pytest.fixture
def quickly(monkeypatch: pytest.MonkeyPatch) -> None:
    """Reconstruct with small textures."""
    whole = Photographed.reconstruction
    monkeypatch.setattr(Photographed, "reconstruction", lambda self, _: whole(self, 64))


def run(
    images: Path, out: Path, maker: FakeMaker, *, ages: Path | None = None, **settings: Any
) -> list[dict[str, str]]:
    asked = Reconstructing(images, Intake(Filters(least_ipd_px=30.0), **settings), ages)
    asked.run(out, RenderCache(out / "cache"), maker=maker, progress=False)
    with (out / "photographs.csv").open(newline="") as file:
        return list(csv.DictReader(file))


@pytest.mark.usefixtures("quickly")
def test_every_picture_is_taken_or_refused_in_one_line(folder: Path, tmp_path: Path) -> None:
    maker = FakeMaker()
    rows = {Path(row["file"]).name: row for row in run(folder, tmp_path, maker)}
    assert {name: row["filter"] for name, row in rows.items()} == {
        "a.png": "",
        "again.png": "twice",
        "two.png": "face",
        "none.png": "face",
        "thin.png": "size",
        "small.png": "size",
        "broken.jpg": "picture",
    }
    assert rows["a.png"]["taken"] == "yes"
    assert rows["two.png"]["why"].startswith("2 faces")
    assert rows["thin.png"]["why"].startswith("10 x 280 px")
    assert float(rows["a.png"]["ipd_px"]) == pytest.approx(42.6, abs=3)
    record = json.loads((tmp_path / "people.json").read_text())
    assert [Path(one["file"]).name for one in record["people"]] == ["a.png"]
    assert len(record["refused"]) == 6
    assert cv2.imread(str(tmp_path / "sheet.png")).shape[1] > 6 * 192
    assert len(maker.renders) == 4


@pytest.mark.usefixtures("quickly")
def test_a_second_call_does_nothing_again(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run(folder, tmp_path, FakeMaker())
    first = (tmp_path / "people.json").read_bytes()
    monkeypatch.setattr(Photographed, "reconstruction", None)
    maker = FakeMaker()
    run(folder, tmp_path, maker)
    assert not maker.renders
    assert (tmp_path / "people.json").read_bytes() == first


def test_who_is_no_adult_is_refused_before_the_face_is_looked_at(
    folder: Path, tmp_path: Path
) -> None:
    ages = tmp_path / "ages.csv"
    ages.write_text("file,age_years\na.png,17\nagain.png,old\ntwo.png,30\nthin.png,18\n")
    rows = {Path(row["file"]).name: row for row in run(folder, tmp_path, FakeMaker(), ages=ages)}
    assert rows["a.png"]["why"] == "17 years old: only adults are taken"
    assert "is no number" in rows["again.png"]["why"] or rows["again.png"]["filter"] == "twice"
    assert rows["none.png"]["why"] == "no age known: add a row to ages"
    assert (rows["two.png"]["filter"], rows["thin.png"]["filter"]) == ("face", "size")


@pytest.mark.parametrize(
    ("text", "says"),
    [("file\na.png\n", "no column age_years among file; add it"), (None, "cannot read")],
)
def test_ages_that_cannot_be_read_are_refused(
    folder: Path, tmp_path: Path, text: str | None, says: str
) -> None:
    ages = tmp_path / "ages.csv"
    if text is not None:
        ages.write_text(text)
    with pytest.raises(InputError, match=says):
        run(folder, tmp_path, FakeMaker(), ages=ages)


@pytest.mark.parametrize("manifest", [False, True])
def test_who_is_who_is_told_as_by_any_folder_of_photographs(tmp_path: Path, manifest: bool) -> None:
    images = tmp_path / "images"
    for place in ("alone.png", "ann/1.png", "ann/2.png", "deep/kim/1.png"):
        write_face(images / place, len(place), 96)
    names = {"alone": 1, "ann": 2, "kim": 1}
    if manifest:
        (images / "manifest.csv").write_text("file,identity_id\nann/1.png,eve\nalone.png,eve\n")
        names = {"eve": 2}
    made = images / "heads"
    write_face(made / "sheet.png", 3, 96)  # not a photograph the next time
    sources = Reconstructing(images, Intake())._sources(made)
    assert Counter(sources.values()) == names


def test_people_are_not_written_among_their_photographs() -> None:
    with pytest.raises(
        InputError, match=r"out=heads/\.\./x: wanted another folder than that of the"
    ):
        Reconstructing.from_config(composed("reconstruct", "images=x", "out=heads/../x"))


def test_a_folder_without_pictures_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="a folder with pictures in it"):
        run(tmp_path, tmp_path / "out", FakeMaker())


@pytest.mark.parametrize(
    ("setting", "says"), [("hair=wig", "hair=wig: wanted one of painted, none"),
    ("neutral=maybe", "neutral=maybe: wanted true or false"),
    ("filters.most_yaw_deg=-1", "filters.most_yaw_deg=-1.0: wanted 0 or more, or null")],
)  # fmt: skip
def test_a_wrong_setting_is_named(setting: str, says: str) -> None:
    with pytest.raises(InputError, match=says):
        Reconstructing.from_config(composed("reconstruct", "images=.", "out=x", setting))


def test_another_network_must_have_been_calibrated(tmp_path: Path) -> None:
    shipped, theirs = asset("landmarkers/face_landmark.onnx"), tmp_path / "theirs.onnx"
    theirs.write_bytes(shipped.read_bytes())
    theirs.with_suffix(".toml").write_text(shipped.with_suffix(".toml").read_text())
    config = composed("reconstruct", "images=.", "out=x", f"reconstructor={theirs}")
    with pytest.raises(InputError, match=r"theirs.npz is missing: lrsr calibrate-reconstructor"):
        Reconstructing.from_config(config)


@pytest.mark.usefixtures("quickly")
def test_people_know_which_network_found_them(folder: Path, tmp_path: Path) -> None:
    shipped, theirs = asset("landmarkers/face_landmark.onnx"), tmp_path / "theirs.onnx"
    for part in (".onnx", ".toml", ".npz"):
        theirs.with_suffix(part).write_bytes(shipped.with_suffix(part).read_bytes())
    run(folder / "a.png", tmp_path / "out", FakeMaker(), reconstructor=theirs)
    (person,) = read_photographed(tmp_path / "out")
    assert person.reconstructor == Network(str(theirs), Reconstructor(theirs).digest)


def test_the_configuration_has_every_filter() -> None:
    asked = Reconstructing.from_config(composed("reconstruct", "images=.", "out=x"))
    assert None not in vars(asked.intake.filters).values()


GOOD = Quality(60.0, 1.0, 2.0, -3.0, 1.0, 1.0, 1.5, 0.8, 40.0, 0.6, 0.1, (0.0, 0.0))


@pytest.mark.parametrize(
    ("limit", "which"),
    [
        ({"least_ipd_px": 61.0}, "size"),
        ({"most_pitch_deg": 2.0}, "frontal"),
        ({"most_glasses_edge": 39.0}, "glasses"),
        ({"most_residual_mm": 1.0}, "fit"),
        ({"least_seen": 0.7}, "fit"),
        ({"least_score": 1.1}, "face"),
    ],
)
def test_each_filter_refuses_beyond_its_limit(limit: dict[str, float], which: str) -> None:
    refusal = Filters(**limit).refusal(GOOD)
    assert refusal is not None
    assert refusal[0] == which
    assert next(iter(limit)) in refusal[1]
    assert Filters().refusal(GOOD) is None


def test_a_network_without_a_score_refuses_nobody_by_it() -> None:
    assert Filters(least_score=0.5).refusal(replace(GOOD, score=None)) is None


def test_a_picture_is_turned_as_its_exif_says_and_cmyk_is_read(tmp_path: Path) -> None:
    from lrsr.identities.photographs.picture_file import decode

    exif = Image.Exif()
    exif[0x0112] = 6  # the camera was held upright: turn by 90 degrees to the right
    turned, cmyk = tmp_path / "turned.jpg", tmp_path / "cmyk.jpg"
    Image.fromarray(np.ascontiguousarray(np.rot90(FACE))).save(turned, exif=exif, quality=95)
    Image.fromarray(FACE).convert("CMYK").save(cmyk, quality=95)
    detector = Detector()
    places = [
        portrait_faces(decode(path.read_bytes(), path.name), detector)[0].landmarks_px
        for path in (turned, cmyk)
    ]
    wanted = portrait_faces(FACE, detector)[0].landmarks_px
    for found in places:
        np.testing.assert_allclose(found, wanted, atol=3)
