"""A manifest of any program, or none, says who the pictures of a folder show."""

import csv
from dataclasses import replace
from pathlib import Path

import pytest
import torch

from lrsr.errors import InputError
from lrsr.identities.person import Traits
from lrsr.pictures.folder import (
    Entry,
    about,
    read_folder,
    read_manifest,
    read_picture,
    write_manifest,
)
from lrsr.pictures.image_files import write_png

ROW = Entry(
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
    full = replace(
        ROW,
        file="b.png",
        ipd_px=11.5,
        linear_file="a.png",
        yaw_deg=-20.0,
        samples_per_pixel=512,
        run_seed=7,
        settings='{"a": "1, 2"}',
        further={"mine": "x"},
    )
    rows = [replace(ROW, further={"mine": ""}), full, Entry("c.png", "anna", further={"mine": "y"})]
    (folder / "c.png").touch()
    assert write_manifest(folder, rows) == folder / "manifest.csv"
    assert read_manifest(folder) == rows


def columns(folder: Path) -> list[str]:
    return write_manifest(folder, [ROW]).read_text().splitlines()[0].split(",")


def test_the_columns_are_those_that_others_rely_on(folder: Path) -> None:
    assert ",".join(columns(folder)[:11]) == (
        "file,identity_id,kind,pose,lighting,compression,camera,ipd_px,scale,seed,landmarks_px"
    )


def test_a_row_tells_who_it_shows(folder: Path) -> None:
    traits = Traits("female", 41.5, {"african": 0.25, "asian": 0.75}, 12.34, "tan")
    with write_manifest(folder, [replace(ROW, **about(traits))]).open(newline="") as file:
        (row,) = csv.DictReader(file)
    assert {name: row[name] for name in columns(folder)[12:17]} == {
        "sex": "female",
        "age_years": "41.5",
        "ancestry": "african=0.25 asian=0.75",
        "ita_deg": "12.34",
        "skin_tone": "tan",
    }
    assert about(None) == {}


def test_a_manifest_of_lrsr_0_1_is_read(folder: Path) -> None:
    old = columns(folder)[:20]
    assert old[-4:] == ["skin_tone", "expression", "lens", "standpoint"]
    points = " ".join(["1.5"] * 10)
    row = f"a.png,test-00000,probe,left,side,none,reference,8,1,7,{points},,,,,,,smile,single,level"
    (folder / "manifest.csv").write_text(",".join(old) + f"\n{row}\n")
    (entry,) = read_manifest(folder)
    assert (entry.expression, entry.lens, entry.standpoint) == ("smile", "single", "level")
    assert (entry.yaw_deg, entry.run_seed, entry.skin, entry.further) == (None, None, "", {})


@pytest.mark.parametrize(
    "text",
    [
        "file,identity_id\na.png,anna\nb.png,ben\n",
        "\ufefffile,identity_id\na.png,anna\nb.png,ben\n",
        "file,identity_id\r\na.png,anna\r\nb.png,ben\r\n",
        "file,identity_id\ra.png,anna\rb.png,ben\r",
        "file;identity_id\na.png;anna\nb.png;ben\n",
        "file\tidentity_id\na.png\tanna\nb.png\tben",
        "identity_id,file\nanna,a.png\nben,b.png\n",
        ' file , identity_id \n a.png , anna \n"b.png",ben\n',
        "\nfile,identity_id\n\na.png,anna\nb.png,ben\n\n\n",
        "file,identity_id,kind\na.png,anna,\nb.png,ben\n,,\n , ,\n",
        "file,identity_id,scale,seed,landmarks_px,ipd_px\na.png,anna,,,,\nb.png,ben,1.0,,,\n",
    ],
    ids=[
        "plain",
        "mark of the byte order",
        "ends of Windows",
        "ends of old Macs",
        "semicolons",
        "tabs and no last end",
        "another order",
        "blanks and quotes",
        "blank lines",
        "rows of nothing and short ones",
        "empty cells",
    ],
)
def test_any_table_with_files_and_people_is_a_manifest(folder: Path, text: str) -> None:
    (folder / "manifest.csv").write_bytes(text.encode())
    assert (
        read_manifest(folder)
        == read_folder(folder)
        == [
            Entry("a.png", "anna"),
            Entry("b.png", "ben"),
        ]
    )


@pytest.mark.parametrize("code", ["utf-8", "utf-8-sig", "utf-16"])
def test_a_manifest_in_any_unicode_is_read(folder: Path, code: str) -> None:
    (folder / "manifest.csv").write_bytes("file;identity_id\na.png;Müßig 北\n".encode(code))
    assert read_manifest(folder) == [Entry("a.png", "Müßig 北")]


@pytest.mark.parametrize("code", ["latin-1", "cp1252", "utf-16-be"])
def test_letters_that_would_have_to_be_guessed_are_refused(folder: Path, code: str) -> None:
    (folder / "manifest.csv").write_bytes("file,identity_id\na.png,Müßig\n".encode(code))
    with pytest.raises(InputError, match=r"save it as UTF-8|no column file"):
        read_manifest(folder)


def test_a_cell_in_quotes_may_hold_separators_and_ends_of_lines(folder: Path) -> None:
    text = 'file,identity_id,note\na.png,"Doe, Anna","says ""hi""\nand goes"\nb.png,ben,\n'
    (folder / "manifest.csv").write_text(text)
    first, second = read_manifest(folder)
    assert first.identity_id == "Doe, Anna"
    assert first.further == {"note": 'says "hi"\nand goes'}
    assert (second.identity_id, second.further) == ("ben", {"note": ""})


def test_what_is_not_ours_is_kept_when_a_manifest_is_written_again(folder: Path) -> None:
    (folder / "manifest.csv").write_text("mine,file,identity_id\n 1 ,a.png,anna\n,b.png,ben\n")
    entries = read_manifest(folder)
    write_manifest(folder, [*entries, replace(ROW, file="c.png")])
    again = read_manifest(folder, pictures=False)
    assert again[:2] == entries
    assert [entry.further for entry in again] == [{"mine": " 1 "}, {"mine": ""}, {"mine": ""}]


def test_paths_of_windows_are_paths(folder: Path) -> None:
    (folder / "anna").mkdir()
    (folder / "anna" / "1.png").touch()
    (folder / "manifest.csv").write_text("file,identity_id\nanna\\1.png,anna\n")
    assert [entry.file for entry in read_manifest(folder)] == ["anna/1.png"]


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
    assert read_manifest(folder) == [replace(ROW, further={"mine": "x"})]


def test_an_empty_manifest_has_no_rows(folder: Path) -> None:
    write_manifest(folder, [])
    assert read_manifest(folder) == []


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("identity_id,", "who,", r"manifest\.csv, line 1: no column identity_id among file, who, "),
        ("file,", "path,", r"manifest\.csv, line 1: no column file among path, "),
        ("file,", '"file"x,', r"manifest\.csv, line 1: ',' expected after '\"'"),
        ("b.png", "c.png", r"line 3: c\.png does not exist"),
        ("b.png", "b\0.png", r"line 3: .* is no name of a file; mend it"),
        ("b.png", "../b.png", r"line 3: \.\./b\.png lies outside"),
        ("b.png", "/etc/hostname", r"line 3: /etc/hostname lies outside"),
        ("b.png", "..\\b.png", r"line 3: \.\./b\.png lies outside"),
        ("b.png", "", "line 3: file is empty; fill it in"),
        ("b.png,test-00000", "b.png,", "line 3: identity_id is empty; fill it in"),
        ("b.png", "a.png", r"line 3: a\.png is named twice"),
        ("b.png", "./a.png", r"line 3: a\.png is named twice"),
        (",8,2,", ",eight,2,", r"line 2: ipd_px=eight: eight is no number such as 8\.5"),
        (",8,2,", ",nan,2,", r"line 2: ipd_px=nan: nan is no number"),
        (",8,2,", ',"8,5",2,', r"line 2: ipd_px=8,5: 8,5 is no number such as 8\.5"),
        ("kind,pose", "kind,kind", r"line 1: 2 columns kind; rename one"),
        (",8,2,", ",8,2.5,", r"line 2: scale=2\.5: wanted a whole number"),
        (",8,2,", ",8,0,", r"line 2: scale=0: wanted a number >= 1"),
        ("0.125 ", "", r"line 2: landmarks_px=[0-9. ]*: 9 numbers, wanted 10"),
        ("0.125 ", "inf ", r"line 2: landmarks_px=.*: inf is no number"),
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


def test_text_that_was_not_quoted_is_noticed(folder: Path) -> None:
    (folder / "manifest.csv").write_text("file,identity_id\na.png,Doe, Anna\n")
    with pytest.raises(InputError, match=r'line 2: 3 cells for 2 columns; put text .* "quotes"'):
        read_manifest(folder)


def test_pictures_need_not_be_there_if_nobody_looks(folder: Path) -> None:
    rewrite(folder, "b.png", "c.png")
    assert [row.file for row in read_manifest(folder, pictures=False)] == ["a.png", "c.png"]


def test_a_folder_of_folders_has_a_person_in_each(tmp_path: Path) -> None:
    for name in ("ben/2.JPG", "ben/1.png", "anna/x.webp", "anna/deeper/y.png", "loose.tif"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    assert [(entry.file, entry.identity_id) for entry in read_folder(tmp_path)] == [
        ("anna/x.webp", "anna"),
        ("ben/1.png", "ben"),
        ("ben/2.JPG", "ben"),
        ("loose.tif", "loose"),
    ]


def test_what_is_hidden_or_no_picture_is_passed_over(tmp_path: Path) -> None:
    hidden = (".thumb.png", ".cache/a.png", "anna/._1.png", "notes.txt", "anna/Thumbs.db", "README")
    for name in (*hidden, "anna/1.png"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    (tmp_path / "album.png").mkdir()
    assert read_folder(tmp_path) == [Entry("anna/1.png", "anna")]


def test_a_hidden_folder_can_be_asked_for(tmp_path: Path) -> None:
    (tmp_path / ".mine").mkdir()
    (tmp_path / ".mine" / "anna.png").touch()
    assert read_folder(tmp_path / ".mine") == [Entry("anna.png", "anna")]


@pytest.mark.parametrize("manifest", [None, "file,identity_id\n"], ids=["none", "empty"])
def test_a_folder_without_pictures_is_refused(tmp_path: Path, manifest: str | None) -> None:
    (tmp_path / "notes.txt").touch()
    if manifest is not None:
        (tmp_path / "manifest.csv").write_text(manifest)
    with pytest.raises(InputError, match=r"holds no pictures: put files in it \(png, jpg"):
        read_folder(tmp_path)


def test_what_is_no_folder_is_refused(folder: Path) -> None:
    for place in (folder / "a.png", folder / "none"):
        with pytest.raises(InputError, match=f"{place.name} is no folder: give one"):
            read_folder(place)


def test_a_picture_says_who_it_shows_and_where_the_face_is(tmp_path: Path) -> None:
    image = torch.rand(3, 8, 6, generator=torch.Generator().manual_seed(0)).mul(255).round() / 255
    write_png(tmp_path / "a.png", image)
    picture = read_picture(tmp_path, ROW)
    assert torch.allclose(picture.image, image, atol=1e-6)
    assert (picture.identity_id, picture.scale, picture.traits) == ("test-00000", 2, None)
    assert picture.source == str(tmp_path / "a.png")
    assert picture.landmarks_px is not None
    assert picture.landmarks_px.flatten().tolist() == list(ROW.landmarks_px or ())
    assert read_picture(tmp_path, replace(ROW, landmarks_px=None)).landmarks_px is None


def test_no_digit_is_lost_on_the_way(tmp_path: Path) -> None:
    points = torch.rand(5, 2, generator=torch.Generator().manual_seed(1)) * 100
    numbers = tuple(points.flatten().tolist())
    row = replace(ROW, landmarks_px=numbers, ipd_px=8.123456789, yaw_deg=-1e-7, pitch_deg=20.0)
    write_png(tmp_path / row.file, torch.zeros(3, 4, 4))
    write_manifest(tmp_path, [row])
    (read,) = read_manifest(tmp_path)
    assert (read.ipd_px, read.yaw_deg, read.pitch_deg) == (8.123456789, -1e-7, 20.0)
    found = read_picture(tmp_path, read).landmarks_px
    assert found is not None
    assert torch.equal(found, points)


def test_a_file_that_is_no_picture_is_named(folder: Path) -> None:
    with pytest.raises(InputError, match=r"a\.png is no picture"):
        read_picture(folder, ROW)


@pytest.mark.parametrize("missing", ["folder", "manifest"])
def test_a_missing_folder_or_manifest_is_named(folder: Path, missing: str) -> None:
    place = folder / "none" if missing == "folder" else folder
    with pytest.raises(InputError, match=r"cannot read .*manifest\.csv: No such file.*lrsr render"):
        read_manifest(place)


def test_a_manifest_that_is_no_text_is_named(folder: Path) -> None:
    (folder / "manifest.csv").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match=r"cannot read .*manifest\.csv: .*; save it as UTF-8"):
        read_manifest(folder)


def test_a_folder_that_cannot_be_written_is_one_line(folder: Path) -> None:
    with pytest.raises(InputError, match=r"cannot write .*a\.png/manifest\.csv"):
        write_manifest(folder / "a.png", [ROW])


def test_a_picture_is_the_first_frame_unless_a_column_says_otherwise(folder: Path) -> None:
    write_manifest(folder, [ROW])
    assert [entry.frame for entry in read_manifest(folder)] == [0]
    rows = "file,identity_id,frame\na.png,anna,1\nb.png,anna,-1\n"
    (folder / "manifest.csv").write_text(rows.replace("-1", "2"))
    assert [entry.frame for entry in read_manifest(folder)] == [1, 2]
    (folder / "manifest.csv").write_text(rows)
    with pytest.raises(InputError, match="line 3: frame=-1: wanted a number >= 0"):
        read_manifest(folder)
