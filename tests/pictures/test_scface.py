"""Tests of lrsr/pictures/scface.py, on a made-up copy."""

from pathlib import Path

import numpy as np
import pytest
from fakes.sets import points_of, write_face, write_scface

from lrsr.errors import InputError
from lrsr.pictures.folder import read_picture
from lrsr.pictures.scface import SCFace


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_scface(tmp_path_factory.mktemp("scface"), [1, 44, 130])


def test_both_layouts_hold_the_same_pictures(root: Path, tmp_path: Path) -> None:
    flat = SCFace(root).probes(3, 1)
    nested = SCFace(write_scface(tmp_path, [1, 44, 130], folders=True)).probes(3, 1)
    assert flat.identity_ids == nested.identity_ids == ["001", "044", "130"]
    assert flat.entries[1].file == "surveillance_cameras_all/044_cam3_1.jpg"
    assert nested.entries[1].file == "surveillance_cameras_distance_1/cam_3/044_cam3_1.jpg"
    assert [one.landmarks_px for one in flat.entries] == [
        one.landmarks_px for one in nested.entries
    ]
    first, again = flat.load(0, 3), nested.load(0, 3)
    assert all((a.image == b.image).all() for a, b in zip(first, again, strict=True))


def test_a_copy_in_both_layouts_shows_nobody_twice(root: Path, tmp_path: Path) -> None:
    write_scface(tmp_path, [1, 2])
    write_scface(tmp_path, [2, 3], folders=True)
    assert SCFace(tmp_path).probes(1, 1).identity_ids == ["001", "002", "003"]


def test_mugshots_are_enrolled_as_taken_or_cut(root: Path) -> None:
    for kind, side, known in (("original", 96, True), ("cropped", 64, False)):
        gallery = SCFace(root).gallery(kind)  # type: ignore[arg-type]  # one of them
        assert gallery.identity_ids == ["001", "044", "130"]
        assert gallery.load(0, 1)[0].image.shape == (3, side, side)
        assert (gallery.entries[0].landmarks_px is not None) is known


def test_large_mugshots_are_shrunk_with_their_landmarks(tmp_path: Path) -> None:
    write_scface(tmp_path, [1])
    write_face(tmp_path / "mugshot_frontal_original_all" / "001_frontal.jpg", 1, 1601)
    (tmp_path / "all.txt").write_text("001_frontal 799 800 1099 800 949 900 949 1001\n")
    (picture,) = SCFace(tmp_path).gallery("original").load(0, 1)
    assert picture.image.shape == (3, 533, 533)
    assert picture.landmarks_px is not None
    assert picture.landmarks_px[0].tolist() == pytest.approx([266, (800.5 / 3) - 0.5])
    assert 0 <= float(picture.image.min()) < float(picture.image.max()) <= 1


def test_coordinates_become_landmarks_as_seen(root: Path) -> None:
    entry = SCFace(root).probes(1, 1).entries[0]
    true = points_of(10, 40)
    assert entry.ipd_px == pytest.approx(10, abs=0.02)
    assert entry.landmarks_px is not None
    found = np.array(entry.landmarks_px).reshape(5, 2)
    np.testing.assert_allclose(found[:3], true[:3], atol=0.01)
    np.testing.assert_allclose(found[3:], true[3:], atol=0.05)  # corners from the middle
    picture = read_picture(root, entry)
    assert picture.landmarks_px is not None
    assert picture.landmarks_px[0, 0] < picture.landmarks_px[1, 0]


def test_eyes_are_told_apart_by_their_place_whatever_they_are_called(tmp_path: Path) -> None:
    write_scface(tmp_path, [1], coordinates=False)
    points = {"reye": (10, 20), "leye": (30, 20), "nose": (20, 30), "mouth": (20, 40)}
    for names in (points, points | {"reye": points["leye"], "leye": points["reye"]}):
        text = "".join(f"{name} {x} {y}\n" for name, (x, y) in names.items())
        (tmp_path / "surveillance_cameras_all" / "001_cam1_1.pos").write_text(text)
        entry = SCFace(tmp_path).probes(1, 1).entries[0]
        assert entry.landmarks_px == pytest.approx((10, 20, 30, 20, 20, 30, 11.72, 40, 28.28, 40))


