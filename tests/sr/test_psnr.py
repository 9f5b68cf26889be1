import numpy as np
import pytest
import torch
from skimage.metrics import peak_signal_noise_ratio

from lrsr.errors import ImageContractError
from lrsr.sr.psnr import psnr_y_db


@pytest.fixture
def noisy_pair() -> tuple[torch.Tensor, torch.Tensor]:
    generator = torch.Generator().manual_seed(0)
    target = torch.rand(3, 1, 20, 24, generator=generator)
    noise = 0.05 * torch.randn(3, 1, 20, 24, generator=generator)
    return (target + noise).clamp(0, 1), target


@pytest.mark.parametrize("shave_px", [0, 2, 4])
def test_psnr_is_scikit_images_inside_the_border(
    noisy_pair: tuple[torch.Tensor, torch.Tensor], shave_px: int
) -> None:
    restored, target = (
        x.numpy()[:, 0, shave_px : 20 - shave_px, shave_px : 24 - shave_px] for x in noisy_pair
    )
    expected = [
        peak_signal_noise_ratio(t, r, data_range=1.0) for t, r in zip(target, restored, strict=True)
    ]
    measured = psnr_y_db(*noisy_pair, shave_px=shave_px)
    np.testing.assert_allclose(measured.numpy(), expected, rtol=1e-6)


def test_twice_the_error_costs_six_decibels() -> None:
    target = torch.full((1, 1, 9, 9), 0.5)
    loss_db = psnr_y_db(target + 0.05, target, shave_px=1) - psnr_y_db(
        target + 0.1, target, shave_px=1
    )
    assert float(loss_db) == pytest.approx(20 * np.log10(2), abs=1e-4)


def test_border_does_not_count() -> None:
    target = torch.full((1, 1, 9, 9), 0.5)
    restored = target + 0.1
    restored[..., 0, :] = 0.0
    assert float(psnr_y_db(restored, target, shave_px=1)) == pytest.approx(20.0, abs=1e-4)


def test_values_beyond_white_are_clipped_as_8_bits_would() -> None:
    target = torch.ones(1, 1, 5, 5)
    assert float(psnr_y_db(target + 3.0, target, shave_px=0)) == float("inf")


def test_nan_stays_nan() -> None:
    target = torch.full((1, 1, 5, 5), 0.5)
    assert bool(psnr_y_db(target * float("nan"), target, shave_px=0).isnan())


def test_different_shapes_are_refused() -> None:
    with pytest.raises(ImageContractError, match=r"restored is \(1, 1, 4, 4\), wanted"):
        psnr_y_db(torch.zeros(1, 1, 4, 4), torch.zeros(1, 1, 5, 5), shave_px=0)


def test_image_smaller_than_its_border_is_refused() -> None:
    with pytest.raises(ImageContractError, match="8x8 pixels leave nothing"):
        psnr_y_db(torch.zeros(1, 1, 8, 8), torch.zeros(1, 1, 8, 8), shave_px=4)
