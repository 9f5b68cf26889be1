"""The reference camera's angles of view, and back and forth."""

import math

import numpy as np
import pytest
import torch
from omegaconf import OmegaConf
from scipy.optimize import brentq

from lrsr.camera.distortion import Distortion
from lrsr.errors import InputError
from lrsr.paths import config_folder

HALF_MM = (960 * 2.65e-3, 540 * 2.65e-3)


def lens(half_angles_deg: tuple[float, ...], orders: tuple[int, ...]) -> Distortion:
    """Return one of 3 mm that sees these angles at the sensor's edges."""
    radii = np.array(HALF_MM[: len(orders)]) / 3.0
    excess = np.tan(np.radians(half_angles_deg)) / radii - 1
    solved = np.linalg.solve(radii[:, None] ** (np.array(orders) - 1), excess)
    return Distortion(
        **{{3: "k1", 5: "k2"}[n]: float(k) for n, k in zip(orders, solved, strict=True)}
    )


AXIS_P1435LE = lens((47.5,), (5,))
WAVY = lens((47.5, 25.5), (3, 5))
GENERATOR = torch.Generator().manual_seed(0)
PLACES = (torch.rand(50, 2, generator=GENERATOR, dtype=torch.float64) * 2 - 1) * torch.tensor(
    HALF_MM
)


def seen_deg(lens: Distortion, *place_mm: float) -> float:
    plane = lens.undistort(torch.tensor(place_mm, dtype=torch.float64))
    return math.degrees(math.atan(float(plane.norm()) / lens.focal_mm))


def test_the_reference_camera_sees_95_degrees() -> None:
    # Without distortion 1920 pixels of 2.65 µm behind 3 mm see 80.6°; the data sheet says 95°, and
    # 51° upright, of which this barrel misses 1.3° (k1 alone: 4.0°).
    assert 2 * seen_deg(Distortion(), HALF_MM[0], 0.0) == pytest.approx(80.6, abs=0.1)
    assert 2 * seen_deg(AXIS_P1435LE, HALF_MM[0], 0.0) == pytest.approx(95)
    assert 2 * seen_deg(AXIS_P1435LE, 0.0, HALF_MM[1]) == pytest.approx(52.27, abs=0.01)


def test_the_preset_is_that_lens() -> None:
    settings = OmegaConf.load(config_folder() / "camera" / "axis_p1435le.yaml").optics
    assert list(settings.distortion) == pytest.approx([AXIS_P1435LE.k1, AXIS_P1435LE.k2], abs=5e-4)
    assert (settings.focal_mm, settings.pitch_um) == (3.0, 2.65)


def test_the_reference_cameras_barrel_grows_all_the_way_out() -> None:
    # Two orders meet both angles, but only by a pincushion of 1 % in between.
    radii = torch.linspace(0.01, 2.92, 200, dtype=torch.float64)
    places = torch.stack([radii, torch.zeros_like(radii)], 1)
    barrel, wavy = (lens.undistort(places).norm(dim=1) / radii for lens in (AXIS_P1435LE, WAVY))
    assert bool((barrel.diff() > 0).all())
    assert float(barrel[0]) == pytest.approx(1.0)
    assert float(wavy.min()) == pytest.approx(0.99, abs=0.001)


def test_two_angles_are_met_by_two_coefficients() -> None:
    assert 2 * seen_deg(WAVY, HALF_MM[0], 0.0) == pytest.approx(95)
    assert 2 * seen_deg(WAVY, 0.0, HALF_MM[1]) == pytest.approx(51)


@pytest.mark.parametrize(
    "lens", [AXIS_P1435LE, WAVY, Distortion(0.4), Distortion(-0.1), Distortion()], ids=repr
)
def test_distorting_undoes_undistorting(lens: Distortion) -> None:
    assert torch.allclose(lens.distort(lens.undistort(PLACES)), PLACES, atol=1e-10)


@pytest.mark.parametrize("plane_mm", [0.1, 1.0, 2.5, 4.0])
def test_the_inverse_is_scipys_root(plane_mm: float) -> None:
    k1, k2 = AXIS_P1435LE.k1, AXIS_P1435LE.k2
    root = brentq(lambda p: p * (1 + k1 * p**2 / 9 + k2 * p**4 / 81) - plane_mm, 0, 3)
    place = AXIS_P1435LE.distort(torch.tensor([0.0, plane_mm], dtype=torch.float64))
    assert float(place[1]) == pytest.approx(root)


def test_a_barrel_draws_the_edge_inwards() -> None:
    far = torch.tensor([2.5, 0.0])
    assert Distortion(0.3).distort(far).norm() < far.norm() < Distortion(-0.1).distort(far).norm()


@pytest.mark.parametrize("facing", [True, False])
def test_films_and_sensors_invert_each_other(facing: bool) -> None:
    lens = Distortion(AXIS_P1435LE.k1, AXIS_P1435LE.k2, facing=facing)
    centre = torch.tensor([1.8, 0.9], dtype=torch.float64)
    sensor = centre + PLACES / 50
    film = lens.to_film(sensor, centre)
    assert torch.allclose(lens.to_sensor(film, centre), sensor, atol=1e-10)
    assert float(lens.to_film(centre, centre).abs().max()) < 1e-12


def test_a_lens_that_keeps_angles_keeps_faces() -> None:
    # r = f θ: k1 = 1/3, k2 = 2/15 are tan's series. Seen by a camera turned to it, a face keeps its
    # height along the radius however far out it lies; as a flat picture it is stretched twice.
    lens, planar = Distortion(1 / 3, 2 / 15), Distortion(1 / 3, 2 / 15, facing=False)
    centre = torch.tensor([1.5, 0.0], dtype=torch.float64)
    outwards = centre + torch.tensor([0.01, 0.0])
    assert float(lens.to_film(outwards, centre)[0]) == pytest.approx(0.01, rel=0.02)
    stretched = float(planar.to_film(outwards, centre)[0])
    assert stretched == pytest.approx(0.01 / math.cos(0.5) ** 2, rel=0.03)


def test_the_area_ratio_is_the_determinant() -> None:
    for place in PLACES[:5]:
        jacobian = torch.autograd.functional.jacobian(AXIS_P1435LE.undistort, place)
        assert float(AXIS_P1435LE.area_ratio(place)) == pytest.approx(float(jacobian.det()))


def test_the_axis_has_a_gradient() -> None:
    axis = torch.zeros(2, dtype=torch.float64, requires_grad=True)
    AXIS_P1435LE.distort(axis).sum().backward()
    assert axis.grad is not None
    assert axis.grad.tolist() == [1.0, 1.0]


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ({"k1": -1.0}, "folds the picture"),
        ({"k1": float("nan")}, "folds the picture"),
        ({"focal_mm": 0.0}, "focal_mm 0"),
        ({"radius_mm": -1.0}, "radius_mm -1"),
    ],
)
def test_an_impossible_lens_is_refused(setting: dict[str, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Distortion(**setting)
