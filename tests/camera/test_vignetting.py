"""Dark corners: cos⁴, and two circles that overlap."""

import math

import pytest
import torch

from lrsr.camera.distortion import Distortion
from lrsr.camera.vignetting import Vignetting, _mechanical_vignetting, natural_vignetting
from lrsr.errors import InputError

PINHOLE = Distortion(focal_mm=3.0)
RADII = torch.linspace(0, 2.9, 8, dtype=torch.float64)
PLACES = torch.stack([RADII * 0.8, -RADII * 0.6], dim=-1)


def rim(places: torch.Tensor, radius_mm: float = 1.2, distance_mm: float = 2.0) -> torch.Tensor:
    return _mechanical_vignetting(
        places,
        PINHOLE,
        pupil_radius_mm=1.0,
        rim_radius_mm=radius_mm,
        rim_distance_mm=distance_mm,
    )[..., 0]


def test_without_distortion_it_is_the_fourth_power_of_the_cosine() -> None:
    cosine = torch.cos(torch.atan(RADII / 3.0))
    assert torch.allclose(natural_vignetting(PLACES, PINHOLE)[..., 0], cosine**4)


def test_a_lens_that_keeps_angles_loses_less() -> None:
    # r = f θ: the light is cos θ times the solid angle per area, sin θ / θ. tan's series to θ⁵.
    lens = Distortion(1 / 3, 2 / 15)
    angle = torch.tensor(0.4, dtype=torch.float64)
    place = torch.stack([3.0 * angle, torch.zeros_like(angle)])
    wanted = angle.cos() * angle.sin() / angle
    assert float(natural_vignetting(place, lens)) == pytest.approx(float(wanted), rel=2e-3)


@pytest.mark.parametrize("radius_mm", [1.2, 1.0, 0.7])
def test_the_rim_leaves_what_counting_finds(radius_mm: float) -> None:
    line = (torch.arange(800, dtype=torch.float64) + 0.5) / 400 - 1
    x, y = line[None, :], line[:, None]
    pupil = x**2 + y**2 <= 1
    for radius, share in zip(RADII, rim(PLACES, radius_mm), strict=True):
        moved = float(radius) / 3.0 * 2.0
        open_part = pupil & ((x - moved) ** 2 + y**2 <= radius_mm**2)
        counted = float(open_part.sum() / pupil.sum())
        assert float(share) == pytest.approx(counted, abs=1e-3)


def test_a_wide_rim_cuts_nothing_near_the_axis_and_all_far_out() -> None:
    near, far = torch.tensor([[0.2, 0.0], [2.9, 0.0]])
    assert float(rim(near)) == 1.0
    assert float(rim(far, distance_mm=10.0)) == 0.0


def test_the_axis_has_a_gradient() -> None:
    axis = torch.zeros(2, dtype=torch.float64, requires_grad=True)
    (rim(axis, radius_mm=1.0) + natural_vignetting(axis, PINHOLE)).sum().backward()
    assert axis.grad is not None
    assert axis.grad.tolist() == [0.0, 0.0]


def test_no_place_is_brighter_than_the_axis_without_distortion() -> None:
    assert math.isclose(float(natural_vignetting(PLACES, PINHOLE).max()), 1.0)
    assert float(rim(PLACES).max()) == 1.0


@pytest.mark.parametrize("name", ["pupil_radius_mm", "rim_radius_mm", "rim_distance_mm"])
def test_a_rim_without_size_is_refused(name: str) -> None:
    lengths = {"pupil_radius_mm": 1.0, "rim_radius_mm": 1.0, "rim_distance_mm": 1.0, name: 0.0}
    with pytest.raises(InputError, match=f"{name} 0"):
        _mechanical_vignetting(PLACES, PINHOLE, **lengths)


def test_each_image_gets_the_light_of_its_place() -> None:
    fields = torch.tensor([[0.0, 0.0], [1.5, 2.0]])
    rim = {"pupil_radius_mm": 1.0, "rim_radius_mm": 1.2, "rim_distance_mm": 2.0}
    dark = Vignetting(PINHOLE, natural=True, **rim).darken(torch.ones(2, 3, 5, 5), fields, 1e-4)
    alone = natural_vignetting(fields, PINHOLE) * _mechanical_vignetting(fields, PINHOLE, **rim)
    assert torch.allclose(dark[:, :, 2, 2], alone.expand(2, 3))
    assert bool((dark[1, :, 0, 0] > dark[1, :, 4, 4]).all())


def test_without_vignetting_the_film_is_returned_itself() -> None:
    film = torch.ones(1, 3, 4, 4)
    assert Vignetting(PINHOLE, pupil_radius_mm=1.0).darken(film, torch.zeros(1, 2), 0.001) is film


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ({"rim_radius_mm": 1.0}, "rim_radius_mm=1.0, rim_distance_mm=None: give both or neither"),
        ({"rim_distance_mm": 1.0}, "give both or neither"),
        ({"rim_radius_mm": -1.0, "rim_distance_mm": 1.0}, "rim_radius_mm -1"),
    ],
)
def test_an_impossible_rim_is_refused(setting: dict[str, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Vignetting(PINHOLE, pupil_radius_mm=1.0, **setting)
