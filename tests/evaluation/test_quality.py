"""Tests of lrsr/evaluation/quality.py."""

import numpy as np
import pytest
import torch
from numpy.typing import ArrayLike
from skimage.color import rgb2ycbcr
from skimage.metrics import peak_signal_noise_ratio, structural_similarity

from lrsr.errors import ImageContractError
from lrsr.evaluation.quality import _luminance, psnr_y, ssim_y


def pair(height: int = 24, width: int = 31, batch: int = 2) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(0)
    a = rng.random((batch, 3, height, width)).astype(np.float32)
    return a, np.clip(a + rng.normal(0, 0.05, a.shape), 0, 1).astype(np.float32)


def test_luminance_agrees_with_scikit_image() -> None:
    a, _ = pair()
    wanted = rgb2ycbcr(np.moveaxis(a, 1, -1).astype(np.float64))[..., 0] / 255
    assert _luminance(a) == pytest.approx(wanted, abs=1e-12)


@pytest.mark.parametrize(
    ("colour", "wanted"),
    [
        pytest.param((0, 0, 0), 16, id="black"),
        pytest.param((1, 1, 1), 235, id="white"),
        pytest.param((1, 0, 0), 81.481, id="red"),
        pytest.param((0, 1, 0), 144.553, id="green"),
        pytest.param((0, 0, 1), 40.966, id="blue"),
    ],
)
def test_luminance_is_studio_range(colour: tuple[int, int, int], wanted: float) -> None:
    assert _luminance(np.reshape(np.float64(colour), (3, 1, 1))).item() * 255 == pytest.approx(
        wanted
    )


@pytest.mark.parametrize("shave", [0, 2, 4])
def test_psnr_agrees_with_scikit_image(shave: int) -> None:
    a, b = pair()
    inside = (slice(shave, 24 - shave), slice(shave, 31 - shave))
    wanted = [
        peak_signal_noise_ratio(_luminance(x)[inside], _luminance(y)[inside], data_range=1)
        for x, y in zip(a, b, strict=True)
    ]
    assert psnr_y(a, b, shave) == pytest.approx(wanted, rel=1e-12)


def test_psnr_of_a_grey_step_is_computed_by_hand() -> None:
    # A tenth of the range of 219 is 21.9 of 255: 20 log10(255 / 21.9).
    a = np.full((3, 8, 8), 0.4)
    assert float(psnr_y(a, a + 0.1, 2)) == pytest.approx(21.3220, abs=1e-4)


def test_psnr_has_a_value_for_each_image() -> None:
    a, b = pair()
    assert psnr_y(a, b, 1).shape == (2,)
    assert psnr_y(a[0], b[0], 1).shape == ()
    assert float(psnr_y(a[1], b[1], 1)) == pytest.approx(psnr_y(a, b, 1)[1], rel=1e-14)


def test_psnr_is_symmetric() -> None:
    a, b = pair()
    assert (psnr_y(a, b, 1) == psnr_y(b, a, 1)).all()


def test_psnr_of_equal_images_is_infinite() -> None:
    a, _ = pair()
    assert np.isposinf(psnr_y(a, a, 0)).all()


def test_halving_the_error_adds_six_decibels() -> None:
    a = np.full((3, 4, 4), 0.5)
    gain = psnr_y(a, a + 0.1, 0) - psnr_y(a, a + 0.2, 0)
    assert float(gain) == pytest.approx(20 * np.log10(2))


def test_what_is_shaved_does_not_count() -> None:
    a, b = pair()
    spoiled = b.copy()
    spoiled[..., :3, :] = 0
    assert (psnr_y(a, spoiled, 3) == psnr_y(a, b, 3)).all()


@pytest.mark.parametrize(
    ("a", "b", "shave", "message"),
    [
        pytest.param((3, 20, 20), (3, 20, 21), 0, "one shape", id="shapes"),
        pytest.param((1, 20, 20), (1, 20, 20), 0, r"got shape \(1, 20, 20\)", id="grey"),
        pytest.param((20, 20), (20, 20), 0, r"got shape \(20, 20\)", id="flat"),
        pytest.param((0, 3, 9, 9), (0, 3, 9, 9), 0, "got shape", id="empty"),
        pytest.param((3, 20, 20), (3, 20, 20), 10, "leaves nothing", id="shaved-away"),
        pytest.param((3, 20, 20), (3, 20, 20), -1, "leaves nothing", id="negative-shave"),
    ],
)
def test_images_that_cannot_be_compared_are_refused(
    a: tuple[int, ...], b: tuple[int, ...], shave: int, message: str
) -> None:
    with pytest.raises(ImageContractError, match=message):
        psnr_y(np.zeros(a), np.zeros(b), shave)


