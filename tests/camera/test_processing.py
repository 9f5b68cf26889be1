"""Denoising, halos, tone and saturation."""

import math

import pytest
import torch

from lrsr.camera.processing import Processing, _sharpen, _tone, luminance
from lrsr.errors import ImageContractError, InputError
from lrsr.images import linear_to_srgb

EVERYTHING = Processing(
    denoise_luma_px=0.8,
    denoise_luma_level=0.1,
    denoise_chroma_px=1.0,
    sharpen_px=1.0,
    sharpen_amount=0.5,
    contrast=1.3,
    pivot=0.4,
    brightness=0.02,
    saturation=0.8,
)


def light(batch: int = 1, height: int = 12, width: int = 12) -> torch.Tensor:
    generator = torch.Generator().manual_seed(0)
    return 0.1 + 0.6 * torch.rand(batch, 3, height, width, generator=generator)


def step() -> torch.Tensor:
    return (0.3 + 0.4 * (torch.arange(20) > 9)).expand(1, 1, 20, 20)


def test_without_settings_only_the_srgb_curve_is_left() -> None:
    assert torch.allclose(Processing()(light()), linear_to_srgb(light()), atol=1e-6)


def test_the_halo_of_an_unsharp_mask_is_as_high_as_the_formula_says() -> None:
    # The pixel beside the edge misses the weights w(1) + w(2) + ... of the Gaussian.
    sigma_px, amount = 1.5, 0.8
    weights = [math.exp(-0.5 * (i / sigma_px) ** 2) for i in range(-5, 6)]
    halo = amount * 0.4 * sum(weights[6:]) / sum(weights)
    row = _sharpen(step(), sigma_px, amount)[0, 0, 10]
    assert float(row[9]) == pytest.approx(0.3 - halo, abs=1e-5)
    assert float(row[10]) == pytest.approx(0.7 + halo, abs=1e-5)
    assert float(row[2]) == pytest.approx(0.3, abs=1e-6)


def test_sharpening_keeps_the_mean() -> None:
    assert float(_sharpen(step(), 1.0, 2.0).mean()) == pytest.approx(float(step().mean()), abs=1e-6)


def test_contrast_has_its_slope_at_the_pivot_and_leaves_black_and_white() -> None:
    levels = torch.tensor([0.0, 0.399, 0.401, 1.0], dtype=torch.float64)
    black, low, high, white = _tone(levels, 1.8, pivot=0.4).tolist()
    assert (black, white) == pytest.approx((0.0, 1.0))
    assert (high - low) / 0.002 == pytest.approx(1.8, rel=0.01)


def test_little_contrast_makes_black_and_white_grey() -> None:
    assert _tone(torch.tensor([0.0, 0.5, 1.0]), 0.6).tolist() == pytest.approx([0.2, 0.5, 0.8])


@pytest.mark.parametrize("contrast", [0.5, 1.0, 2.5])
def test_tone_keeps_the_order_of_levels(contrast: float) -> None:
    assert bool((_tone(torch.linspace(0, 1, 101), contrast, 0.3).diff() > 0).all())


def test_no_saturation_is_grey_and_keeps_the_luminance() -> None:
    grey = Processing(saturation=0.0)(light())
    assert torch.allclose(grey, luminance(linear_to_srgb(light())).expand_as(grey), atol=1e-6)


def test_chroma_denoising_leaves_the_luminance_and_luma_denoising_the_colour_differences() -> None:
    srgb = linear_to_srgb(light())
    bled = Processing(denoise_chroma_px=1.5)(light())
    assert torch.allclose(luminance(bled), luminance(srgb), atol=1e-5)
    assert float((bled - luminance(bled)).std()) < 0.5 * float((srgb - luminance(srgb)).std())
    smooth = Processing(denoise_luma_px=1.5, denoise_luma_level=1.0)(light())
    assert torch.allclose(smooth - luminance(smooth), srgb - luminance(srgb), atol=1e-5)
    assert float(luminance(smooth).std()) < 0.6 * float(luminance(srgb).std())


def test_the_result_is_srgb_within_its_range() -> None:
    wild = Processing(sharpen_amount=10.0, contrast=3.0, brightness=0.3, saturation=5.0)(light())
    assert (float(wild.min()), float(wild.max())) == (0.0, 1.0)


def test_no_image_sees_the_others_of_its_batch() -> None:
    images = light(5)
    assert torch.equal(EVERYTHING(images), torch.cat([EVERYTHING(one[None]) for one in images]))


def test_contrast_has_a_gradient_at_the_pivot_itself() -> None:
    level = torch.tensor([0.5], requires_grad=True)
    _tone(level, 2.0).backward()
    assert level.grad is not None
    assert level.grad.tolist() == [2.0]


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("denoise_luma_px", -1.0),
        ("denoise_luma_level", 0.0),
        ("denoise_chroma_px", 21.0),
        ("sharpen_px", -1.0),
        ("sharpen_amount", 11.0),
        ("contrast", -1.0),
        ("pivot", 1.5),
        ("brightness", 2.0),
        ("saturation", -0.5),
    ],
)
def test_a_setting_out_of_range_is_refused(name: str, value: float) -> None:
    with pytest.raises(InputError, match=f"{name}={value}: wanted"):
        Processing(**{name: value})


def test_broken_light_is_refused() -> None:
    for function in (Processing(), luminance):
        with pytest.raises(ImageContractError, match="got shape"):
            function(torch.zeros(1, 1, 4, 4))
    with pytest.raises(ImageContractError, match="got shape"):
        _sharpen(torch.zeros(4, 4), 1.0, 1.0)
    with pytest.raises(InputError, match="sigma_px=-1"):
        _sharpen(step(), -1.0, 1.0)
