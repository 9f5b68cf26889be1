"""Lenses by name and by numbers, mounted: size, focus, f-number, blur, pupil."""

import math
from typing import Any

import numpy as np
import pytest
from fakes.scenes import LENSES
from hydra.utils import instantiate
from omegaconf import OmegaConf

from lrsr.errors import InputError
from lrsr.presets import preset
from lrsr.rendering.glass import refractive_index
from lrsr.rendering.lens import Lens, _widest_f_number, biconvex
from lrsr.rendering.mounted_lens import MountedLens, mount
from lrsr.rendering.surfaces import Surface, entrance_pupil, focal_length_mm, stop_number

GLASS = ["single", "double_gauss"]
DOUBLE_GAUSS = LENSES["double_gauss"].surfaces
FOCUS_MM = 1100.0


def mounted(name: str, **changes: Any) -> MountedLens:
    return mount(preset("lens", name, **changes), 3.0, FOCUS_MM, 0.4)


def slopes_at(
    lens: MountedLens, film_mm: np.ndarray, pupil_mm: np.ndarray, depth_mm: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return where rays cross the plane at that distance from the entrance pupil, as slopes."""
    points, ways, through = lens.rays_from_film(film_mm, pupil_mm)
    travel = (lens.entrance_mm + depth_mm - points[:, 2:]) / ways[:, 2:]
    return (points + travel * ways)[:, :2] / depth_mm, through


def disc(count: int, radius: float) -> np.ndarray:
    rng = np.random.default_rng(0)
    polar = radius * np.sqrt(rng.uniform(size=count)), 2 * np.pi * rng.uniform(size=count)
    return np.stack([polar[0] * np.cos(polar[1]), polar[0] * np.sin(polar[1])], axis=1)


@pytest.mark.parametrize("name", ["thin", *GLASS])
@pytest.mark.parametrize("focus_mm", [300.0, 1100.0, 8900.0])
def test_the_film_has_the_size_of_a_pinholes(name: str, focus_mm: float) -> None:
    lens = mount(LENSES[name], 3.0, focus_mm, 0.4)
    assert lens.constant_mm == pytest.approx(3.0, rel=1e-12)
    # A thin lens of focal length f has its film at s f / (s - f); thick ones within their length.
    f = focal_length_mm(lens.surfaces)
    assert focus_mm * f / (focus_mm - f) == pytest.approx(3.0, rel=2e-3)
    # Near the axis and through a narrow aperture, slopes in the scene are those of the pinhole.
    film = np.array([[0.01, 0.0], [0.0, -0.02]])
    seen, _ = slopes_at(lens, film, np.zeros((2, 2)), focus_mm)
    np.testing.assert_allclose(seen, -film / 3.0, atol=1e-7)


@pytest.mark.parametrize("name", GLASS)
def test_what_is_in_focus_is_sharp_up_to_the_cube_of_the_aperture(name: str) -> None:
    """Off the paraxial focus blur would shrink with the aperture itself, not with its cube."""
    spots = []
    for f_number in (50.0, 100.0):
        lens = mounted(name, f_number=f_number)
        aims = disc(200, 1.0 / f_number)  # of 1.6 mm / f_number
        sharp, through = slopes_at(lens, np.zeros((200, 2)), aims, FOCUS_MM)
        assert through.all()
        spots.append(np.abs(sharp).max())
    assert spots[0] / spots[1] == pytest.approx(8, rel=0.05)


@pytest.mark.parametrize("depth_mm", [700.0, 1000.0, 2500.0])
@pytest.mark.parametrize("f_number", [1.4, 8.0])
def test_a_thin_lens_blurs_as_the_formula_says(depth_mm: float, f_number: float) -> None:
    # c = A |d - s| / d f / (s - f)
    lens = mounted("thin", f_number=f_number)
    f = focal_length_mm(lens.surfaces)
    aperture = f / f_number
    wanted = aperture * abs(depth_mm - FOCUS_MM) / depth_mm * f / (FOCUS_MM - f)
    rim = lens.pupil_radius_mm * np.array([[1, 0], [-1, 0]]) * (1 - 1e-9)
    (left, right), through = slopes_at(lens, np.zeros((2, 2)), rim, depth_mm)
    assert through.all()
    assert abs(right[0] - left[0]) * lens.constant_mm == pytest.approx(wanted, rel=1e-6)


@pytest.mark.parametrize("name", ["thin", *GLASS])
@pytest.mark.parametrize("f_number", [4.0, 11.0])
def test_the_f_number_is_focal_length_over_entrance_pupil(name: str, f_number: float) -> None:
    surfaces = preset("lens", name, f_number=f_number).unit()
    stop = surfaces[stop_number(surfaces)].semi_aperture_mm
    diameter = 2 * stop * entrance_pupil(surfaces)[1]
    assert focal_length_mm(surfaces) / diameter == pytest.approx(f_number, rel=1e-12)


@pytest.mark.parametrize("name", GLASS)
def test_the_middle_of_the_film_receives_pi_sine_squared(name: str) -> None:
    """Slow oracle: cos⁴ over the square of the distance, summed over a grid in the exit pupil."""
    lens = mounted(name)
    grid = (np.arange(401) / 200 - 1) * lens.pupil_radius_mm
    aims = np.stack(np.meshgrid(grid, grid), axis=-1).reshape(-1, 2)
    _, _, through = lens.rays_from_film(np.zeros_like(aims), aims)
    square = (aims**2).sum(axis=1) + lens.pupil_mm**2
    area = (grid[1] - grid[0]) ** 2
    received = (through * lens.pupil_mm**2 / square**2).sum() * area
    assert received == pytest.approx(np.pi * lens.brightness, rel=2e-3)


@pytest.mark.parametrize("f_number", [4.0, 100.0])
@pytest.mark.parametrize("name", GLASS)
def test_no_light_passes_outside_the_pupil_that_is_sampled(name: str, f_number: float) -> None:
    lens = mounted(name, f_number=f_number)
    rng = np.random.default_rng(2)
    film = rng.uniform(-0.28, 0.28, (20000, 2))
    reach = lens.pupil_reach_mm(film)
    offset = rng.uniform(-2, 2, (20000, 2)) * reach[:, None]
    _, _, through = lens.rays_from_film(film, offset + lens.pupil_middle_mm(film))
    radius = np.hypot(*offset.T)
    assert through.sum() > 1000
    assert (radius[through] <= reach[through]).all()
    assert through[radius < reach].mean() > 0.93


@pytest.mark.parametrize(
    ("name", "height_mm", "least"),
    [
        ("thin", 0.3, 1.0),
        ("single", 0.3, 0.98),
        ("double_gauss", 0.0, 0.95),
        ("double_gauss", 0.36, 0.7),
    ],
)
def test_few_rays_are_lost(name: str, height_mm: float, least: float) -> None:
    """At F/2 the rims of the double Gauss hide a quarter of the pupil 7° off the axis."""
    lens = mount(LENSES[name], 3.0, FOCUS_MM, 0.48)
    film = np.tile([height_mm, 0.0], (2000, 1))
    aims = disc(2000, 1.0) * lens.pupil_reach_mm(film)[:, None] + lens.pupil_middle_mm(film)
    _, _, through = lens.rays_from_film(film, aims)
    assert through.mean() >= least


def test_a_rim_darkens_the_corner_of_the_picture() -> None:
    """The front of a double Gauss hides part of the stop from the edge of the field, at F/2."""
    shares = []
    for f_number in (None, 8.0):
        lens = mount(preset("lens", "double_gauss", f_number=f_number), 3.0, FOCUS_MM, 1.3)
        aims = disc(4000, lens.pupil_radius_mm)
        passed = []
        for height in (0.0, 0.8):
            film = np.full_like(aims, height)
            passed.append(lens.rays_from_film(film, aims + lens.pupil_middle_mm(film))[2].mean())
        shares.append(passed[1] / passed[0])
    assert shares[0] < 0.7
    assert shares[1] == pytest.approx(1, abs=0.1)


@pytest.mark.parametrize("name", GLASS)
def test_landmarks_are_where_a_lens_shows_them_within_a_twentieth_of_a_pixel(name: str) -> None:
    """Chief rays of a face of 64 px: pupils 1.6° off the axis, the corners of the mouth 4°."""
    lens = mounted(name, f_number=16.0)
    for px in (35.0, 80.0):
        film = np.array([[px * 2.65e-3, 0.0]])
        film = film.repeat(201, axis=0)
        aims = np.linspace(-1, 1, 201)[:, None] * (lens.pupil_radius_mm, 0)
        slopes, through = slopes_at(lens, film, aims + lens.pupil_middle_mm(film), FOCUS_MM)
        middle = slopes[through][:, 0].mean()
        assert -middle * 3.0 / 2.65e-3 == pytest.approx(px, abs=0.05)


def test_a_lens_is_a_pinhole_ideal_or_of_glass() -> None:
    assert preset("lens", "thin", f_number=2.0).f_number == 2.0
    assert LENSES["pinhole"].is_pinhole
    assert LENSES["thin"].is_ideal
    assert not any(LENSES[name].is_pinhole or LENSES[name].is_ideal for name in GLASS)


def test_a_lens_from_a_configuration_is_a_value() -> None:
    rows = [
        {"radius_mm": 0.0, "thickness_mm": 0.0, "semi_aperture_mm": 1.0, "stop": True},
        {"radius_mm": 3.0, "thickness_mm": 1.0, "glass": "N-BK7"},
        {"radius_mm": -3.0, "thickness_mm": 2.6},
    ]
    given = {"_target_": "lrsr.rendering.lens.Lens", "name": "own", "surfaces": rows}
    lens = instantiate(OmegaConf.create(given))
    assert lens == Lens("own", tuple(Surface(**row) for row in rows))
    assert hash(lens) == hash(instantiate(OmegaConf.create(given)))


STOPLESS = (Surface(50.0, 5.0, "N-BK7"), Surface(-50.0, 1.0))
SPREADING = (Surface(-50.0, 5.0, "N-BK7", 5.0, stop=True), Surface(50.0, 1.0))
WET = (Surface(50.0, 5.0, "N-BK7", 5.0, stop=True),)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"f_number": 0.0}, r"lens\.f_number=0: wanted a number > 0"),
        ({"focus_m": -1.0}, r"lens\.focus_m=-1: wanted a number > 0"),
        ({"f_number": math.nan}, r"lens\.f_number=nan: wanted a number"),
        ({"surfaces": STOPLESS}, "lens 'bad'.*a lens of 0 stops: mark exactly one"),
        ({"surfaces": SPREADING}, "lens 'bad'.*give one that gathers light"),
        ({"surfaces": WET}, "lens 'bad' ends in glass: give its last surface air"),
        (
            {"surfaces": DOUBLE_GAUSS, "f_number": 1.4},
            "lens 'bad': f_number=1.4; it opens to 2.03 at most",
        ),
    ],
    ids=["f/0", "behind", "nan", "no stop", "spreads", "glass behind", "too wide"],
)
def test_a_lens_refuses_what_cannot_be(fields: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Lens("bad", **fields)


def test_a_lens_cannot_be_focused_on_itself() -> None:
    with pytest.raises(InputError, match=r"'thin' cannot be focused at 0\.002 m; give a larger"):
        mounted("thin", focus_m=0.002)


def test_a_pinhole_is_not_mounted() -> None:
    with pytest.raises(InputError, match="is a pinhole: it has no surfaces"):
        mounted("pinhole")


def test_the_widest_f_number_of_the_double_gauss_is_two() -> None:
    assert _widest_f_number(DOUBLE_GAUSS) == pytest.approx(2, rel=0.02)


@pytest.mark.parametrize("thickness", [0.5, 1.0, 2.0])
def test_a_biconvex_lens_has_the_focal_length_that_was_asked_for(thickness: float) -> None:
    lens = biconvex(3.0, thickness, 0.5, "F2")
    assert focal_length_mm(lens) == pytest.approx(3.0, rel=1e-12)
    n, radius = float(refractive_index("F2")), lens[1].radius_mm
    power = (n - 1) * (2 / radius - (n - 1) * thickness / (n * radius**2))
    assert 1 / power == pytest.approx(3.0, rel=1e-12)


@pytest.mark.parametrize(
    ("thickness", "semi", "message"),
    [(9.0, 0.5, "do not fit"), (1.0, 3.0, "do not fit"), (0.2, 1.0, "give a thickness > 0.335")],
    ids=["thick", "wide", "thin"],
)
def test_a_biconvex_lens_that_cannot_be_is_refused(
    thickness: float, semi: float, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        biconvex(3.0, thickness, semi, "N-BK7")