def test_an_image_with_a_nan_is_refused() -> None:
    with pytest.raises(ImageContractError, match="NaN"):
        _luminance(np.full((3, 2, 2), np.nan))


A = np.random.default_rng(1).random((3, 12, 12))


@pytest.mark.parametrize(
    ("image", "message"),
    [
        pytest.param(np.uint8(A * 255), "dtype uint8: give floating point srgb", id="8-bit"),
        pytest.param((A * 255).astype(int), r"divide 8-bit values by 255", id="whole-numbers"),
        pytest.param(A < 0.5, "dtype bool", id="flags"),
        pytest.param(A * 255, r"to 25\d.*wanted floating point srgb in \[0, 1\]", id="0..255"),
        pytest.param(A * 2 - 1, r"from -0\.9.*map -1\.\.1 by", id="-1..1"),
        pytest.param(np.ma.masked_less(A, 0.2), "masked in part", id="masked"),
        pytest.param(A.astype(complex), "dtype complex128", id="complex"),
        pytest.param(A.astype(np.longdouble), "dtype", id="long-double"),
        pytest.param(A.astype(object), "dtype object", id="objects"),
        pytest.param([[0.1], [0.2, 0.3]], "make no array", id="ragged"),
        pytest.param(torch.zeros(3, 12, 12, dtype=torch.uint8), "dtype uint8", id="8-bit-tensor"),
    ],
)
def test_the_range_of_an_image_is_never_guessed(image: object, message: str) -> None:
    for pair in ((image, A), (A, image)):
        with pytest.raises(ImageContractError, match=message):
            psnr_y(*pair, 1)


@pytest.mark.parametrize(
    ("image", "tolerance"),
    [
        pytest.param(torch.from_numpy(A), 1e-12, id="tensor"),
        pytest.param(torch.from_numpy(A).requires_grad_(), 1e-12, id="gradient"),
        pytest.param(torch.from_numpy(A).to_sparse(), 1e-12, id="sparse"),
        pytest.param(torch.from_numpy(A).bfloat16(), 1e-1, id="bfloat16"),
        pytest.param(torch.from_numpy(A).half(), 1e-2, id="half"),
        pytest.param(A.astype(">f8"), 1e-12, id="big-endian"),
        pytest.param(A.tolist(), 1e-12, id="list"),
        pytest.param(np.asfortranarray(A), 1e-12, id="fortran"),
        pytest.param(np.ma.masked_array(A), 1e-12, id="nothing-masked"),
    ],
)
def test_images_of_any_origin_are_measured(image: ArrayLike, tolerance: float) -> None:
    other = 1 - A
    assert psnr_y(image, other, 1) == pytest.approx(psnr_y(A, other, 1), abs=tolerance)


def test_what_float32_leaves_beyond_white_is_no_other_range() -> None:
    assert np.isfinite(_luminance(np.full((3, 2, 2), 1 + 2e-7))).all()


@pytest.mark.parametrize("shave", [0, 2, 4])
def test_ssim_agrees_with_scikit_image(shave: int) -> None:
    a, b = pair()
    inside = (slice(shave, 24 - shave), slice(shave, 31 - shave))
    wang = {"gaussian_weights": True, "sigma": 1.5, "use_sample_covariance": False}
    wanted = [
        structural_similarity(_luminance(x)[inside], _luminance(y)[inside], data_range=1, **wang)
        for x, y in zip(a, b, strict=True)
    ]
    assert ssim_y(a, b, shave) == pytest.approx(wanted, rel=1e-10)


def test_ssim_of_equal_images_is_one_and_that_of_a_negative_below_zero() -> None:
    a, b = pair()
    assert ssim_y(a, a, 0) == pytest.approx([1, 1])
    assert (ssim_y(a, 1 - a, 0) < 0).all()
    assert ssim_y(a, b, 1) == pytest.approx(ssim_y(b, a, 1), rel=1e-12)


def test_ssim_has_a_value_for_each_image() -> None:
    a, b = pair()
    assert ssim_y(a[0], b[0], 1).shape == ()
    assert float(ssim_y(a[1], b[1], 1)) == pytest.approx(ssim_y(a, b, 1)[1], rel=1e-12)


def test_ssim_needs_room_for_one_window() -> None:
    a, b = pair(height=15)
    assert np.isfinite(ssim_y(a, b, 2)).all()
    assert np.isnan(ssim_y(a, b, 3)).all()
    with pytest.raises(ImageContractError, match="leaves nothing"):
        ssim_y(a, b, 8)
