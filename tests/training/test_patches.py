"""33 in, 21 out, every 14 pixels; input and target show the same place."""

import pytest
import torch
from lrsr.data.patches import PairDataset, PatchDataset, cut_patches, luminance_pair

from lrsr.errors import ImageContractError
from lrsr.images import luminance, resize_bicubic


def places(batch: int, height: int, width: int) -> torch.Tensor:
    """An image whose every value says where it is."""
    count = batch * height * width
    return torch.arange(count, dtype=torch.float32).reshape(batch, 1, height, width)


def noise(*shape: int) -> torch.Tensor:
    return torch.rand(shape, generator=torch.Generator().manual_seed(0))


@pytest.mark.parametrize("size", [(33, 33), (64, 64), (47, 75), (128, 128), (46, 46)], ids=str)
def test_patches_are_those_of_two_loops(size: tuple[int, int]) -> None:
    inputs, targets = places(2, *size), places(2, *size) + 0.5
    patches, labels = cut_patches(inputs, targets)
    slow = [
        (image, y, x)
        for image in range(2)
        for y in range(0, size[0] - 32, 14)
        for x in range(0, size[1] - 32, 14)
    ]
    assert len(patches) == len(labels) == len(slow)
    for patch, label, (image, y, x) in zip(patches, labels, slow, strict=True):
        assert torch.equal(patch, inputs[image, :, y : y + 33, x : x + 33])
        assert torch.equal(label, targets[image, :, y + 6 : y + 27, x + 6 : x + 27])


@pytest.mark.parametrize(("side", "count"), [(64, 9), (128, 49)])
def test_the_number_of_patches_by_hand(side: int, count: int) -> None:
    patches, labels = cut_patches(places(1, side, side), places(1, side, side))
    assert patches.shape == (count, 1, 33, 33)
    assert labels.shape == (count, 1, 21, 21)
    assert patches.is_contiguous()
    assert labels.is_contiguous()


def test_patches_are_copies() -> None:
    image = places(1, 33, 33)
    patches, labels = cut_patches(image, image)
    image.zero_()
    assert float(patches.sum()) > 0
    assert float(labels.sum()) > 0


def test_other_sizes_and_strides() -> None:
    image = places(1, 10, 10)
    patches, labels = cut_patches(image, image, patch_px=5, label_px=5, stride_px=5)
    assert torch.equal(patches, labels)
    assert patches.shape == (4, 1, 5, 5)


@pytest.mark.parametrize(
    ("inputs", "targets", "sizes", "message"),
    [
        (places(1, 32, 40), places(1, 32, 40), {}, "at least 33x33"),
        (places(1, 40, 40), places(1, 40, 41), {}, "wanted one shape"),
        (noise(1, 3, 40, 40), places(1, 40, 40), {}, "inputs: got shape"),
        (places(1, 40, 40), places(1, 40, 40), {"label_px": 20}, "not centred in a patch of 33"),
        (places(1, 40, 40), places(1, 40, 40), {"label_px": 35}, "not centred in a patch of 33"),
    ],
    ids=["small", "unlike", "colour", "odd", "large label"],
)
def test_images_that_cannot_be_cut_are_refused(
    inputs: torch.Tensor, targets: torch.Tensor, sizes: dict[str, int], message: str
) -> None:
    with pytest.raises(ImageContractError, match=message):
        cut_patches(inputs, targets, **sizes)


@pytest.mark.parametrize("scale", [2, 4])
def test_the_input_is_the_enlarged_luminance_and_the_target_the_luminance(scale: int) -> None:
    lr, hr = noise(2, 3, 8, 9), noise(2, 3, 8 * scale, 9 * scale)
    enlarged, target = luminance_pair(lr, hr)
    assert enlarged.shape == target.shape == (2, 1, 8 * scale, 9 * scale)
    assert torch.equal(enlarged, resize_bicubic(luminance(lr), scale))
    assert torch.equal(target, luminance(hr))


@pytest.mark.parametrize(
    "shape", [(1, 3, 16, 19), (1, 3, 16, 27), (2, 3, 16, 18)], ids=["19", "27", "two images"]
)
def test_films_that_are_no_pair_are_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(ImageContractError, match="wanted one whole scale"):
        luminance_pair(noise(1, 3, 8, 9), noise(*shape))


def test_a_list_of_numbers_is_a_batch_and_one_number_a_patch() -> None:
    inputs, targets = places(5, 2, 2), places(5, 1, 1)
    data = PatchDataset(inputs, targets)
    assert len(data) == 5
    assert torch.equal(data[3][0], inputs[3])
    batch, labels = data[[4, 0, 4]]
    assert torch.equal(batch, inputs[[4, 0, 4]])
    assert torch.equal(labels, targets[[4, 0, 4]])


def test_pairs_may_differ_in_size() -> None:
    data = PairDataset([(noise(1, 4, 4), noise(1, 4, 4)), (noise(1, 6, 6), noise(1, 6, 6))])
    assert len(data) == 2
    assert data[1][0].shape == (1, 6, 6)
