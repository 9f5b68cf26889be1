"""How fast is the lens? 1000 probes of 32x32 through all of it, in one place or each in its own."""

import pytest
import torch
from pytest_benchmark.fixture import BenchmarkFixture

from lrsr.camera.optics import Optics, bin_pixels

LENS = Optics(
    f_number=1.4,
    defocus_um=4.0,
    axial_colour_um=(5.0, 0.0, 8.0),
    spherical_waves=0.3,
    coma_waves=0.8,
    astigmatism_waves=0.5,
    curvature_waves=0.4,
    distortion=(-0.185, 0.812),
    lateral_colour_um=(2.0, 0.0, -3.0),
    natural_vignetting=True,
    rim_radius_mm=1.5,
    rim_distance_mm=1.0,
)
PROBES = 1000


@pytest.mark.benchmark(group="optics, 1000 images of 32x32")
@pytest.mark.parametrize("places", ["alike", "each"])
@pytest.mark.parametrize("supersampling", [2, 4])
def test_optics(benchmark: BenchmarkFixture, supersampling: int, places: str) -> None:
    side = 32 * supersampling
    film = torch.rand(PROBES, 3, side, side, generator=torch.Generator().manual_seed(0))
    fields = torch.rand(PROBES, 2, generator=torch.Generator().manual_seed(1))
    field_mm = (0.5, 0.5) if places == "alike" else fields

    def expose() -> torch.Tensor:
        with torch.no_grad():
            return bin_pixels(
                LENS(film, supersampling=supersampling, field_mm=field_mm), supersampling
            )

    result = benchmark.pedantic(expose, rounds=2)
    assert result.shape == (PROBES, 3, 32, 32)
