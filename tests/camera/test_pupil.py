"""The pupil's Fourier transform against Airy, Maréchal and geometrical optics."""

import math

import pytest
import torch

from lrsr.camera.aberrations import Seidel, defocus_waves
from lrsr.camera.diffraction import airy_kernel
from lrsr.camera.pupil import _pupil_transmission, pupil_kernel
from lrsr.errors import InputError

AXIS = torch.zeros(1, 2, dtype=torch.float64)


def spread(seidel: Seidel, pitch_um: float, radius_px: int, size: int = 96) -> torch.Tensor:
    return pupil_kernel(seidel.waves(AXIS, size), 1.4, 550, pitch_um, radius_px)[0, 0]


@pytest.mark.parametrize("pitch_um", [0.2, 0.6625, 1.325, 2.65])
def test_a_perfect_pupil_gives_airys_disk(pitch_um: float) -> None:
    reach = math.ceil(8 / pitch_um)
    airy = airy_kernel(1.4, 550, pitch_um, reach)
    perfect = spread(Seidel(), pitch_um, reach)
    assert float((perfect - airy).abs().max() / airy.max()) < 0.01


@pytest.mark.parametrize(
    ("seidel", "variance"),
    [
        (Seidel(defocus=0.1), 0.1**2 / 12),
        (Seidel(defocus=-0.15), 0.15**2 / 12),
        (Seidel(spherical=0.4, defocus=-0.4), 0.4**2 / 180),
        (Seidel(spherical=0.1), 0.1**2 * 4 / 45),
    ],
    ids=["defocus", "before the film", "balanced spherical", "spherical"],
)
def test_strehl_follows_marechal(seidel: Seidel, variance: float) -> None:
    # Variances over the pupil: Mahajan, Optical Imaging and Aberrations, table 8-1.
    strehl = float(spread(seidel, 0.1, 120)[120, 120] / spread(Seidel(), 0.1, 120)[120, 120])
    assert strehl == pytest.approx(math.exp(-((2 * math.pi) ** 2) * variance), abs=0.01)
    assert strehl < 0.98


@pytest.mark.parametrize("shift_um", [60.0, -80.0])
def test_much_defocus_gives_the_geometric_disk(shift_um: float) -> None:
    defocus = float(defocus_waves(shift_um, 1.4, 550))
    pitch, radius = 1.0, abs(shift_um) / 1.4 / 2
    reach = math.ceil(radius + 13)
    kernel = spread(Seidel(defocus=defocus), pitch, reach, size=144)
    places = torch.arange(-reach, reach + 1) * pitch
    distance = torch.hypot(places[:, None], places)
    # A disk of even light: a quarter within half its radius, nearly nothing outside.
    assert float(kernel[distance <= radius / 2].sum()) == pytest.approx(0.25, abs=0.03)
    assert float(kernel[distance <= radius / 2**0.5].sum()) == pytest.approx(0.5, abs=0.03)
    assert float(kernel[distance > radius * 1.1].sum()) < 0.04


def test_the_kernel_keeps_the_light() -> None:
    kernel = spread(Seidel(1.0, 0.5, 0.0, 0.0), 1.0, 12)
    assert float(kernel.sum()) == pytest.approx(1)
    assert float(kernel.min()) >= 0


def test_the_comas_tail_points_outwards() -> None:
    right = torch.tensor([[1.0, 0.0]], dtype=torch.float64)
    kernel = pupil_kernel(Seidel(coma=1.5).waves(right, 96), 1.4, 550, 0.5, 20)[0, 0]
    places = torch.arange(-20, 21).double()
    assert float((kernel.sum(0) * places).sum()) > 1  # columns: right
    assert float((kernel.sum(1) * places).sum()) == pytest.approx(0, abs=1e-9)


def test_astigmatism_smears_along_the_field_where_the_other_focus_lies() -> None:
    right = torch.tensor([[1.0, 0.0]], dtype=torch.float64)
    kernel = pupil_kernel(Seidel(astigmatism=2.0).waves(right, 96), 1.4, 550, 0.5, 20)[0, 0]
    places = torch.arange(-20, 21).double() ** 2
    assert float((kernel.sum(0) * places).sum()) > 3 * float((kernel.sum(1) * places).sum())


def test_the_pupils_area_is_a_circles() -> None:
    assert float(_pupil_transmission(48).sum() / 48**2) == pytest.approx(math.pi / 4, rel=1e-3)
    assert _pupil_transmission(1).tolist() == [[1.0]]


def test_impossible_pixels_are_refused() -> None:
    with pytest.raises(InputError, match="pitch_um 0"):
        pupil_kernel(torch.zeros(4, 4), 1.4, 550, 0.0, 1)
