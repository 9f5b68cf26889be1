"""A perfect lens: the Airy disk of the text books, whole pixels of it."""

import math

import pytest
import torch
from scipy import special

from lrsr.camera.diffraction import (
    _diffraction_transfer,
    airy_kernel,
    diffraction_length_um,
    numerical_aperture,
)
from lrsr.errors import InputError


def test_the_papers_aperture_and_first_minimum() -> None:
    assert numerical_aperture(1.4) == pytest.approx(1 / math.sqrt(4 * 1.4**2 + 1))
    assert 1.22 * diffraction_length_um(1.4, 700) == pytest.approx(1.27, abs=0.005)


@pytest.mark.parametrize("radius_um", [0.4, 0.8, 1.0, 1.5, 2.0, 4.0])
def test_the_kernel_holds_the_analytic_energy_within_one_percent(radius_um: float) -> None:
    pitch, reach = 0.04, 400
    kernel = airy_kernel(1.4, 550, pitch, reach)
    places = torch.arange(-reach, reach + 1, dtype=torch.float64) * pitch
    distance = torch.hypot(places[:, None], places)
    edge = torch.tensor([radius_um, reach * pitch], dtype=torch.float64)
    x = (2 * math.pi * numerical_aperture(1.4) * edge / 0.55).numpy()
    within, whole = 1 - special.j0(x) ** 2 - special.j1(x) ** 2
    share = kernel[distance <= radius_um].sum() / kernel[distance <= reach * pitch].sum()
    assert float(share) == pytest.approx(within / whole, rel=0.01)


def test_fine_pixels_see_the_airy_pattern_itself() -> None:
    pitch, reach = 0.05, 30
    row = airy_kernel(2.0, 550, pitch, reach)[reach]
    x = 2 * math.pi * numerical_aperture(2.0) * torch.arange(1, reach + 1).numpy() * pitch / 0.55
    pattern = torch.tensor((2 * special.j1(x) / x) ** 2)
    assert torch.allclose(row[reach + 1 :] / row[reach], pattern, atol=0.01)


def test_a_pixel_gathers_what_finer_ones_gather_together() -> None:
    fine = airy_kernel(2.8, 550, 1.0 / 3, 31)
    coarse = airy_kernel(2.8, 550, 1.0, 10)
    together = torch.nn.functional.avg_pool2d(fine[None, None], 3)[0, 0] * 9
    # Both are normalised over the same square.
    assert torch.allclose(together, coarse, atol=1e-5)


@pytest.mark.parametrize("f_number", [1.0, 1.4, 5.6])
def test_the_kernel_keeps_the_light_and_is_symmetric(f_number: float) -> None:
    kernel = airy_kernel(f_number, 550, 1.3, 7)
    assert float(kernel.sum()) == pytest.approx(1)
    assert float(kernel.min()) >= 0
    assert torch.allclose(kernel, kernel.T)
    assert torch.allclose(kernel, kernel.flip(0))


def test_narrower_stops_and_longer_waves_spread_the_light() -> None:
    middles = [float(airy_kernel(n, 550, 1.0, 5)[5, 5]) for n in (1.4, 2.8, 5.6)]
    assert middles == sorted(middles, reverse=True)
    assert airy_kernel(2.8, 464, 1.0, 5)[5, 5] > airy_kernel(2.8, 611, 1.0, 5)[5, 5]


def test_the_transfer_is_the_energys_spectrum() -> None:
    # Total of the transfer over the plane = the Airy disk's peak: π/4 for one unit of light.
    frequency = torch.linspace(0, 1, 4001, dtype=torch.float64)
    peak = torch.trapezoid(_diffraction_transfer(frequency) * 2 * math.pi * frequency, frequency)
    assert float(peak) == pytest.approx(math.pi / 4, rel=1e-4)


def test_a_kernel_of_one_pixel_takes_all() -> None:
    assert airy_kernel(1.4, 550, 2.65, 0).tolist() == [[1.0]]


@pytest.mark.parametrize("f_number", [0.0, -1.0, float("nan"), float("inf")])
def test_an_impossible_f_number_is_refused(f_number: float) -> None:
    for call in (numerical_aperture, lambda n: diffraction_length_um(n, 550)):
        with pytest.raises(InputError, match="f_number"):
            call(f_number)


def test_impossible_lengths_are_refused() -> None:
    with pytest.raises(InputError, match="wavelength_nm -5"):
        diffraction_length_um(1.4, -5)
    with pytest.raises(InputError, match="wavelength_nm 0"):
        diffraction_length_um(1.4, 0)
    with pytest.raises(InputError, match="pitch_um 0"):
        airy_kernel(1.4, 550, 0, 3)
