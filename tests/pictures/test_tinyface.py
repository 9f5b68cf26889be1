"""Tests of lrsr/pictures/tinyface.py, on a made-up copy."""

from pathlib import Path

import pytest
from fakes.sets import write_tinyface

from lrsr.errors import InputError
from lrsr.pictures.tinyface import TinyFace


@pytest.fixture
def root(tmp_path: Path) -> Path:
    return write_tinyface(tmp_path)


def test_distractors_are_people_of_their_own(root: Path) -> None:
    copy = TinyFace(root)
    assert copy.probes().identity_ids == ["1", "2", "3", "4"]
    gallery = copy.gallery()
    assert gallery.identity_ids[:8] == ["1", "1", "2", "2", "3", "3", "4", "4"]
    assert gallery.identity_ids[8:] == [f"distractor {n}_stranger" for n in range(3)]
    assert gallery.names[8] == "Testing_Set/Gallery_Distractor/0_stranger.jpg"
    assert gallery.load(8, 9)[0].landmarks_px is None


def test_distractors_in_folders_are_found_and_may_be_fewer(root: Path) -> None:
    folder = root / "Testing_Set" / "Gallery_Distractor"
    (folder / "deep").mkdir()
    (folder / "2_stranger.jpg").rename(folder / "deep" / "2_stranger.jpg")
    assert len(TinyFace(root).gallery().entries) == 11
    assert len(TinyFace(root, 1).gallery().entries) == 9
    assert len(TinyFace(root, 0).gallery().entries) == 8


def test_lists_may_lie_with_the_evaluation(root: Path) -> None:
    place = root / "Face_Identification_Evaluation"
    place.mkdir()
    for file in (root / "Testing_Set").glob("*.mat"):
        file.rename(place / file.name)
    assert len(TinyFace(root).probes().entries) == 4


def test_another_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"tinyface\.root=.*holds Testing_Set"):
        TinyFace(tmp_path)


def test_fewer_distractors_than_none_are_refused(root: Path) -> None:
    with pytest.raises(InputError, match=r"tinyface\.distractors=-1"):
        TinyFace(root, -1)


def test_distractors_that_are_not_there_are_refused(tmp_path: Path) -> None:
    copy = TinyFace(write_tinyface(tmp_path, distractors=0))
    with pytest.raises(InputError, match=r"tinyface\.distractors=0"):
        copy.gallery()


def test_a_missing_list_is_refused(root: Path) -> None:
    (root / "Testing_Set" / "probe_img_ID_pairs.mat").unlink()
    with pytest.raises(InputError, match=r"cannot read .*probe_img_ID_pairs\.mat"):
        TinyFace(root).probes()
