"""Tests of lrsr/experiments/portraits.py, on an astronaut whom scikit-image carries."""

from pathlib import Path

import numpy as np
import pytest
import skimage.data
import torch

from lrsr.errors import InputError
from lrsr.experiments.portraits import Cut, Portraits, look_at, look_over, without_copies
from lrsr.pictures.folder import Entry
from lrsr.pictures.image_files import write_png
from lrsr.pictures.picture import Picture
from lrsr.pictures.source import Photographs, read_photographs
from lrsr.recognition.finder import Finder


@pytest.fixture(scope="module")
def astronaut() -> torch.Tensor:
    """A woman whose pupils are some 43 px apart, on 512 x 512 px."""
    return torch.from_numpy(skimage.data.astronaut()).permute(2, 0, 1).float() / 255


def marked(height: int, width: int, x: float, y: float, ipd: float = 20.0) -> Picture:
    """A picture with one white pixel where the left eye is."""
    image = torch.zeros(3, height, width)
    image[:, round(y), round(x)] = 1.0
    offsets = torch.tensor([[0, 0], [1, 0], [0.5, 0.5], [0.1, 1], [0.9, 1]])
    return Picture(image, "p", torch.tensor([x, y]) + ipd * offsets, "")


def test_a_face_is_looked_at_where_it_is(tmp_path: Path, astronaut: torch.Tensor) -> None:
    write_png(tmp_path / "a.png", astronaut)
    found = look_at(tmp_path, Entry("a.png", "a"), Finder())
    assert found.size_px == (512, 512)
    assert found.ipd_px == pytest.approx(42.6, abs=3)
    assert found.landmarks_px is not None
    by_eye = np.array([[203.5, 100.5], [246, 103]])
    np.testing.assert_allclose(found.landmarks_px[:2], by_eye, atol=3)
    assert found.describe()["detector_score"] > 0.9


def test_landmarks_that_are_given_stand(tmp_path: Path, astronaut: torch.Tensor) -> None:
    write_png(tmp_path / "a.png", astronaut)
    given = tuple(float(k) for k in range(10))
    found = look_at(tmp_path, Entry("a.png", "a", landmarks_px=given), Finder())
    assert found.landmarks_px is not None
    assert found.landmarks_px.ravel().tolist() == list(given)
    assert found.detector_score is not None


def test_what_is_small_stays_as_it_is() -> None:
    picture = marked(384, 200, 50, 60)
    assert Cut(longest_px=384)(picture, None) is picture


def test_the_square_about_a_face_is_cut_out_and_its_landmarks_move_along() -> None:
    picture = marked(600, 900, x=400, y=300)
    assert picture.landmarks_px is not None
    cut = Cut(ipds=6, longest_px=384)(picture, picture.landmarks_px.numpy())
    assert cut.image.shape == (3, 120, 120)
    assert cut.landmarks_px is not None
    x, y = cut.landmarks_px[0].round().int().tolist()
    assert cut.image[0, y, x] == 1.0


def test_a_face_at_the_edge_has_what_the_picture_holds() -> None:
    picture = marked(600, 900, x=2, y=590)
    cut = Cut()(picture, np.array([[2.0, 590]] * 5) + np.arange(5)[:, None] * 20)
    assert cut.image.shape[1] < cut.image.shape[2] <= 120 * 6
    assert (cut.image[0] == 1).sum() == 1


def test_without_a_face_the_whole_picture_is_shrunk() -> None:
    picture = marked(601, 900, x=400, y=300)
    cut = Cut(longest_px=384)(picture, None)
    assert cut.image.shape == (3, 201, 300)
    assert cut.landmarks_px is not None
    x, y = cut.landmarks_px[0].round().int().tolist()
    assert cut.image[0, y, x] == cut.image.max()


@pytest.mark.parametrize(("name", "value"), [("ipds", 2.9), ("longest_px", 111)])
def test_a_cut_that_holds_no_face_is_refused(name: str, value: float) -> None:
    with pytest.raises(InputError, match=rf"cut\.{name}={value:g}: wanted"):
        Cut(**{name: value})  # type: ignore[arg-type]  # one of two


def test_what_cannot_be_read_is_named_and_the_others_are_there(tmp_path: Path) -> None:
    for name in ("a", "c"):
        write_png(tmp_path / f"{name}.png", torch.rand(3, 20, 24))
    (tmp_path / "b.png").write_bytes(b"no picture")
    found, refused = look_over(read_photographs(tmp_path, "probe"), None, progress=False)
    assert [one.entry.file for one in found] == ["a.png", "c.png"]
    (error,) = refused
    assert "b.png is no picture" in str(error)
    portraits = Portraits(tmp_path, found, Cut())
    assert portraits.names == ["a.png", "c.png"]
    assert portraits.identity_ids == ["a", "c"]
    assert [one.image.shape for one in portraits.load(1, 2)] == [(3, 20, 24)]


def test_a_probe_that_is_enrolled_is_left_out(tmp_path: Path) -> None:
    pictures = [torch.rand(3, 20, 20) for _ in range(3)]
    for folder, members in (("probes", (0, 1)), ("gallery", (1, 2))):
        for k in members:
            write_png(tmp_path / folder / f"{k}.png", pictures[k])
    sides = [
        look_over(Photographs(tmp_path / name, [Entry(f"{k}.png", "x") for k in some]), None,
                  progress=False)[0]
        for name, some in (("probes", (0, 1)), ("gallery", (1, 2)))
    ]  # fmt: skip
    kept, copies = without_copies(*sides)
    assert [one.entry.file for one in kept] == ["0.png"]
    assert [(one.entry.file, other.entry.file) for one, other in copies] == [("1.png", "1.png")]
