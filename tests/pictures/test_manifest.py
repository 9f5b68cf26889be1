"""One row a picture; a broken manifest is named by file and line."""

import csv
from dataclasses import replace
from pathlib import Path

import pytest

from lrsr.data.manifest import COLUMNS, ManifestRow, about, read_manifest, write_manifest
from lrsr.errors import InputError
from lrsr.identities.person import Person

ROW = ManifestRow(
    file="a.png",
    identity_id="test-00000",
    kind="probe",
    pose="left",
    lighting="above, a bit",
    compression="heavy",
    camera="reference",
    ipd_px=8.0,
    scale=2,
    seed=4294967295,
    landmarks_px=tuple(float(i) + 0.125 for i in range(10)),
)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "a.png").touch()
    (tmp_path / "b.png").touch()
    return tmp_path


def rewrite(folder: Path, old: str, new: str) -> None:
    path = write_manifest(folder, [ROW, replace(ROW, file="b.png")])
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


def test_rows_come_back_as_they_were(folder: Path) -> None:
    rows = [ROW, replace(ROW, file="b.png", ipd_px=11.5, linear_file="a.png")]
    assert write_manifest(folder, rows) == folder / "manifest.csv"
    assert read_manifest(folder) == rows


def test_the_columns_are_those_that_others_rely_on() -> None:
    assert ",".join(COLUMNS[:11]) == (
        "file,identity_id,kind,pose,lighting,compression,camera,ipd_px,scale,seed,landmarks_px"
    )


def test_a_row_tells_who_it_shows(folder: Path) -> None:
    person = Person("female", 41.5, {"african": 0.25, "asian": 0.75}, 12.34, "tan")
    with write_manifest(folder, [replace(ROW, **about(person))]).open(newline="") as file:
        (row,) = csv.DictReader(file)
    assert {name: row[name] for name in COLUMNS[12:17]} == {
        "sex": "female",
        "age_years": "41.5",
        "ancestry": "african=0.25 asian=0.75",
        "ita_deg": "12.34",
        "skin_tone": "tan",
    }
    assert about(None) == {}


def test_a_manifest_of_before_there_were_expressions_is_read(folder: Path) -> None:
    smiling = replace(ROW, expression="smile", lens="single", standpoint="scface_far")
    assert read_manifest(write_manifest(folder, [smiling]).parent) == [smiling]
    rewrite(folder, ",expression,lens,standpoint\n", "\n")
    assert [row.expression for row in read_manifest(folder)] == ["neutral", "neutral"]
    assert {(row.lens, row.standpoint) for row in read_manifest(folder)} == {("pinhole", "level")}


def test_any_csv_reader_reads_it(folder: Path) -> None:
    with write_manifest(folder, [ROW]).open(newline="") as file:
        (row,) = csv.DictReader(file)
    assert row["file"] == "a.png"
    assert row["lighting"] == "above, a bit"
    assert row["ipd_px"] == "8"
    assert [float(x) for x in row["landmarks_px"].split()] == list(ROW.landmarks_px)


def test_the_order_of_the_columns_and_further_ones_do_not_matter(folder: Path) -> None:
    path = write_manifest(folder, [ROW])
    names, values = list(csv.reader(path.read_text().splitlines()))
    with path.open("w", newline="") as file:
        csv.writer(file).writerows([[*names[::-1], "mine"], [*values[::-1], "x"]])
    assert read_manifest(folder) == [ROW]


def test_an_empty_manifest_has_no_rows(folder: Path) -> None:
    write_manifest(folder, [])
    assert read_manifest(folder) == []


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("ipd_px,scale", "ipd,scale", r"manifest\.csv, line 1: no column ipd_px"),
        ("file,", '"file"x,', r"manifest\.csv, line 1: ',' expected after '\"'"),
        ("b.png", "c.png", r"line 3: c\.png does not exist"),
        ("b.png", "../b.png", r"line 3: \.\./b\.png lies outside"),
        ("b.png", "/etc/hostname", r"line 3: /etc/hostname lies outside"),
        ("b.png", "", "line 3: no file is named"),
        (",8,2,", ",eight,2,", r"line 2: could not convert string to float: 'eight'"),
        (",8,2,", ",nan,2,", r"line 2: nan is not a finite number"),
        (",8,2,", ",8,2.5,", r"line 2: invalid literal for int"),
        ("0.1250 ", "", r"line 2: landmarks_px holds 9 numbers, wanted 10"),
        ("0.1250 ", "inf ", r"line 2: inf is not a finite number"),
        ('"above, a bit"', '"above" a bit', r"manifest\.csv, line 2: ',' expected after '\"'"),
    ],
    ids=lambda value: value[:12],
)
def test_a_broken_manifest_is_named_by_its_line(
    folder: Path, old: str, new: str, message: str
) -> None:
    rewrite(folder, old, new)
    with pytest.raises(InputError, match=message) as caught:
        read_manifest(folder)
    assert "\n" not in str(caught.value)


def test_pictures_need_not_be_there_if_nobody_looks(folder: Path) -> None:
    rewrite(folder, "b.png", "c.png")
    assert [row.file for row in read_manifest(folder, pictures=False)] == ["a.png", "c.png"]


@pytest.mark.parametrize("missing", ["folder", "manifest"])
def test_a_missing_folder_or_manifest_is_named(folder: Path, missing: str) -> None:
    place = folder / "none" if missing == "folder" else folder
    with pytest.raises(InputError, match=r"cannot read .*manifest\.csv: No such file.*lrsr render"):
        read_manifest(place)


def test_a_manifest_that_is_no_text_is_named(folder: Path) -> None:
    (folder / "manifest.csv").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match=r"cannot read .*manifest\.csv: .*utf-8"):
        read_manifest(folder)


def test_a_folder_that_cannot_be_written_is_one_line(folder: Path) -> None:
    with pytest.raises(InputError, match=r"cannot write .*a\.png/manifest\.csv"):
        write_manifest(folder / "a.png", [ROW])
