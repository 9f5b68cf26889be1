"""Eight bits, and a gradient where one is asked for."""

import pytest
import torch

from lrsr.camera.encoding import encode, quantise
from lrsr.images import linear_to_srgb

LINEAR = torch.linspace(-0.5, 1.5, 4001)


@pytest.mark.parametrize("differentiable", [False, True])
def test_the_result_is_one_of_256_levels(differentiable: bool) -> None:
    levels = encode(LINEAR, differentiable=differentiable) * 255
    assert torch.allclose(levels, levels.round(), atol=1e-4)
    assert (float(levels.min()), float(levels.max())) == (0.0, 255.0)


def test_rounding_moves_no_value_by_more_than_half_a_level() -> None:
    srgb = torch.linspace(0, 1, 10001)
    assert float((quantise(srgb) - srgb).abs().max()) <= 0.5 / 255 + 1e-6


def test_middle_grey_is_level_118() -> None:
    # 18 % grey encodes to 0.4613561 (IEC 61966-2-1), times 255 = 117.6.
    assert float(encode(torch.tensor(0.18)) * 255) == pytest.approx(118.0)


def test_straight_through_gives_the_very_same_values() -> None:
    assert torch.equal(encode(LINEAR, differentiable=True), encode(LINEAR))


def test_straight_through_has_the_gradient_of_the_curve() -> None:
    rounded = LINEAR.clone().requires_grad_()
    encode(rounded, differentiable=True).sum().backward()
    smooth = LINEAR.clone().requires_grad_()
    linear_to_srgb(smooth).sum().backward()
    assert rounded.grad is not None
    assert smooth.grad is not None
    assert torch.equal(rounded.grad, smooth.grad)
    assert float(rounded.grad.max()) > 1


def test_plain_rounding_has_no_gradient() -> None:
    srgb = torch.full((1,), 0.3, requires_grad=True)
    quantise(srgb).sum().backward()
    assert srgb.grad is not None
    assert float(srgb.grad) == 0.0
