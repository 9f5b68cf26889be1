"""Tests of lrsr/pictures/survface.py, on a made-up copy."""

from pathlib import Path

import pytest
from fakes.sets import cells, write_survface
from scipy.io import savemat

from lrsr.errors import InputError
from lrsr.pictures.survface import SurvFace


@pytest.fixture
def root(tmp_path: Path) -> Path:
    return write_survface(tmp_path)


def test_strangers_are_nobody_of_the_gallery(root: Path) -> None:
    probes, gallery = SurvFace(root).search()
    assert probes.identity_ids == ["1", "2", "3", "4", *(f"stranger {800 + n}" for n in range(3))]
    assert not {*probes.identity_ids[4:]} & {*gallery.identity_ids}
    assert gallery.identity_ids == ["1", "1", "2", "2", "3", "3", "4", "4"]


def test_pairs_of_one_person_come_first(root: Path) -> None:
    probes, gallery = SurvFace(root).pairs()
    same = [a == b for a, b in zip(probes.identity_ids, gallery.identity_ids, strict=True)]
    assert same == [True] * 4 + [False] * 4
    assert probes.names[4] == "Face_Verification_Test_Set/verification_images/1_cam1_1.jpg"
    assert gallery.names[4].endswith("/2_cam2_1.jpg")


def test_one_of_the_two_test_sets_is_enough(root: Path) -> None:
    (root / "Face_Identification_Test_Set").rename(root / "elsewhere")
    copy = SurvFace(root)
    assert len(copy.pairs()[0].entries) == 8
    with pytest.raises(InputError, match=r"gallery_img_ID_pairs\.mat"):
        copy.search()


def test_a_list_that_contradicts_the_names_is_refused(root: Path) -> None:
    name = "negative_pairs_names"
    file = root / "Face_Verification_Test_Set" / f"{name}.mat"
    savemat(file, {name: cells([("1_cam1_1.jpg", "1_cam2_1.jpg")])})
    with pytest.raises(InputError, match=r"1_cam1_1\.jpg and 1_cam2_1\.jpg are no negative pair"):
        SurvFace(root).pairs()


def test_a_search_without_strangers_is_refused(tmp_path: Path) -> None:
    copy = SurvFace(write_survface(tmp_path, strangers=0))
    with pytest.raises(InputError, match="unmated_probe holds no pictures"):
        copy.search()


def test_another_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"survface\.root="):
        SurvFace(tmp_path)