def test_annotations_may_lie_elsewhere(tmp_path: Path) -> None:
    root = write_scface(tmp_path / "set", [1], coordinates=False)
    (tmp_path / "mine.txt").write_text("001_cam1_1.jpg 30,20 10,20 20,30 20,40\n")
    (tmp_path / "pos").mkdir()
    (tmp_path / "pos" / "001_cam1_1.pos").write_text(
        "reye 10 20\nleye 30 20\nnose 20 30\nmouth 20 40"
    )
    assert SCFace(root).probes(1, 1).entries[0].landmarks_px is None
    for place in ("mine.txt", "pos"):
        entry = SCFace(root, tmp_path / place).probes(1, 1).entries[0]
        assert entry.landmarks_px is not None
        assert entry.landmarks_px[:4] == (10, 20, 30, 20)


def test_other_files_are_left_out(root: Path, tmp_path: Path) -> None:
    write_scface(tmp_path, [7])
    for name in ("007_cam1_1.txt", "Thumbs.db", "7_cam1_1.jpg", "._008_cam1_1.jpg"):
        (tmp_path / "surveillance_cameras_all" / name).write_bytes(b"")
    write_face(tmp_path / "surveillance_cameras_all" / "007_cam8.jpg", 7)
    assert SCFace(tmp_path).probes(1, 1).identity_ids == ["007"]


@pytest.mark.parametrize(
    ("camera", "distance", "message"),
    [
        pytest.param(9, 1, r"scface\.cameras=9: wanted of 1 to 7", id="camera"),
        pytest.param(1, 4, r"scface\.distances=4", id="distance"),
        pytest.param(2, 1, r"holds no picture NNN_cam2_1\.jpg", id="absent"),
    ],
)
def test_a_camera_that_is_not_there_is_refused(
    root: Path, camera: int, distance: int, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        SCFace(root).probes(camera, distance)


def test_an_empty_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"scface\.root=.*wanted the folder with surveillance"):
        SCFace(tmp_path)


def test_mugshots_that_are_not_there_are_refused(tmp_path: Path) -> None:
    copy = SCFace(write_scface(tmp_path, [1], mugshots=("original",)))
    with pytest.raises(InputError, match=r"cropped_all holds no NNN_frontal\.jpg"):
        copy.gallery("cropped")
    with pytest.raises(InputError, match=r"scface\.mugshots=rotated"):
        copy.gallery("rotated")  # type: ignore[arg-type]  # what is refused


@pytest.mark.parametrize(
    ("file", "text", "message"),
    [
        pytest.param(
            "all.txt", "001_cam1_1 a 2 3 4 5 6 7 8", r"all\.txt, line 1: .*'a'", id="word"
        ),
        pytest.param(
            "all.txt", "001_cam1_1 " + "1,5 " * 8, r"all\.txt, line 1: decimal commas", id="commas"
        ),
        pytest.param("x.pos", "reye 1 2\nleye 3 2\nnose 2 4", r"no mouth; wanted", id="point"),
        pytest.param("x.pos", "reye 1 b", r"line 1: .*'b'", id="letter"),
    ],
)
def test_broken_coordinates_are_refused(tmp_path: Path, file: str, text: str, message: str) -> None:
    write_scface(tmp_path, [1], coordinates=False)
    place = tmp_path / "surveillance_cameras_all" / "001_cam1_1.pos"
    (tmp_path / file if file == "all.txt" else place).write_text(text)
    with pytest.raises(InputError, match=message):
        SCFace(tmp_path).probes(1, 1)


def test_annotations_that_are_not_there_are_refused(root: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"scface\.annotations=.*does not exist"):
        SCFace(root, tmp_path / "absent").probes(1, 1)
