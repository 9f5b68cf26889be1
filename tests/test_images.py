"""Every line of the image contract."""

from collections.abc import Callable
from fractions import Fraction

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import bicubic
from skimage.color import rgb2ycbcr

from lrsr.errors import ImageContractError, InputError, NonFiniteError
from lrsr.images import (
    check_images,
    check_srgb,
    linear_to_srgb,
    luminance,
    resize_bicubic,
    rgb_to_ycbcr,
    scale_points,
    srgb_to_linear,
    ycbcr_to_rgb,
)


def noise(*shape: int, seed: int = 0) -> torch.Tensor:
    return torch.rand(shape, generator=torch.Generator().manual_seed(seed))


# (B, C, H, W) float32, finite


def test_a_batch_that_keeps_the_contract_passes_unchanged() -> None:
    images = noise(2, 3, 4, 5)
    assert check_images(images) is images


@pytest.mark.parametrize(
    ("images", "message"),
    [
        pytest.param(
            torch.zeros(3, 4, 4), r"got shape \(3, 4, 4\), wanted \(B, 3, H, W\)", id="3d"
        ),
        pytest.param(torch.zeros(1, 4, 4, 3), r"wanted \(B, 3, H, W\)", id="channels last"),
        pytest.param(torch.zeros(1, 3, 0, 4), r"got shape \(1, 3, 0, 4\)", id="empty"),
        pytest.param(torch.zeros(0, 3, 4, 4), r"got shape \(0, 3, 4, 4\)", id="no image"),
        pytest.param(torch.zeros(1, 3, 4, 4).double(), "got torch.float64", id="float64"),
        pytest.param(torch.zeros(1, 3, 4, 4).byte(), "got torch.uint8", id="uint8"),
    ],
)
def test_a_broken_batch_is_refused_by_name(images: torch.Tensor, message: str) -> None:
    with pytest.raises(ImageContractError, match=message) as caught:
        check_images(images, name="probes")
    assert str(caught.value).startswith("probes: ")


def test_a_contract_error_is_a_value_error_and_the_users() -> None:
    assert issubclass(ImageContractError, ValueError)
    assert issubclass(ImageContractError, InputError)


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -float("inf")])
def test_a_non_finite_pixel_is_named_by_its_place(value: float) -> None:
    images = torch.zeros(2, 3, 4, 5)
    images[1, 2, 3, 4] = value
    with pytest.raises(NonFiniteError, match=r"in image 1, channel 2, \(4, 3\)"):
        check_images(images)


@pytest.mark.parametrize("strange", ["sparse", "meta"])
def test_what_has_no_plain_values_is_refused(strange: str) -> None:
    images = noise(1, 3, 4, 4)
    given = images.to_sparse() if strange == "sparse" else images.to("meta")
    with pytest.raises(ImageContractError, match="without plain values"):
        check_images(given)


def test_the_number_of_channels_is_an_argument() -> None:
    assert check_images(torch.zeros(1, 1, 2, 2), channels=1).shape == (1, 1, 2, 2)


def test_what_is_no_tensor_is_refused() -> None:
    with pytest.raises(ImageContractError, match=r"wanted a torch\.Tensor"):
        check_images([[[[0.5]]]])
    with pytest.raises(ImageContractError, match=r"got ndarray, wanted a torch\.Tensor"):
        check_images(np.zeros((1, 3, 2, 2), np.float32))


# srgb in [0, 1]


@pytest.mark.parametrize("excess", [0.0, 9e-6], ids=["exact", "rounded"])
def test_srgb_may_leave_its_range_by_rounding_only(excess: float) -> None:
    srgb = torch.tensor([-excess, 1 + excess]).expand(1, 3, 1, 2)
    assert check_srgb(srgb) is srgb


@pytest.mark.parametrize(
    ("srgb", "found"),
    [
        (torch.full((1, 3, 2, 2), 1.0001), "1.0001 to 1.0001"),
        (torch.linspace(0, 255, 12).view(1, 3, 2, 2), "0 to 255"),
        (torch.linspace(-1, 1, 12).view(1, 3, 2, 2), "-1 to 1"),
    ],
    ids=["overshoot", "0..255", "-1..1"],
)
def test_srgb_of_another_range_is_refused_not_rescaled(srgb: torch.Tensor, found: str) -> None:
    with pytest.raises(ImageContractError, match=rf"faces: got values {found}, wanted \[0, 1\]"):
        check_srgb(srgb, name="faces")


