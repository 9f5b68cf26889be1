"""The whole lens: what is off changes nothing, what is on does what its part does."""

import math
from typing import Any

import pytest
import torch
from hydra.utils import instantiate
from omegaconf import OmegaConf

from lrsr.camera.optics import Optics, bin_pixels
from lrsr.errors import ImageContractError, InputError

RANDOM = torch.Generator().manual_seed(0)
LIGHT = torch.rand(2, 3, 12, 16, generator=RANDOM)
BARREL = (-0.185, 0.812)
ALL: dict[str, Any] = {
    "f_number": 1.4,
    "defocus_um": 4.0,
    "axial_colour_um": [5.0, 0.0, 8.0],
    "spherical_waves": 0.3,
    "coma_waves": 0.8,
    "astigmatism_waves": 0.5,
    "curvature_waves": 0.4,
    "distortion": list(BARREL),
    "lateral_colour_um": [2.0, 0.0, -3.0],
    "natural_vignetting": True,
    "rim_radius_mm": 1.5,
    "rim_distance_mm": 1.0,
}
BLURS = ["defocus_um", "axial_colour_um", "spherical_waves", "coma_waves", "curvature_waves"]


def moments(light: torch.Tensor) -> tuple[list[float], list[float]]:
    """Return each colour's centre (x, y) of one image, px."""
    share = light[0] / light[0].sum((-2, -1), keepdim=True)
    height, width = light.shape[-2:]
    x = (share.sum(-2) * torch.arange(float(width))).sum(-1)
    y = (share.sum(-1) * torch.arange(float(height))).sum(-1)
    return x.tolist(), y.tolist()


def spot(side: int, x: float, y: float, sigma: float) -> torch.Tensor:
    places = torch.arange(float(side))
    square = (places - x) ** 2 + (places[:, None] - y) ** 2
    return torch.exp(-square / (2 * sigma**2)).expand(1, 3, side, side)


def test_an_ideal_lens_is_the_identity() -> None:
    off = {
        name: None if name == "f_number" else [0.0] * len(value) if isinstance(value, list) else 0
        for name, value in ALL.items()
    }
    for ideal in (Optics(), Optics(**off)):
        assert ideal(LIGHT, supersampling=2, field_mm=(2.0, 1.0)) is LIGHT


def test_hydra_builds_it_from_plain_numbers() -> None:
    optics = instantiate(OmegaConf.create({"_target_": "lrsr.camera.optics.Optics", **ALL}))
    alike = Optics(**ALL)
    place = {"supersampling": 2, "field_mm": (1.0, 0.5)}
    assert torch.equal(optics(LIGHT, **place), alike(LIGHT, **place))


@pytest.mark.parametrize("part", ["f_number", *BLURS, "distortion", "lateral_colour_um"])
def test_a_flat_picture_stays_flat_without_vignetting(part: str) -> None:
    flat = torch.full((1, 3, 9, 7), 0.6)
    optics = Optics(**{"f_number": 1.4, part: ALL[part]})
    assert torch.allclose(optics(flat, supersampling=2, field_mm=(1.5, 1.0)), flat, atol=1e-5)


@pytest.mark.parametrize(
    "part", [*BLURS, "astigmatism_waves", "distortion", "lateral_colour_um", "natural_vignetting"]
)
def test_each_part_changes_the_picture_off_the_axis(part: str) -> None:
    place: dict[str, Any] = {"supersampling": 4, "field_mm": (2.0, 1.0)}
    with_it = Optics(**{"f_number": 1.4, part: ALL[part]})(LIGHT, **place)
    without = Optics(f_number=1.4)(LIGHT, **place)
    assert float((with_it - without).abs().max()) > 0.01


def test_the_blur_keeps_the_light() -> None:
    point = torch.zeros(1, 3, 65, 65)
    point[..., 32, 32] = 1.0
    optics = Optics(f_number=1.4, coma_waves=1.0, astigmatism_waves=1.0)
    spread = optics(point, supersampling=2, field_mm=(2.0, 1.0))
    kernels = optics.point_spread(supersampling=2, field_mm=(2.0, 1.0))
    assert spread.sum((-2, -1)).flatten().tolist() == pytest.approx([1.0] * 3, abs=1e-5)
    reach = kernels.shape[-1] // 2
    middle = slice(32 - reach, 33 + reach)
    assert torch.allclose(spread[..., middle, middle], kernels, atol=1e-6)


@pytest.mark.parametrize("period_px", [4, 8, 16])
def test_stripes_keep_the_contrast_that_the_stop_passes(period_px: int) -> None:
    # Goodman, Introduction to Fourier Optics, eq. 6-31, times the film pixel's own sinc.
    places = torch.arange(240, dtype=torch.float64)
    stripes = (1 + torch.cos(2 * math.pi * places / period_px)).expand(1, 3, 1, 240)
    seen = Optics(f_number=4.0, pitch_um=2.0)(stripes, supersampling=2)[0, 1, 0, 80:160]
    frequency = 0.5491 * math.sqrt(4 * 4.0**2 + 1) / 2 / period_px  # of λ / (2A), 1 µm a pixel
    passed = 2 / math.pi * (math.acos(frequency) - frequency * math.sqrt(1 - frequency**2))
    passed *= math.sin(math.pi / period_px) / (math.pi / period_px)
    contrast = float((seen * torch.cos(2 * math.pi * places[80:160] / period_px)).mean()) * 2
    assert contrast == pytest.approx(passed, abs=0.015)


