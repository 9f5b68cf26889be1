import numpy as np
import pytest
import torch
from scipy.ndimage import gaussian_filter

from lrsr.training.gaussians import filter_each, gaussian_kernels


def test_each_picture_gets_scipys_gaussian_of_its_own_width() -> None:
    images = torch.rand(2, 3, 30, 20, generator=torch.Generator().manual_seed(0))
    widths = np.array([0.7, 2.0])
    blurred = filter_each(images, gaussian_kernels(widths, widths, np.zeros(2)))
    for image, found, width in zip(images.numpy(), blurred.numpy(), widths, strict=True):
        wanted = gaussian_filter(image, (0, width, width), mode="nearest", radius=(0, 6, 6))
        assert np.abs(found - wanted).max() < 1e-3


def test_a_kernel_has_its_variances_along_its_axes_and_the_sum_1() -> None:
    (kernel,) = gaussian_kernels(np.array([1.0]), np.array([3.0]), np.array([0.0]))
    place = np.arange(len(kernel)) - len(kernel) // 2
    assert kernel.sum() == pytest.approx(1)
    assert (kernel.sum(0) * place**2).sum() == pytest.approx(9, rel=0.03)
    assert (kernel.sum(1) * place**2).sum() == pytest.approx(1, rel=0.03)


def test_a_quarter_turn_of_the_direction_is_one_of_the_kernel() -> None:
    angles = np.array([0.3, 0.3 + np.pi / 2])
    across, down = gaussian_kernels(np.full(2, 0.6), np.full(2, 2.0), angles)
    assert np.rot90(across, -1) == pytest.approx(down)
