"""Tests of lrsr/pictures/janus.py, on a made-up copy."""

from pathlib import Path

import numpy as np
import pytest
from fakes.sets import tones, write_ijb, write_picture, write_table

from lrsr.errors import InputError
from lrsr.pictures.janus import JanusSet


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_ijb(tmp_path_factory.mktemp("ijb"))


def copy_of(root: Path, path: str = "{filename}", *, margin: float = 0) -> JanusSet:
    return JanusSet(root, path, margin)


def one_row(root: Path, **changed: object) -> Path:
    """Write a list of one face, and return its folder."""
    write_picture(root / "a.png", np.zeros((8, 10, 3), np.uint8))
    box = {"FACE_X": 2, "FACE_Y": 1, "FACE_WIDTH": 4, "FACE_HEIGHT": 6}
    row = {"TEMPLATE_ID": 1, "SUBJECT_ID": 5, "FILENAME": "a.png", **box, **changed}
    write_table(root / "list.csv", [{key: value for key, value in row.items() if value != "-"}])
    return root


def test_rows_of_a_template_are_one_and_those_of_a_sighting_one_medium(root: Path) -> None:
    faces, templates = copy_of(root).read(Path("protocols/probe.csv"), "probe")
    assert [*zip(faces.identity_ids, templates.of, templates.media or (), strict=True)][:4] == [
        ("1", "101", "10"),
        ("2", "102", "20"),
        ("3", "103", "30"),
        ("4", "104", "40"),
    ]
    assert templates.of.count("101") == 3
    assert (templates.media or ()).count("501") == 2


def test_a_face_is_cut_along_its_box(root: Path) -> None:
    faces, templates = copy_of(root).read(Path("protocols/probe.csv"), "probe")
    second = [k for k, who in enumerate(templates.of) if who == "102"][1]
    (picture,) = faces.load(second, second + 1)
    wanted = tones(2, 20, seed=9)[..., ::-1].transpose(2, 0, 1)
    np.testing.assert_array_equal(np.rint(255 * picture.image.numpy()), wanted)
    assert picture.landmarks_px is None


@pytest.mark.parametrize(("separator", "encoding"), [(";", "utf-16"), ("\t", "utf-8-sig")])
def test_a_list_may_have_been_saved_by_any_program(
    tmp_path: Path, separator: str, encoding: str
) -> None:
    path = one_row(tmp_path) / "list.csv"
    plain = copy_of(tmp_path).read(path, "probe")
    path.write_bytes(path.read_text().replace(",", separator).encode(encoding))
    assert copy_of(tmp_path).read(path, "probe") == plain


def test_two_columns_of_one_name_are_refused(tmp_path: Path) -> None:
    path = one_row(tmp_path, SIGHTING_ID=7) / "list.csv"
    path.write_text(path.read_text().replace("SIGHTING_ID", "subject_id"))
    with pytest.raises(InputError, match="line 1: 2 columns subject_id; rename one"):
        copy_of(tmp_path).read(path, "probe")


@pytest.mark.parametrize(
    ("margin", "size"), [(0.0, (6, 4)), (0.25, (8, 8)), (9.0, (8, 10))], ids=str
)
def test_a_margin_is_of_the_longer_side_and_ends_at_the_edge(
    tmp_path: Path, margin: float, size: tuple[int, int]
) -> None:
    faces, _ = copy_of(one_row(tmp_path), margin=margin).read(Path("list.csv"), "probe")
    assert tuple(faces.load(0, 1)[0].image.shape[1:]) == size  # 0.5 to 7.5 across at 0.25


def test_columns_have_any_order_and_case_and_the_names_of_other_sets(tmp_path: Path) -> None:
    write_picture(tmp_path / "v/9_3.png", np.zeros((8, 8, 3), np.uint8))
    row = {"Frame_Num": 3, "File": "x.mp4", "VIDEO_FILENAME": 9, "Subject_id": 5, "template_ID": 1}
    write_table(tmp_path / "list.csv", [row])
    faces, templates = copy_of(tmp_path, "v/{video}_{frame}.png").read(Path("list.csv"), "probe")
    assert (faces.names, faces.identity_ids, templates.of) == (["v/9_3.png"], ["5"], ["1"])
    assert tuple(faces.load(0, 1)[0].image.shape[1:]) == (8, 8)  # there is no box


def test_frames_are_thinned_within_each_medium(root: Path) -> None:
    copy = JanusSet(root, "{filename}", 0.0, frames=1)
    faces, templates = copy.read(Path("protocols/probe.csv"), "probe")
    assert len(faces.entries) == len({*zip(templates.of, templates.media or (), strict=True)}) == 8


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"SUBJECT_ID": ""}, r"list\.csv, line 2: no subject_id among"),
        ({"TEMPLATE_ID": "-"}, "no template_id among subject_id"),
        ({"FILENAME": "b.png"}, r"1 of 1 pictures are not in .*, such as b\.png"),
        ({"FILENAME": "../a.png"}, "leads out of"),
        ({"FACE_WIDTH": 0}, "holds no face"),
        ({"FACE_X": "left"}, "could not convert"),
        ({"FACE_X": "nan"}, "holds no face"),
    ],
    ids=["nobody", "no template", "missing", "outside", "empty box", "words", "nan"],
)
def test_a_row_that_cannot_be_used_is_refused(
    tmp_path: Path, changed: dict[str, object], told: str
) -> None:
    with pytest.raises(InputError, match=told):
        copy_of(one_row(tmp_path, **changed)).read(Path("list.csv"), "probe")


def test_a_box_outside_its_picture_is_refused(tmp_path: Path) -> None:
    faces, _ = copy_of(one_row(tmp_path, FACE_X=40)).read(Path("list.csv"), "probe")
    with pytest.raises(InputError, match=r"has 10 x 8 px: the box \(40"):
        faces.load(0, 1)


def test_a_template_of_two_people_is_refused(tmp_path: Path) -> None:
    rows: list[dict[str, object]] = [
        {"TEMPLATE_ID": 1, "SUBJECT_ID": who, "FILENAME": "a.png"} for who in (5, 6)
    ]
    write_table(tmp_path / "list.csv", rows)
    with pytest.raises(InputError, match="line 3: template 1 shows 6, and before 5"):
        copy_of(tmp_path).read(Path("list.csv"), "probe")


@pytest.mark.parametrize(
    ("content", "told"),
    [(b"", "lists nobody"), (b"\xff\xfe\x00", "cannot read"), (None, "cannot read")],
    ids=["empty", "other bytes", "missing"],
)
def test_a_list_that_is_none_is_refused(tmp_path: Path, content: bytes | None, told: str) -> None:
    if content is not None:
        (tmp_path / "list.csv").write_bytes(content)
    with pytest.raises(InputError, match=told):
        copy_of(tmp_path).read(Path("list.csv"), "probe")


def test_a_column_that_is_not_there_is_named(root: Path) -> None:
    with pytest.raises(InputError, match=r"ijb\.path=\{video\}\.png: 'video'; wanted columns"):
        copy_of(root, "{video}.png").read(Path("protocols/probe.csv"), "probe")