def test_srgb_that_needs_a_gradient_is_refused_unless_that_is_said() -> None:
    srgb = torch.zeros(1, 3, 2, 2, requires_grad=True)
    with pytest.raises(ImageContractError, match=r"needs a gradient, .*\[0, 1\]; give its .detach"):
        check_srgb(srgb)
    assert check_srgb(srgb, may_need_gradient=True) is srgb


def test_srgb_keeps_the_rest_of_the_contract() -> None:
    with pytest.raises(ImageContractError, match=r"got torch.bfloat16, wanted"):
        check_srgb(torch.zeros(1, 3, 2, 2, dtype=torch.bfloat16))
    with pytest.raises(NonFiniteError, match="nan in image 0"):
        check_srgb(torch.full((1, 3, 2, 2), float("nan")))


# linear and srgb


@pytest.mark.parametrize(
    ("linear", "srgb"),
    # IEC 61966-2-1, computed with the standard's own formula in 50 digits.
    [(0.0, 0.0), (0.0031308, 0.0404499), (0.18, 0.4613561), (0.5, 0.7353570), (1.0, 1.0)],
)
def test_srgb_curve_values(linear: float, srgb: float) -> None:
    assert float(linear_to_srgb(torch.tensor(linear))) == pytest.approx(srgb, abs=2e-6)
    assert float(srgb_to_linear(torch.tensor(srgb))) == pytest.approx(linear, abs=2e-6)


def test_srgb_decoding_inverts_encoding() -> None:
    linear = torch.linspace(0, 1, 1001)
    assert torch.allclose(srgb_to_linear(linear_to_srgb(linear)), linear, atol=1e-6)


def test_srgb_encoding_rises_everywhere() -> None:
    assert bool((linear_to_srgb(torch.linspace(0, 1, 10001)).diff() > 0).all())


def test_srgb_encoding_clips_what_lies_outside() -> None:
    assert linear_to_srgb(torch.tensor([-1.0, 7.0])).tolist() == pytest.approx([0.0, 1.0])


def test_srgb_encoding_has_a_finite_slope_at_black() -> None:
    linear = torch.full((1,), 1e-9, requires_grad=True)
    linear_to_srgb(linear).sum().backward()
    assert linear.grad is not None
    assert float(linear.grad) == pytest.approx(12.92)


# BT.601 studio range


def test_ycbcr_is_that_of_scikit_image() -> None:
    srgb = noise(2, 3, 8, 9)
    wanted = rgb2ycbcr(srgb.double().numpy(), channel_axis=1) / 255
    np.testing.assert_allclose(rgb_to_ycbcr(srgb).numpy(), wanted, atol=1e-6)


@pytest.mark.parametrize(
    ("rgb", "y"), [((0, 0, 0), 16), ((1, 1, 1), 235), ((1, 0, 0), 81.481), ((0, 1, 0), 144.553)]
)
def test_luminance_values(rgb: tuple[float, float, float], y: float) -> None:
    srgb = torch.tensor(rgb, dtype=torch.float32)[None, :, None, None]
    assert float(luminance(srgb)) * 255 == pytest.approx(y, abs=1e-3)


def test_ycbcr_goes_back_to_rgb() -> None:
    srgb = noise(1, 3, 5, 5)
    assert torch.allclose(ycbcr_to_rgb(rgb_to_ycbcr(srgb)), srgb, atol=1e-5)


def test_ycbcr_to_rgb_does_not_clip() -> None:
    assert float(ycbcr_to_rgb(torch.ones(1, 3, 1, 1)).max()) > 1


@pytest.mark.parametrize("convert", [rgb_to_ycbcr, ycbcr_to_rgb, luminance])
def test_colour_conversions_refuse_a_broken_batch(
    convert: Callable[[torch.Tensor], torch.Tensor],
) -> None:
    with pytest.raises(ImageContractError, match="wanted"):
        convert(torch.zeros(1, 1, 4, 4))


# points


def test_points_scale_about_the_corner_of_the_film() -> None:
    # The centre of the first pixel of a film lies, on one 4 times finer, between pixels 1 and 2.
    assert scale_points(torch.zeros(2), 4).tolist() == [1.5, 1.5]


@given(st.floats(-1e3, 1e3), st.sampled_from([0.25, 0.5, 2.0, 4.0]))
@settings(deadline=None)
def test_scaling_points_there_and_back_changes_nothing(x: float, scale: float) -> None:
    point = torch.tensor([x], dtype=torch.float64)
    assert scale_points(scale_points(point, scale), 1 / scale).tolist() == pytest.approx([x])