def test_a_narrower_stop_blurs_more() -> None:
    contrast = [float(Optics(n)(LIGHT, supersampling=4).std()) for n in (1.4, 4.0, 11.0)]
    assert contrast == sorted(contrast, reverse=True)


def test_points_move_with_the_picture() -> None:
    optics = Optics(distortion=BARREL, view="planar")
    place: dict[str, Any] = {"supersampling": 2, "field_mm": (2.2, 0.0)}
    moved = optics.distort_points(torch.tensor([[20.0, 60.0]]), (81, 81), **place)
    assert float((moved - torch.tensor([[20.0, 60.0]])).norm()) > 3
    x, y = moments(optics(spot(81, 20, 60, sigma=1.0), **place))
    assert [x[0], y[0]] == pytest.approx(moved[0].tolist(), abs=0.1)


def test_vignetting_is_that_of_the_place() -> None:
    # cos⁴ of atan(2.5 / 3) = 0.348 in the middle of an odd crop.
    dark = Optics(natural_vignetting=True)(
        torch.ones(1, 3, 5, 5), supersampling=1, field_mm=(1.5, 2.0)
    )
    assert dark[0, :, 2, 2].tolist() == pytest.approx([(1 + (2.5 / 3) ** 2) ** -2] * 3)
    assert dark[0, 0, 0, 0] > dark[0, 0, 4, 4]


def test_the_batch_does_not_matter() -> None:
    optics = Optics(**ALL)
    fields = torch.tensor([[2.0, 1.0], [-1.0, 0.3]])
    together = optics(LIGHT, supersampling=2, field_mm=fields)
    for index in range(2):
        alone = optics(
            LIGHT[index : index + 1],
            supersampling=2,
            field_mm=tuple(fields[index].tolist()),
        )
        assert torch.allclose(together[index], alone[0], atol=1e-6)


def test_one_pixel_passes() -> None:
    pixel = torch.full((1, 3, 1, 1), 0.5)
    assert Optics(1.4, distortion=BARREL)(pixel, supersampling=1).flatten().tolist() == (
        pytest.approx([0.5] * 3, abs=1e-5)
    )


def test_light_is_never_negative() -> None:
    edge = torch.zeros(1, 3, 16, 16)
    edge[..., 8:] = 1000.0
    result = Optics(1.4, distortion=BARREL, lateral_colour_um=(2, 0, -2))(
        edge, supersampling=1, field_mm=(2.0, 0.0)
    )
    assert float(result.min()) == 0.0


def test_bins_are_means() -> None:
    binned = bin_pixels(LIGHT, 4)
    assert torch.allclose(binned[:, :, 1, 2], LIGHT[:, :, 4:8, 8:12].mean((-2, -1)))
    assert bin_pixels(LIGHT, 1) is LIGHT


def test_a_film_of_no_whole_pixels_is_refused() -> None:
    with pytest.raises(ImageContractError, match="12x16, wanted multiples of 5"):
        bin_pixels(LIGHT, 5)
    with pytest.raises(InputError, match="supersampling=0"):
        bin_pixels(LIGHT, 0)


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ({"coma_waves": 1.0}, "coma_waves without f_number"),
        ({"axial_colour_um": (1.0, 0.0, 0.0)}, "axial_colour_um without f_number"),
        ({"rim_radius_mm": 1.0, "rim_distance_mm": 1.0}, "rim_radius_mm without f_number"),
        ({"f_number": 2.0, "rim_radius_mm": 1.0}, "give both or neither"),
        ({"f_number": 2.0, "rim_radius_mm": -1.0, "rim_distance_mm": 1.0}, "rim_radius_mm -1"),
        ({"f_number": 0.0}, "f_number 0"),
        ({"pitch_um": 0.0}, "pitch_um 0"),
        ({"view": "sideways"}, "view=sideways: wanted facing or planar"),
        ({"distortion": (1.0,)}, "distortion=.*2 finite numbers"),
        ({"wavelengths_nm": (500.0,)}, "wavelengths_nm=.*3 finite numbers"),
        ({"lateral_colour_um": (float("nan"), 0, 0)}, "lateral_colour_um=.*3 finite numbers"),
        ({"distortion": (-2.0, 0.0)}, "folds the picture"),
    ],
)
def test_an_impossible_lens_is_refused(setting: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Optics(**setting)


def test_light_and_places_that_cannot_be_are_refused() -> None:
    optics = Optics(1.4)
    with pytest.raises(ImageContractError, match="linear: got shape"):
        optics(LIGHT[0], supersampling=1)
    with pytest.raises(InputError, match="off the sensor"):
        optics(LIGHT, supersampling=1, field_mm=(3.0, 0.0))
    with pytest.raises(InputError, match=r"supersampling=1\.5"):
        optics(LIGHT, supersampling=1.5)
    with pytest.raises(InputError, match="off the sensor"):
        optics.point_spread(supersampling=1, field_mm=(0.0, 5.0))
    with pytest.raises(InputError, match="off the sensor"):
        optics.distort_points(torch.zeros(1, 2), (4, 4), supersampling=1, field_mm=(0.0, 5.0))
    with pytest.raises(InputError, match="supersampling=0"):
        optics.distort_points(torch.zeros(1, 2), (4, 4), supersampling=0)
