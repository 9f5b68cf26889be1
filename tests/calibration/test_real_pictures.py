from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
import torch
from PIL import Image, PngImagePlugin

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


@pytest.fixture
def twenty(tmp_path: Path) -> Path:
    for k in range(20):
        write_png(tmp_path / f"{k:02d}.png", noise(k))
    return tmp_path


def copied_bytes(folder: Path) -> None:
    (folder / "x.png").write_bytes((folder / "00.png").read_bytes())


def copied_pixels(folder: Path) -> None:
    cv2.imwrite(str(folder / "x.bmp"), cv2.imread(str(folder / "00.png")))


def with_other_metadata(folder: Path) -> None:
    notes = PngImagePlugin.PngInfo()
    notes.add_text("Comment", "another day")
    Image.open(folder / "00.png").save(folder / "x.png", pnginfo=notes)


def linked(folder: Path) -> None:
    (folder / "x.png").symlink_to(folder / "00.png")


def linked_hard(folder: Path) -> None:
    (folder / "x.PNG").hardlink_to(folder / "00.png")


@pytest.mark.parametrize(
    "copy", [copied_bytes, copied_pixels, with_other_metadata, linked, linked_hard]
)
def test_a_copy_is_counted_once_and_told(
    copy: Callable[[Path], None], twenty: Path, caplog: pytest.LogCaptureFixture
) -> None:
    copy(twenty)
    found = read_real_pictures(twenty, 20)
    assert torch.equal(found.srgb, torch.stack([noise(k) for k in range(20)]))
    (name,) = found.copies
    assert found.copies[name] == "00.png"
    assert f"1 of 21 pictures are copies ({name} of 00.png); each is counted once" in caplog.text


def test_fewer_different_pictures_than_the_least_are_refused_by_their_copies(twenty: Path) -> None:
    for k in range(4):
        (twenty / f"{k:02d}.png").write_bytes((twenty / "19.png").read_bytes())
    with pytest.raises(
        InputError,
        match=r"holds 16 different pictures, since 4 of 20 pictures are copies \(01\.png of "
        r"00\.png, 02\.png of 00\.png, 03\.png of 00\.png, \.\.\.\): give at least 20",
    ):
        read_real_pictures(twenty, 20)


def test_frames_of_one_shot_are_told(twenty: Path, caplog: pytest.LogCaptureFixture) -> None:
    assert not read_real_pictures(twenty, 20).copies
    assert not caplog.text
    frame = noise(3) + 0.01 * (noise(99) - 0.5)
    write_png(twenty / "frame.png", frame)
    assert len(read_real_pictures(twenty, 20).srgb) == 21
    assert "2 of 21 pictures hardly differ from another one; frames of one shot" in caplog.text


def test_whatever_else_lies_in_the_folder_is_passed_over(twenty: Path) -> None:
    for name in (".DS_Store", "Thumbs.db", "notes.txt", "door.yaml", "film.mp4", "no_suffix"):
        (twenty / name).write_bytes(b"something")
    (twenty / "._00.png").write_bytes(b"a resource fork")
    (twenty / ".hidden.png").write_bytes((twenty / "00.png").read_bytes())
    (twenty / "below").mkdir()
    write_png(twenty / "below" / "20.png", noise(20))
    (twenty / "lost.png").symlink_to(twenty / "nowhere.png")
    (twenty / "20.PNG").write_bytes((twenty / "below" / "20.png").read_bytes())
    found = read_real_pictures(twenty, 20)
    assert len(found.srgb) == 21
    assert not found.copies


@pytest.mark.parametrize("kind", ["png", "jpg", "bmp", "tif", "webp"])
def test_a_picture_that_was_cut_short_is_refused_by_name(kind: str, twenty: Path) -> None:
    path = twenty / f"cut.{kind}"
    Image.open(twenty / "00.png").save(path)
    path.write_bytes(path.read_bytes()[: -path.stat().st_size // 3])
    with pytest.raises(InputError, match=rf"cut\.{kind} is "):
        read_real_pictures(twenty, 20)


def test_an_empty_or_forbidden_file_is_refused_by_name(
    twenty: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (twenty / "empty.png").touch()
    with pytest.raises(InputError, match=r"empty\.png is no picture, or a broken one"):
        read_real_pictures(twenty, 20)

    def forbidden(path: Path) -> bytes:
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(Path, "read_bytes", forbidden)
    with pytest.raises(InputError, match=r"cannot read .*00\.png: Permission denied"):
        read_real_pictures(twenty, 20)


def test_a_folder_that_cannot_be_read_is_refused(
    twenty: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def forbidden(path: Path) -> None:
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(Path, "iterdir", forbidden)
    with pytest.raises(InputError, match=r"cannot read images=.*: Permission denied; check its"):
        read_real_pictures(twenty, 20)
