"""Exact rays against textbook limits: Gauss near the axis, Seidel a little off it."""

import math

import numpy as np
import pytest
from fakes.scenes import LENSES
from oracles.abbe import C_LINE_NM, F_LINE_NM, abbe_number

from lrsr.errors import InputError
from lrsr.rendering.glass import refractive_index
from lrsr.rendering.lens import biconvex
from lrsr.rendering.surfaces import (
    Surface,
    _paraxial,
    entrance_pupil,
    exit_pupil,
    focal_length_mm,
    image_of,
    reversed_surfaces,
    stop_number,
    trace,
)

THIN_MM = 1e-4
N_BK7 = 1.51680

DOUBLE_GAUSS = LENSES["double_gauss"].surfaces


def singlet(q: float, focal_mm: float = 100.0, glass: str = "N-BK7") -> tuple[Surface, ...]:
    """Make a very thin lens of the Coddington shape factor q = (R2 + R1) / (R2 - R1)."""
    n = float(refractive_index(glass))
    front, back = (2 * focal_mm * (n - 1) / (q + sign) for sign in (1 + 1e-12, -1 - 1e-12))
    return (
        Surface(front, THIN_MM, glass, 40.0, stop=True),
        Surface(back, focal_mm, semi_aperture_mm=40.0),
    )


def crossing_mm(surfaces: tuple[Surface, ...], height_mm: float) -> float:
    """Trace a ray from infinity and return where it meets the axis, behind the last vertex."""
    point, way, through = trace(
        surfaces, np.array([[0.0, height_mm, -50.0]]), np.array([[0.0, 0.0, 1.0]])
    )
    assert through.all()
    behind = sum(surface.thickness_mm for surface in surfaces[:-1])
    return float(point[0, 2] - point[0, 1] * way[0, 2] / way[0, 1]) - behind


def seidel_spherical(surfaces: tuple[Surface, ...], height_mm: float) -> float:
    """Return the third-order longitudinal aberration by Seidel's sum (Welford 1986, 8.9), mm."""
    y, u, n, total = height_mm, 0.0, 1.0, 0.0
    for surface in surfaces:
        behind = float(refractive_index(surface.glass))
        incidence = n * (u + y * surface.curvature_per_mm)
        new = (n * u - y * surface.curvature_per_mm * (behind - n)) / behind
        total += -(incidence**2) * y * (new / behind - u / n)
        u, n, last = new, behind, y
        y += u * surface.thickness_mm
    assert last
    return -total / (2 * u**2)


def test_a_ray_obeys_snells_law() -> None:
    slope = math.radians(30)
    plate = (Surface(0, 1.0, "N-SF11"), Surface(0, 1.0, "N-BK7"))
    _, way, _ = trace(plate, np.zeros((1, 3)), np.array([[math.sin(slope), 0, math.cos(slope)]]))
    assert math.sin(slope) == pytest.approx(float(refractive_index("N-BK7")) * way[0, 0], abs=1e-12)


def test_the_lensmakers_equation_is_met() -> None:
    lens = (Surface(50.0, 5.0, "N-BK7"), Surface(-80.0, 0.0))
    wanted = (N_BK7 - 1) * (1 / 50 + 1 / 80 - (N_BK7 - 1) * 5 / (N_BK7 * 50 * 80))
    assert focal_length_mm(lens) == pytest.approx(1 / wanted, rel=1e-5)


@pytest.mark.parametrize("surfaces", [DOUBLE_GAUSS, singlet(0.3)], ids=["double gauss", "singlet"])
def test_rays_near_the_axis_do_what_the_matrix_says(surfaces: tuple[Surface, ...]) -> None:
    back_mm, _ = image_of(surfaces, math.inf)
    assert crossing_mm(surfaces, 1e-3) == pytest.approx(back_mm, rel=1e-8)
    _, way, _ = trace(surfaces, np.array([[0.0, 1e-3, -50.0]]), np.array([[0.0, 0.0, 1.0]]))
    assert -1e-3 / way[0, 1] == pytest.approx(focal_length_mm(surfaces), rel=1e-7)


