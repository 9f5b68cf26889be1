import math

import pytest
import torch

from lrsr.calibration.band_powers import band_powers

EDGES = (0.5, 2.5, 6.0, 10.0)


def planes(count: int = 40, side: int = 24) -> torch.Tensor:
    generator = torch.Generator().manual_seed(4)
    return torch.randn(count, side, side, generator=generator, dtype=torch.float64)


def test_white_noise_has_its_variance_in_every_band() -> None:
    powers = band_powers(3 * planes(), planes(), EDGES, floor=0.0).exp().mean(0)
    halves = powers.reshape(3, 2, 2).mean(2)  # of quiet and busy
    assert torch.allclose(halves / 9, torch.tensor(1.0).double(), rtol=0.04)


def test_quiet_blocks_hold_less_than_busy_ones() -> None:
    powers = band_powers(planes(), planes(), EDGES, floor=0.0).reshape(-1, 3, 2, 2)
    assert bool((powers[..., 0] < powers[..., 1]).all())


def test_twice_the_signal_has_four_times_the_power() -> None:
    once, twice = (band_powers(k * planes(), planes(), EDGES, floor=0.0) for k in (1, 2))
    assert torch.allclose(twice - once, torch.tensor(math.log(4)).double())


def test_a_wave_is_in_the_band_of_its_frequency() -> None:
    x = torch.arange(24, dtype=torch.float64)
    wave = torch.cos(2 * torch.pi * 0.25 * x).expand(1, 24, 24)  # 4 half cycles in 8 pixels
    powers = band_powers(wave, planes(1), EDGES, floor=1e-9).exp().reshape(3, 4).mean(1)
    assert int(powers.argmax()) == 1


def test_noise_in_the_bright_half_is_found_there() -> None:
    brightness = torch.arange(24, dtype=torch.float64).expand(40, 24, 24)
    noise = planes() * (brightness > 12)
    dark, bright = band_powers(noise, brightness, EDGES, floor=1e-6).reshape(-1, 3, 2, 2).unbind(2)
    assert bool((bright.mean((0, 2)) > dark.mean((0, 2)) + 3).all())


def test_a_flat_plane_has_the_floor() -> None:
    flat = torch.ones(1, 10, 10, dtype=torch.float64)
    assert band_powers(flat, flat, EDGES, floor=0.25).exp().numpy() == pytest.approx(0.25)
