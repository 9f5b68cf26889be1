"""Pictures of one size make a batch, with landmarks where they are known."""

from dataclasses import replace

import pytest
import torch

from lrsr.errors import InputError
from lrsr.pictures.picture import Picture, stack, stack_bursts


def picture(number: int, side: int = 4, *, known: bool = True) -> Picture:
    points = torch.arange(10.0).reshape(5, 2) + number
    return Picture(
        torch.full((3, side, side), number / 10),
        f"test-{number:05d}",
        points if known else None,
        "a test",
    )


def test_pictures_of_one_size_make_a_batch_in_their_order() -> None:
    pictures = [picture(number) for number in (3, 1, 2)]
    images, landmarks = stack(pictures)
    assert images.shape == (3, 3, 4, 4)
    assert landmarks.shape == (3, 5, 2)
    for image, points, one in zip(images, landmarks, pictures, strict=True):
        assert torch.equal(image, one.image)
        assert torch.equal(points, one.landmarks_px)


def test_landmarks_that_nobody_knows_are_no_numbers() -> None:
    _, landmarks = stack([picture(1), picture(2, known=False)])
    assert torch.isfinite(landmarks[0]).all()
    assert torch.isnan(landmarks[1]).all()


def test_pictures_of_two_sizes_or_none_make_no_batch() -> None:
    with pytest.raises(InputError, match=r"pictures of sizes \[\(4, 4\), \(8, 8\)\] make no batch"):
        stack([picture(1), picture(2, side=8)])
    with pytest.raises(InputError, match="make no batch"):
        stack([])


def test_bursts_make_a_batch_of_their_first_frames() -> None:
    bursts = [
        replace(picture(number), later=(picture(number + 1), picture(number + 2)))
        for number in (0, 5)
    ]
    images, landmarks = stack_bursts(bursts, 2)
    torch.testing.assert_close(images[:, :, 0, 0, 0], torch.tensor([[0.0, 0.1], [0.5, 0.6]]))
    assert landmarks[:, :, 0, 0].tolist() == [[0.0, 1.0], [5.0, 6.0]]
    assert torch.equal(stack_bursts(bursts, 1)[0][:, 0], stack(bursts)[0])
    with pytest.raises(InputError, match=r"a test \(test-00000\) has 3 frames: wanted 4"):
        stack_bursts(bursts, 4)