def test_a_spot_is_found_where_its_point_is_scaled_to() -> None:
    image = torch.zeros(1, 1, 9, 9)
    image[..., 3, 5] = 1.0
    large = resize_bicubic(image, 4)[0, 0]
    mass = large.sum()
    axis = torch.arange(36.0)
    found = torch.stack([(large.sum(0) * axis).sum() / mass, (large.sum(1) * axis).sum() / mass])
    assert torch.allclose(found, scale_points(torch.tensor([5.0, 3.0]), 4), atol=1e-4)


# the one bicubic


@pytest.mark.parametrize("scale", [2, 4, 3, 1, 0.5, 0.25], ids=str)
def test_bicubic_is_the_formula_of_keys_with_edges_repeated(scale: float) -> None:
    image = noise(1, 1, 12, 8, seed=3)
    wanted = bicubic.resize(image[0, 0].double().numpy(), scale)
    np.testing.assert_allclose(resize_bicubic(image, scale)[0, 0].numpy(), wanted, atol=2e-6)


def test_bicubic_agrees_with_torch_away_from_the_border() -> None:
    image = noise(2, 3, 10, 12)
    plain = torch.nn.functional.interpolate(
        image, scale_factor=2, mode="bicubic", antialias=True, align_corners=False
    )
    difference = (resize_bicubic(image, 2) - plain).abs()
    assert float(difference[..., 4:-4, 4:-4].max()) < 1e-6


@pytest.mark.parametrize("scale", [2, 4, 0.5], ids=str)
def test_bicubic_keeps_a_flat_image_flat(scale: float) -> None:
    assert torch.allclose(resize_bicubic(torch.full((1, 3, 8, 8), 0.3), scale), torch.tensor(0.3))


def test_bicubic_keeps_a_ramp_inside_a_ramp() -> None:
    ramp = torch.arange(16.0).expand(1, 1, 4, 16).contiguous()
    wanted = scale_points(torch.arange(32.0), 0.5)
    assert torch.allclose(resize_bicubic(ramp, 2)[0, 0, 0, 4:-4], wanted[4:-4], atol=1e-5)


def test_bicubic_enlarges_a_single_pixel() -> None:
    large = resize_bicubic(torch.full((1, 3, 1, 1), 0.7), 4)
    assert torch.allclose(large, torch.full((1, 3, 4, 4), 0.7))


def test_bicubic_commutes_with_luminance() -> None:
    srgb = noise(1, 3, 8, 8)
    one, other = luminance(resize_bicubic(srgb, 2)), resize_bicubic(luminance(srgb), 2)
    assert torch.allclose(one, other, atol=1e-6)


@pytest.mark.parametrize("scale", [0.3, 0.0, -2.0, 1.1], ids=str)
def test_bicubic_refuses_a_size_that_is_not_whole(scale: float) -> None:
    with pytest.raises(ImageContractError, match="is not a whole size"):
        resize_bicubic(torch.zeros(1, 3, 8, 8), scale)


@pytest.mark.parametrize(
    "two", [np.float32(2), np.array(2), torch.tensor(2), Fraction(2)], ids=repr
)
def test_a_scale_may_be_of_any_width(two: float) -> None:
    images, points = noise(1, 3, 4, 4), noise(5, 2)
    assert torch.equal(resize_bicubic(images, two), resize_bicubic(images, 2))
    assert torch.equal(scale_points(points, two), scale_points(points, 2))


@pytest.mark.parametrize("scale", [None, "2", float("nan"), float("inf"), [2], True], ids=repr)
def test_a_scale_is_a_number(scale: float) -> None:
    with pytest.raises(ImageContractError, match=r"scale=.*: wanted a number"):
        resize_bicubic(noise(1, 3, 4, 4), scale)


@pytest.mark.parametrize("images", [None, [[[[0.5]]]]])
def test_bicubic_refuses_what_is_no_tensor(images: torch.Tensor) -> None:
    with pytest.raises(ImageContractError, match=r"wanted a torch\.Tensor"):
        resize_bicubic(images, 2)


def test_bicubic_refuses_a_single_image() -> None:
    with pytest.raises(ImageContractError, match="wanted"):
        resize_bicubic(torch.zeros(3, 8, 8), 2)
