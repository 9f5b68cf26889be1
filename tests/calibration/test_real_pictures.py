from pathlib import Path

import cv2
import numpy as np
import pytest
import torch

from lrsr.calibration.real_pictures import RealPictures, read_real_pictures
from lrsr.errors import InputError
from lrsr.pictures.image_files import write_png


def noise(seed: int, height: int = 20, width: int = 24) -> torch.Tensor:
    picture = torch.rand(3, height, width, generator=torch.Generator().manual_seed(seed))
    return picture.mul(255).round() / 255


def write_jpeg(path: Path, picture: torch.Tensor, quality: int) -> None:
    rows = (picture * 255).byte().permute(1, 2, 0).numpy()[..., ::-1]
    settings = [cv2.IMWRITE_JPEG_QUALITY, quality]
    path.write_bytes(bytes(cv2.imencode(".jpg", np.ascontiguousarray(rows), settings)[1]))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Hold three pictures, and what is none of them."""
    for k in range(3):
        write_png(tmp_path / f"{k}.png", noise(k))
    (tmp_path / "manifest.csv").write_text("file\n0.png\n")
    write_png(tmp_path / "0_linear16.png", noise(9), bits=16)
    (tmp_path / "more.png").mkdir()
    return tmp_path


def test_pictures_come_pixel_for_pixel_in_the_order_of_their_names(folder: Path) -> None:
    found = read_real_pictures(folder, 3)
    assert torch.equal(found.srgb, torch.stack([noise(k) for k in range(3)]))
    assert found.jpeg is None
    assert found.size_px == (20, 24)


def test_jpeg_files_tell_their_middle_quality(tmp_path: Path) -> None:
    for k, quality in enumerate([60, 75, 80]):
        write_jpeg(tmp_path / f"{k}.JPG", noise(k), quality)
    assert read_real_pictures(tmp_path, 3).jpeg == (75, "4:2:0")


def test_of_a_mixture_the_files_tell_nothing(folder: Path) -> None:
    write_jpeg(folder / "3.jpg", noise(3), 75)
    assert read_real_pictures(folder, 3).jpeg is None


def test_the_middle_remembers_where_it_was_cut() -> None:
    found = RealPictures(torch.arange(36.0).reshape(1, 1, 6, 6), origin_px=(8, 0)).cropped((2, 40))
    assert found.srgb[0, 0, :, 0].tolist() == [12.0, 18.0]
    assert found.size_px == (2, 6)
    assert found.origin_px == (8, 2)


def test_a_folder_without_pictures_is_refused(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("none here")
    with pytest.raises(InputError, match="holds no pictures: put files"):
        read_real_pictures(tmp_path, 3)


def test_no_folder_at_all_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is no folder"):
        read_real_pictures(tmp_path / "nowhere", 3)


def test_too_few_pictures_are_refused_with_the_least_number(folder: Path) -> None:
    with pytest.raises(InputError, match="holds 3 pictures: give at least 20"):
        read_real_pictures(folder, 20)


def test_two_sizes_are_refused_by_the_name_of_the_odd_one(folder: Path) -> None:
    write_png(folder / "odd.png", noise(5, 20, 30))
    with pytest.raises(InputError, match=r"odd\.png has 30 x 20 px, most others 24 x 20"):
        read_real_pictures(folder, 3)


def test_a_file_that_only_says_it_is_a_picture_is_refused(folder: Path) -> None:
    (folder / "fake.jpg").write_text("not a picture")
    with pytest.raises(InputError, match=r"fake\.jpg is no picture"):
        read_real_pictures(folder, 3)


@pytest.mark.parametrize(("height", "width"), [(15, 30), (20, 257)])
def test_too_small_and_too_large_pictures_are_refused_by_name(
    height: int, width: int, tmp_path: Path
) -> None:
    write_png(tmp_path / "face.png", noise(1, height, width))
    with pytest.raises(
        InputError, match=rf"face\.png has {width} x {height} px: sides of 16 to 256"
    ):
        read_real_pictures(tmp_path, 1)


def test_grey_pictures_are_refused_but_single_ones_among_others_are_not(folder: Path) -> None:
    grey = noise(7)[:1].expand(3, -1, -1)
    write_png(folder / "3.png", grey)
    assert len(read_real_pictures(folder, 4).srgb) == 4
    for k in range(3):
        write_png(folder / f"{k}.png", grey)
    with pytest.raises(InputError, match="holds grey pictures only"):
        read_real_pictures(folder, 4)
