"""Convolution by FFT against the sum that defines it."""

import numpy as np
import pytest
import torch
from scipy.signal import convolve2d

from lrsr.camera import convolution
from lrsr.camera.convolution import convolve
from lrsr.errors import ImageContractError

RANDOM = torch.Generator().manual_seed(0)


def kernels(count: int, side: int, channels: int = 3) -> torch.Tensor:
    weights = torch.rand(count, channels, side, side, generator=RANDOM, dtype=torch.float64)
    return weights / weights.sum((-2, -1), keepdim=True)


def test_it_is_scipys_convolution_of_the_padded_picture() -> None:
    images = torch.rand(2, 3, 7, 9, generator=RANDOM, dtype=torch.float64)
    weights = kernels(2, 5)
    result = convolve(images, weights)
    for image in range(2):
        for channel in range(3):
            padded = np.pad(images[image, channel].numpy(), 2, mode="edge")
            wanted = convolve2d(padded, weights[image, channel].numpy(), mode="valid")
            assert np.allclose(result[image, channel].numpy(), wanted)


def test_a_flat_picture_stays_flat_to_the_border() -> None:
    flat = torch.full((2, 3, 6, 5), 0.7)
    assert torch.allclose(convolve(flat, kernels(1, 9).float()), flat, atol=1e-6)


def test_light_in_the_middle_is_kept() -> None:
    point = torch.zeros(1, 3, 15, 15, dtype=torch.float64)
    point[..., 7, 7] = 2.0
    assert torch.allclose(convolve(point, kernels(1, 7)).sum((-2, -1)), point.sum((-2, -1)))


def test_one_pixel_stays_as_it_is() -> None:
    pixel = torch.tensor([0.25, 0.5, 4.0]).reshape(1, 3, 1, 1)
    assert torch.allclose(convolve(pixel, kernels(1, 11).float()), pixel, atol=1e-5)


def test_the_cut_into_chunks_shows_nowhere(monkeypatch: pytest.MonkeyPatch) -> None:
    images, weights = torch.rand(5, 3, 4, 4, generator=RANDOM).double(), kernels(5, 3)
    whole = convolve(images, weights)
    monkeypatch.setattr(convolution, "_CHUNK", 2)
    assert torch.allclose(convolve(images, weights), whole)


@pytest.mark.parametrize(
    ("shape", "message"),
    [
        ((2, 3, 3, 3), "one or"),
        ((1, 2, 3, 3), "one or"),
        ((1, 3, 4, 4), "odd"),
        ((1, 3, 3, 5), "odd"),
    ],
)
def test_kernels_that_do_not_fit_are_refused(shape: tuple[int, ...], message: str) -> None:
    with pytest.raises(ImageContractError, match=message):
        convolve(torch.zeros(3, 3, 4, 4), torch.zeros(shape))
