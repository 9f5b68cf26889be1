"""A folder of pictures becomes patches and whole pictures, by the field's protocol."""

from pathlib import Path
from typing import Any

import pytest
import torch
from fakes.lessons import draw_pictures

from lrsr.camera import Camera
from lrsr.camera.spectral import SpectralColour
from lrsr.errors import InputError
from lrsr.images import resize_bicubic
from lrsr.pictures.image_files import write_png
from lrsr.presets import preset
from lrsr.training.images import Images
from lrsr.training.patches import LuminancePatches
from lrsr.training.shrinking.clean import Clean
from lrsr.training.shrinking.one_camera import OneCamera


@pytest.fixture
def root(tmp_path: Path) -> Path:
    """Ten pictures of 49x50 pixels, and one of 90x61."""
    for number, picture in enumerate(draw_pictures(10, 50, seed=1)):
        write_png(tmp_path / "pictures" / f"{number}.png", picture[:, :, :49])
    write_png(tmp_path / "pictures" / "wide.png", draw_pictures(1, 90, seed=2)[0, :, :61])
    return tmp_path / "pictures"


def module(root: Path, **settings: Any) -> Images:
    given: dict[str, Any] = {
        "scale": 2,
        "degradation": Clean(),
        "camera": Camera(),
        "patches": LuminancePatches(),
        "batch_size": 128,
        "seed": 0,
    }
    return Images(root=root, **{**given, **settings})


def ready(root: Path, **settings: Any) -> Images:
    data = module(root, **settings)
    data.setup("fit")
    return data


def test_small_pictures_are_shrunk_bicubically_of_whole_multiples_of_the_scale(root: Path) -> None:
    data = ready(root, scale=3, validation_fraction=0.9)
    pairs = list(data.val_dataloader())
    assert len(pairs) == 10
    assert {tuple(true.shape[2:]) for _, true in pairs} <= {(48, 48), (60, 90)}
    for small, true in pairs:
        wanted = resize_bicubic(true, 1 / 3).clamp(0, 1)
        assert float((small - wanted).abs().max()) <= 0.5001 / 255


def test_patches_are_those_of_all_pictures(root: Path) -> None:
    data = ready(root, validation_fraction=0.05)
    assert (len(data.learned), len(data.judged)) == (10, 1)
    inputs, targets = (torch.cat(parts) for parts in zip(*data.train_dataloader(), strict=True))
    each = {(50, 48): 2 * 2, (60, 90): 2 * 5}
    assert data.judged[0].name != "wide.png"
    assert len(inputs) == 9 * each[50, 48] + each[60, 90]
    assert inputs.shape[1:] == (1, 33, 33)
    assert targets.shape[1:] == (1, 21, 21)


def test_of_a_large_picture_each_epoch_shows_another_square(root: Path) -> None:
    whole, cropped = ready(root), ready(root, crop_px=50)
    assert not whole.redrawn
    assert cropped.redrawn
    assert {tuple(true.shape[2:]) for _, true in cropped.pairs(0)} == {(50, 48), (50, 50)}
    first, again, other = cropped.cut(0), cropped.cut(0), cropped.cut(1)
    assert torch.equal(first[0], again[0])
    assert not torch.equal(first[0], other[0])
    assert len(first[0]) == len(other[0])


def test_who_validates_is_drawn_by_the_seed_and_shared_with_nothing(root: Path) -> None:
    parts = [
        (data.learned, data.judged) for data in (module(root), module(root), module(root, seed=1))
    ]
    assert parts[0] == parts[1] != parts[2]
    learned, judged = parts[0]
    assert not {*learned} & {*judged}
    assert len(learned) + len(judged) == 11


def test_fewer_pictures_are_among_more_and_judged_alike(root: Path) -> None:
    few, more = module(root, pictures=3), module(root, pictures=6)
    assert few.learned == more.learned[:3]
    assert few.judged == more.judged
    assert few.about()["validation_files"] == more.about()["validation_files"]
    assert few.about()["files"] != more.about()["files"]


def test_a_folder_of_its_own_validates(root: Path, tmp_path: Path) -> None:
    write_png(tmp_path / "set5" / "baby.png", draw_pictures(1, 48, seed=5)[0])
    data = module(root, validation_root=tmp_path / "set5")
    assert [path.name for path in data.judged] == ["baby.png"]
    assert len(data.learned) == 11


def test_drawn_degradations_are_new_in_every_epoch_and_always_the_same(root: Path) -> None:
    degradation = preset("degradation", "bsrgan")
    one, other = (ready(root, degradation=degradation, pictures=4) for _ in range(2))
    assert torch.equal(one.cut(3)[0], other.cut(3)[0])
    assert not torch.equal(one.cut(3)[0], one.cut(4)[0])
    smalls = [[small for small, _ in data.val_dataloader()] for data in (one, other)]
    assert all(map(torch.equal, *smalls))


def test_only_what_makes_the_small_pictures_is_read(root: Path) -> None:
    assert "camera" in module(root).unread
    assert "camera" not in module(root, degradation=OneCamera()).unread
    assert {"identities", "rendering"} <= {*module(root).unread}


def test_the_card_says_how_the_small_pictures_are_made(root: Path) -> None:
    assert module(root).lr_made_by == "pictures shrunk bicubically, a = -0.5, antialiased, 8 bits"


def test_a_picture_in_both_parts_is_refused(root: Path) -> None:
    with pytest.raises(InputError, match=r"0\.png is to be learned and to validate"):
        module(root, validation_root=root)


def test_a_picture_smaller_than_a_patch_is_refused(root: Path) -> None:
    write_png(root / "tiny.png", torch.zeros(3, 20, 60))
    with pytest.raises(InputError, match=r"tiny.png has 60x20 pixels: wanted 34 or more"):
        ready(root, seed=3)


def test_what_is_no_picture_is_refused(root: Path) -> None:
    (root / "broken.png").write_bytes(b"no")
    with pytest.raises(InputError, match=r"broken.png is no picture"):
        ready(root, validation_fraction=0.01)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"scale": 5}, "data.scale=5: wanted 2, 3 or 4"),
        ({"crop_px": 20}, "data.crop_px=20: wanted null, or at least the 34 px"),
        ({"pictures": 11}, "data.pictures=11: wanted 1 to 10"),
        ({"validation_fraction": 1.0}, "data.validation_fraction=1.0: wanted a number > 0"),
        ({"batch_size": 0}, "data.batch_size=0: wanted a number >= 1"),
        ({"validation_root": "/dev/null"}, "/dev/null is no folder"),
        (
            {"degradation": OneCamera(), "camera": Camera(colour=SpectralColour("nikon_d5100"))},
            "camera=reference: its measured filters look at spectral bands",
        ),
    ],
    ids=lambda value: "".join(value) if isinstance(value, dict) else "",
)
def test_a_wrong_setting_is_one_line(root: Path, settings: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        module(root, **settings)


def test_one_picture_alone_cannot_do_both(tmp_path: Path) -> None:
    write_png(tmp_path / "one.png", torch.zeros(3, 50, 50))
    with pytest.raises(InputError, match="with 1 picture: wanted more than the 1 to validate on"):
        module(tmp_path)
