"""33 in, 21 out, every 14 pixels; input and target show the same place."""

import pytest
import torch

from lrsr.errors import ImageContractError, InputError
from lrsr.images import luminance, resize_bicubic
from lrsr.training.patches import (
    FacePatches,
    LuminancePatches,
    RgbPatches,
    SmallLuminancePatches,
)


def noise(*shape: int) -> torch.Tensor:
    return torch.rand(shape, generator=torch.Generator().manual_seed(0))


def pair(height: int, width: int, scale: int = 2) -> tuple[torch.Tensor, torch.Tensor]:
    return noise(2, 3, height, width), noise(2, 3, height * scale, width * scale).flip(-1)


@pytest.mark.parametrize("size", [(17, 17), (32, 32), (24, 38), (64, 64), (23, 23)], ids=str)
def test_patches_are_those_of_two_loops(size: tuple[int, int]) -> None:
    small, true = pair(*size)
    inputs, targets = resize_bicubic(luminance(small), 2), luminance(true)
    patches, labels = LuminancePatches().cut(small, true)
    slow = [
        (image, y, x)
        for image in range(2)
        for y in range(0, 2 * size[0] - 32, 14)
        for x in range(0, 2 * size[1] - 32, 14)
    ]
    assert len(patches) == len(labels) == len(slow)
    for patch, label, (image, y, x) in zip(patches, labels, slow, strict=True):
        assert torch.equal(patch, inputs[image, :, y : y + 33, x : x + 33])
        assert torch.equal(label, targets[image, :, y + 6 : y + 27, x + 6 : x + 27])