def test_the_published_back_focus_of_the_double_gauss_is_met() -> None:
    # The table ends with 72.228 mm; its glasses have three digits, those here five.
    assert image_of(DOUBLE_GAUSS, math.inf)[0] == pytest.approx(72.228, abs=0.02)
    assert focal_length_mm(DOUBLE_GAUSS) == pytest.approx(100, rel=0.01)


def test_images_obey_newtons_equation() -> None:
    front_focus_mm = image_of(reversed_surfaces(DOUBLE_GAUSS), math.inf)[0]
    back_focus_mm, focal = (
        image_of(DOUBLE_GAUSS, math.inf)[0],
        focal_length_mm(DOUBLE_GAUSS),
    )
    image_mm, magnification = image_of(DOUBLE_GAUSS, 1234.0)
    beyond = 1234.0 - front_focus_mm
    assert beyond * (image_mm - back_focus_mm) == pytest.approx(focal**2, rel=1e-9)
    assert magnification == pytest.approx(-focal / beyond, rel=1e-9)


def test_a_matrix_has_determinant_one() -> None:
    assert np.linalg.det(_paraxial(DOUBLE_GAUSS)) == pytest.approx(1, abs=1e-12)


@pytest.mark.parametrize("q", [-1.0, 0.0, 0.7, 1.0], ids=lambda q: f"q={q}")
def test_spherical_aberration_of_a_thin_lens_is_the_textbooks(q: float) -> None:
    # 1/s'h - 1/s'p = h²/(8 f³ n (n-1)) ((n+2)/(n-1) q² + 4(n+1) p q + (3n+2)(n-1) p² + n³/(n-1)),
    # p = -1 for an object at infinity (Jenkins and White, Fundamentals of Optics, equation 9n).
    focal, height, n = 100.0, 2.0, float(refractive_index("N-BK7"))
    lens = singlet(q, focal)
    form = (n + 2) / (n - 1) * q**2 - 4 * (n + 1) * q + (3 * n + 2) * (n - 1) + n**3 / (n - 1)
    wanted = height**2 / (8 * focal**3 * n * (n - 1)) * form
    seen = 1 / crossing_mm(lens, height) - 1 / crossing_mm(lens, 1e-3)
    assert seen == pytest.approx(wanted, rel=0.01)


@pytest.mark.parametrize(
    "surfaces",
    [
        DOUBLE_GAUSS,
        biconvex(100.0, 8.0, 20.0, "N-BK7"),
        singlet(1.0),
        singlet(-1.0),
    ],
    ids=["double gauss", "biconvex", "convex first", "plane first"],
)
def test_small_apertures_have_seidels_aberration(surfaces: tuple[Surface, ...]) -> None:
    height = 0.01 * focal_length_mm(surfaces)
    seen = crossing_mm(surfaces, height) - image_of(surfaces, math.inf)[0]
    assert seen == pytest.approx(seidel_spherical(surfaces, height), rel=0.01)


@pytest.mark.parametrize("glass", ["N-BK7", "F2"])
def test_the_focus_of_red_lies_behind_that_of_blue_by_f_over_v(glass: str) -> None:
    lens = singlet(0.0, glass=glass)
    shift = focal_length_mm(lens, C_LINE_NM) - focal_length_mm(lens, F_LINE_NM)
    assert shift == pytest.approx(focal_length_mm(lens) / abbe_number(glass), rel=0.015)


@pytest.mark.parametrize(
    ("height_mm", "passes"),
    [(2.7, True), (2.9, False), (5.5, False), (-2.7, True), (-4.5, False)],
    ids=["32.7 deg", "35.5 deg", "misses", "32.7 deg below", "rim"],
)
def test_total_reflection_and_rims_and_misses_stop_rays(height_mm: float, passes: bool) -> None:
    # asin(1 / n_d) of N-SF11 is 34.1°; the ray meets the second face at asin(height / 5 mm).
    lens = (Surface(0, 6.0, "N-SF11"), Surface(-5.0, 1.0, semi_aperture_mm=4.4))
    _, way, through = trace(lens, np.array([[0, height_mm, -5.0]]), np.array([[0.0, 0.0, 1.0]]))
    assert through.tolist() == [passes]
    assert np.isfinite(way).all()


