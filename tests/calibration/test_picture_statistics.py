import math

import pytest
import torch

from lrsr.calibration.picture_statistics import (
    BENT_NAMES,
    NAMES,
    RANGES,
    RINGS,
    bend,
    crop,
    describe,
    leave_one_out,
)
from lrsr.errors import ImageContractError, InputError

RINGS_COUNT = len(RINGS) - 1
FIRST_BENT = NAMES.index("log_red_green")


def grey_noise(sigma_levels: float, count: int = 100) -> torch.Tensor:
    generator = torch.Generator().manual_seed(1)
    noise = torch.randn(count, 1, 32, 32, generator=generator) * sigma_levels / 255
    return (0.5 + noise).expand(-1, 3, -1, -1)


@pytest.mark.parametrize("sigma", [2.0, 8.0])
def test_white_noise_has_its_variance_in_every_ring_and_range(sigma: float) -> None:
    numbers = describe(grey_noise(sigma)).exp().mean(0)
    assert torch.allclose(numbers[:RINGS_COUNT] / sigma**2, torch.tensor(1.0).double(), rtol=0.1)
    noise = numbers[RINGS_COUNT : RINGS_COUNT + RANGES] / sigma**2
    assert torch.allclose(noise, torch.tensor(1.0).double(), rtol=0.15)


def test_twice_the_red_light_is_a_red_green_ratio_twice_as_high() -> None:
    red = NAMES.index("log_red_green")
    light = torch.full((2, 3, 16, 16), 0.2)
    light[1, 0] = 0.4
    srgb = torch.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    once, twice = describe(srgb)[:, red].tolist()
    assert twice - once == pytest.approx(math.log(2), abs=1e-3)


def test_quantiles_of_a_ramp_are_its_levels() -> None:
    ramp = torch.linspace(0, 1, 21)[None, None, None].expand(1, 3, 21, 21)
    first = NAMES.index("luminance_5")
    found = (describe(ramp, part=1.0)[0, first : first + 5] / 255).tolist()
    assert found == pytest.approx([0.05, 0.25, 0.5, 0.75, 0.95], abs=0.005)


def column(numbers: torch.Tensor, name: str) -> torch.Tensor:
    return numbers[:, NAMES.index(name)]


def test_a_colour_that_grows_with_brightness_has_its_slope() -> None:
    light = torch.rand(3, 1, 20, 20, generator=torch.Generator().manual_seed(2))
    srgb = light * torch.tensor([0.9, 0.6, 0.3])[:, None, None]
    luma = 0.299 * 0.9 + 0.587 * 0.6 + 0.114 * 0.3
    numbers = describe(srgb, part=1.0)
    for name, level in (("red", 0.9), ("blue", 0.3)):
        slope = column(numbers, f"slope_{name}_luma").tolist()
        assert slope == pytest.approx([(level - luma) / luma] * 3, rel=1e-3)
    assert column(numbers, "correlation_red_blue").tolist() == pytest.approx([-1.0] * 3, abs=1e-3)


def test_the_halves_have_their_own_colours() -> None:
    srgb = torch.full((1, 3, 20, 20), 0.25)
    srgb[:, :, 10:] = 0.5
    srgb[:, 0, 10:] = 0.7  # the brighter half is red
    numbers, luma = describe(srgb, part=1.0), 0.701 * 0.5 + 0.299 * 0.7
    assert float(column(numbers, "mean_red_dark")) == pytest.approx(0, abs=1e-4)
    assert float(column(numbers, "mean_red_bright")) == pytest.approx(255 * (0.7 - luma), rel=1e-4)
    assert float(column(numbers, "mean_blue_bright")) == pytest.approx(255 * (0.5 - luma), rel=1e-4)


def test_bending_adds_squares_limits_and_a_product() -> None:
    numbers = torch.zeros(1, len(NAMES), dtype=torch.float64)
    red, blue = NAMES.index("log_red_green"), NAMES.index("log_blue_green")
    numbers[0, red], numbers[0, blue] = 1.5, -2.0
    typical = torch.stack([torch.full((len(NAMES),), 0.5), torch.full((len(NAMES),), 0.5)]).double()
    bent = bend(numbers, typical)[0]
    names = list(BENT_NAMES)
    assert torch.equal(bent[: len(NAMES)], numbers[0])
    assert float(bent[names.index("square_log_red_green")]) == pytest.approx(2.0**2)
    assert float(bent[names.index("limited_log_red_green")]) == pytest.approx(math.tanh(2))
    assert float(bent[names.index("product_red_blue")]) == pytest.approx(2.0 * -5.0)


def test_each_is_left_out_of_its_own_mean_and_deviation() -> None:
    numbers = torch.randn(7, 3, dtype=torch.float64, generator=torch.Generator().manual_seed(3))
    for k in range(7):
        left = torch.cat([numbers[:k], numbers[k + 1 :]])
        assert torch.allclose(
            leave_one_out(numbers)[:, k], torch.stack([left.mean(0), left.std(0)])
        )


def test_squares_of_pictures_and_of_strangers_have_the_same_mean() -> None:
    # Of a normal variable, 12 and 12 people, 300 times: 1.32 and 1.36; were each picture's distance
    # taken from a mean that it is part of, 0.92.
    generator = torch.Generator().manual_seed(5)
    squares = slice(len(NAMES), 2 * len(NAMES) - FIRST_BENT)
    means = []
    for _ in range(300):
        real, strangers = torch.randn(2, 12, len(NAMES), generator=generator).double()
        typical = torch.stack([real.mean(0), real.std(0)])
        both = bend(real, leave_one_out(real)), bend(strangers, typical)
        means.append(torch.stack([one[:, squares].mean() for one in both]))
    of_pictures, of_strangers = torch.stack(means).mean(0)
    assert float(of_pictures) == pytest.approx(float(of_strangers), rel=0.08)


def test_a_column_that_never_changes_can_be_bent() -> None:
    numbers = torch.zeros(2, len(NAMES), dtype=torch.float64)
    assert bool(bend(numbers, torch.zeros(2, len(NAMES))).isfinite().all())


def test_every_column_has_one_name() -> None:
    assert describe(grey_noise(2.0, 2)).shape == (2, len(NAMES))
    assert len(set(BENT_NAMES)) == len(BENT_NAMES)


def test_what_lies_outside_the_middle_does_not_count() -> None:
    pictures = grey_noise(3.0, 4)
    framed = pictures.clone()
    framed[..., :4, :], framed[..., :, -4:] = 1.0, 0.0
    assert torch.equal(describe(pictures), describe(framed))


def test_numbers_belong_to_one_picture_alone() -> None:
    pictures = grey_noise(3.0, 4)
    assert torch.allclose(describe(pictures)[2:3], describe(pictures[2:3]), atol=1e-9)


def test_the_middle_of_a_small_picture_is_refused() -> None:
    with pytest.raises(ImageContractError, match="under 12 px"):
        describe(torch.zeros(1, 3, 14, 14))


@pytest.mark.parametrize("part", [0.0, 1.5])
def test_no_part_of_a_picture_is_refused(part: float) -> None:
    with pytest.raises(InputError, match="share"):
        crop(torch.zeros(1, 3, 32, 32), part)


def test_pictures_of_one_channel_are_refused() -> None:
    with pytest.raises(ImageContractError, match="srgb"):
        describe(torch.zeros(1, 1, 32, 32))