@pytest.mark.parametrize(("side", "count"), [(64, 9), (128, 49)])
def test_the_number_of_patches_by_hand(side: int, count: int) -> None:
    patches, labels = LuminancePatches().cut(*pair(side // 2, side // 2))
    assert patches.shape == (2 * count, 1, 33, 33)
    assert labels.shape == (2 * count, 1, 21, 21)
    assert patches.is_contiguous()
    assert labels.is_contiguous()


def test_patches_are_copies() -> None:
    small, true = pair(16, 16)
    patches, labels = RgbPatches(16).cut(small, true)
    small.zero_()
    true.zero_()
    assert float(patches.sum()) > 0
    assert float(labels.sum()) > 0


def test_other_sizes_and_strides() -> None:
    same = noise(2, 3, 10, 10)
    patches, labels = LuminancePatches(5, 5, 5).cut(same, same)
    assert torch.allclose(patches, labels, atol=1e-6)
    assert patches.shape == (8, 1, 5, 5)


@pytest.mark.parametrize("scale", [2, 4])
def test_colours_are_cut_as_they_are(scale: int) -> None:
    small, true = pair(20, 12, scale)
    inputs, targets = RgbPatches(patch_px=8, stride_px=4).cut(small, true)
    assert len(inputs) == 2 * 4 * 2
    at = slice(4 * scale, 12 * scale)
    assert torch.equal(inputs[3], small[0, :, 4:12, 4:12])
    assert torch.equal(targets[3], true[0, :, at, at])


@pytest.mark.parametrize(
    ("inputs", "targets", "message"),
    [
        (noise(1, 3, 16, 20), noise(1, 3, 32, 40), "at least 33x33"),
        (noise(1, 3, 40, 40), noise(1, 3, 40, 41), "wanted one whole scale"),
        (noise(1, 1, 40, 40), noise(1, 3, 40, 40), "lr_srgb: got shape"),
    ],
    ids=["small", "unlike", "grey"],
)
def test_images_that_cannot_be_cut_are_refused(
    inputs: torch.Tensor, targets: torch.Tensor, message: str
) -> None:
    with pytest.raises(ImageContractError, match=message):
        LuminancePatches().cut(inputs, targets)


@pytest.mark.parametrize("label_px", [20, 35])
def test_a_label_that_is_not_centred_is_refused(label_px: int) -> None:
    with pytest.raises(ImageContractError, match="not centred in a patch of 33"):
        LuminancePatches(label_px=label_px)


@pytest.mark.parametrize(
    "shape", [(1, 3, 16, 19), (1, 3, 16, 27), (2, 3, 16, 18)], ids=["19", "27", "two images"]
)
def test_films_that_are_no_pair_are_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(ImageContractError, match="wanted one whole scale"):
        RgbPatches(4).cut(noise(1, 3, 8, 9), noise(*shape))


@pytest.mark.parametrize(("scale", "least"), [(2, 17), (4, 9)])
def test_the_smallest_picture_holds_one_patch(scale: int, least: int) -> None:
    patches = LuminancePatches()
    assert patches.least_px(scale) == least
    assert len(patches.cut(*pair(least, least, scale))[0]) == 2


def test_small_luminance_is_that_of_the_colours() -> None:
    small, true = pair(20, 12, 3)
    colours = RgbPatches(8, 4).cut(small, true)
    for found, wanted in zip(SmallLuminancePatches(8, 4).cut(small, true), colours, strict=True):
        assert torch.equal(found, luminance(wanted))


def landmarks_at(*middles: tuple[float, float]) -> torch.Tensor:
    spread = torch.tensor([[-4.0, -3.0], [4.0, -3.0], [0.0, 0.0], [-3.0, 3.0], [3.0, 3.0]])
    return torch.tensor(middles)[:, None] + spread


def test_a_face_is_cut_about_its_landmarks_which_move_along() -> None:
    small, true = noise(2, 3, 20, 24), noise(2, 3, 40, 48).flip(-1)
    marks = landmarks_at((24.5, 18.5), (30.5, 20.5))  # in the small one: (12, 9) and (15, 10)
    inputs, targets, landmarks_px = FacePatches(9).cut(small, true, marks)
    assert torch.equal(inputs[0], small[0, :, 5:14, 8:17])
    assert torch.equal(targets[0], true[0, :, 10:28, 16:34])
    assert torch.equal(inputs[1], small[1, :, 6:15, 11:20])
    assert torch.equal(landmarks_px[1], marks[1] - torch.tensor([22.0, 12.0]))


@pytest.mark.parametrize("scale", [2, 3, 4])
def test_a_face_at_the_border_is_cut_inside(scale: int) -> None:
    small, true = noise(2, 3, 12, 10), noise(2, 3, 12 * scale, 10 * scale)
    marks = landmarks_at((0.0, 0.0), (10.0 * scale, 12.0 * scale))
    inputs, targets, landmarks_px = FacePatches(8).cut(small, true, marks)
    assert torch.equal(inputs[0], small[0, :, :8, :8])
    assert torch.equal(inputs[1], small[1, :, 4:, 2:])
    assert torch.equal(targets[1], true[1, :, 4 * scale :, 2 * scale :])
    assert torch.equal(landmarks_px[0], marks[0])


@pytest.mark.parametrize("marks", [None, torch.full((1, 5, 2), torch.nan)], ids=["none", "nan"])
def test_a_face_without_landmarks_is_refused(marks: torch.Tensor | None) -> None:
    with pytest.raises(InputError, match=r"a picture has none; give patches=rgb, or pictures with"):
        FacePatches(8).cut(noise(1, 3, 12, 10), noise(1, 3, 24, 20), marks)


def test_a_picture_smaller_than_its_face_is_refused() -> None:
    assert FacePatches(16).least_px(4) == 16
    with pytest.raises(ImageContractError, match="wanted at least 16x16"):
        FacePatches(16).cut(noise(1, 3, 12, 18), noise(1, 3, 24, 36), landmarks_at((9.0, 9.0)))


@pytest.mark.parametrize("kind", [FacePatches, RgbPatches, SmallLuminancePatches])
@pytest.mark.parametrize("side", [1.5, "wide", None])
def test_a_side_that_is_no_number_of_pixels_is_refused(kind: type, side: object) -> None:
    with pytest.raises(InputError, match=r"data.patches.patch_px=.*: wanted a whole number"):
        kind(patch_px=side)


def test_a_face_of_no_pixels_is_refused() -> None:
    with pytest.raises(InputError, match=r"patches\.patch_px=0: wanted at least 1"):
        FacePatches(0)