def test_light_goes_the_same_way_back() -> None:
    rng = np.random.default_rng(0)
    origins = np.array([0.0, 0.0, -500.0]) + rng.uniform(-10, 10, (50, 3))
    aims = np.concatenate([rng.uniform(-10, 10, (50, 2)), np.zeros((50, 1))], axis=1)
    point, way, through = trace(DOUBLE_GAUSS, origins, aims - origins)
    assert through.all()
    length = sum(surface.thickness_mm for surface in DOUBLE_GAUSS[:-1])
    back_point, back_way, back = trace(
        reversed_surfaces(DOUBLE_GAUSS),
        (point + way) * (1, 1, -1) + (0, 0, length),
        -way * (1, 1, -1),
    )
    assert back.all()
    seen = back_point * (1, 1, -1) + (0, 0, length)
    travelled = (seen - origins)[:, 2] / (aims - origins)[:, 2]
    np.testing.assert_allclose(origins + travelled[:, None] * (aims - origins), seen, atol=1e-9)
    assert (back_way * (1, 1, -1) * (aims - origins)).sum(axis=1).max() < 0


def test_the_pupils_are_images_of_the_stop() -> None:
    stop = stop_number(DOUBLE_GAUSS)
    position, enlarged = entrance_pupil(DOUBLE_GAUSS)
    behind, magnification = exit_pupil(DOUBLE_GAUSS)
    # A ray at the middle of the entrance pupil passes the middle of the stop and of the exit pupil.
    origin = np.array([[0.0, 0.0, position]]) - 100 * np.array([[0.0, 1e-5, 1.0]])
    at_stop, way, _ = trace(DOUBLE_GAUSS[: stop + 1], origin, np.array([[0.0, 1e-5, 1.0]]))
    assert at_stop[0, 1] == pytest.approx(0, abs=1e-10)
    point, way, _ = trace(DOUBLE_GAUSS, origin, np.array([[0.0, 1e-5, 1.0]]))
    length = sum(surface.thickness_mm for surface in DOUBLE_GAUSS[:-1])
    crossing = point[0, 2] - point[0, 1] * way[0, 2] / way[0, 1]
    assert crossing - length == pytest.approx(behind, rel=1e-6)
    assert 2 * 17.1 * enlarged == pytest.approx(focal_length_mm(DOUBLE_GAUSS) / 2, rel=0.02)
    assert magnification > 1


def test_an_ideal_lens_sends_all_rays_of_a_point_to_its_image() -> None:
    lens = (Surface(0, 0, power_per_mm=0.1),)
    aims = np.random.default_rng(1).uniform(-4, 4, (20, 2))
    start = np.array([3.0, -2.0, -30.0])
    point, way, _ = trace(lens, np.tile(start, (20, 1)), np.pad(aims, ((0, 0), (0, 1))) - start)
    seen = point + (15.0 - point[:, 2:]) / way[:, 2:] * way
    np.testing.assert_allclose(seen[:, :2], [[-1.5, 1.0]] * 20, atol=1e-12)


@pytest.mark.parametrize(
    "broken",
    [{"radius_mm": math.nan}, {"thickness_mm": math.inf}, {"semi_aperture_mm": 0.0}],
    ids=lambda broken: next(iter(broken)),
)
def test_a_surface_refuses_what_cannot_be(broken: dict) -> None:
    (name,) = broken
    with pytest.raises(InputError, match=rf"surface\.{name}=.*: wanted a number"):
        Surface(**{"radius_mm": 1.0, "thickness_mm": 1.0, **broken})
    with pytest.raises(InputError, match="glass 'jam'"):
        Surface(1.0, 1.0, "jam")


def test_a_lens_that_spreads_light_has_no_focal_length() -> None:
    with pytest.raises(InputError, match="give one that gathers light"):
        focal_length_mm((Surface(-50.0, 5.0, "N-BK7"), Surface(80.0, 0.0)))


@pytest.mark.parametrize("count", [0, 2])
def test_a_lens_has_one_stop(count: int) -> None:
    with pytest.raises(InputError, match=f"a lens of {count} stops"):
        stop_number([Surface(0, 1, stop=number < count) for number in range(3)])
