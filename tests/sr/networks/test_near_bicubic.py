import numpy as np
import pytest
import torch
from scipy.interpolate import CubicHermiteSpline
from torch import nn

from lrsr.images import resize_bicubic
from lrsr.sr.networks.near_bicubic import (
    _three_taps,
    keys,
    let_colours_grow,
    let_colours_pass,
    quieten,
)


def test_keys_is_the_hermite_spline_through_one_pixel() -> None:
    """Slopes of Keys' cubic are half the difference of the neighbours: a = -0.5."""
    knots = np.arange(-3, 4)
    spline = CubicHermiteSpline(knots, (knots == 0) * 1.0, (knots == -1) * 0.5 - (knots == 1) * 0.5)
    x = np.linspace(-2.9, 2.9, 59)
    np.testing.assert_allclose(keys(torch.from_numpy(x)).numpy(), spline(x), atol=1e-12)


@pytest.mark.parametrize("scale", [2, 3, 4])
def test_taps_keep_a_flat_picture_and_a_slope(scale: int) -> None:
    for pixel, taps in enumerate(_three_taps(scale)):
        assert float(taps.sum()) == pytest.approx(1.0)
        place = (pixel + 0.5) / scale - 0.5
        assert float(taps @ torch.tensor([-1.0, 0.0, 1.0])) == pytest.approx(place, abs=0.08)


@pytest.mark.parametrize("scale", [2, 3, 4])
def test_colours_pass_and_grow_into_bicubic(scale: int) -> None:
    torch.manual_seed(0)
    head, step = nn.Conv2d(3, 8, 3, padding=1), nn.Conv2d(8, 3 * scale**2, 3, padding=1)
    let_colours_pass(head)
    let_colours_grow(step, scale)
    noise = torch.rand(1, 3, 20, 20, generator=torch.Generator().manual_seed(0))
    smooth = nn.functional.avg_pool2d(noise, 5, 1)
    with torch.no_grad():
        features = head(smooth)
        assert torch.equal(features[:, :3], smooth)
        larger = nn.functional.pixel_shuffle(step(features), scale)
    inside = (..., slice(2 * scale, -2 * scale), slice(2 * scale, -2 * scale))
    assert float((larger - resize_bicubic(smooth, scale))[inside].abs().max()) < 0.03


def test_a_quiet_layer_says_a_hundredth() -> None:
    layer = nn.Conv2d(2, 2, 1)
    loud = layer.weight.clone()
    quieten(layer)
    torch.testing.assert_close(layer.weight, loud / 100)
