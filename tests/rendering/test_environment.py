"""The map of what is far away, and the meter: Lambert's law, panels, and a room from a file."""

import math
from pathlib import Path

import numpy as np
import pytest
from fakes.scenes import LIGHTINGS, ROOMS

from lrsr.errors import InputError
from lrsr.rendering.backend import _start
from lrsr.rendering.colour import LUMINANCE
from lrsr.rendering.environment import (
    environment,
    hides,
    lambert_phase,
    panel_metered,
    panel_radiance,
)
from lrsr.rendering.lighting import Lighting
from lrsr.rendering.lights import Light, Panel


def mean_over_the_disc(angle: float) -> float:
    """Slow oracle: a white Lambertian sphere seen from +z, lit from ``angle``, in units of E/π."""
    grid = (np.arange(1000) + 0.5) / 500 - 1
    x, y = np.meshgrid(grid, grid)
    inside = x**2 + y**2 < 1
    z = np.sqrt(np.clip(1 - x**2 - y**2, 0, None))
    return float(np.clip(x * np.sin(angle) + z * np.cos(angle), 0, None)[inside].mean())


@pytest.mark.parametrize("degrees", [0, 30, 60, 90, 120, 180])
def test_lamberts_phase_law_is_the_mean_over_the_disc(degrees: int) -> None:
    angle = np.radians(degrees)
    assert lambert_phase(angle) == pytest.approx(mean_over_the_disc(angle), abs=1e-3)


def test_light_from_everywhere_makes_a_white_sphere_as_bright_as_itself() -> None:
    angle = np.linspace(0, np.pi, 20001)
    integral = np.trapezoid(lambert_phase(angle) * 2 * np.pi * np.sin(angle), angle)
    assert integral / np.pi == pytest.approx(1, abs=1e-6)


@pytest.mark.parametrize("name", LIGHTINGS)
def test_the_backdrop_is_always_the_same_grey_after_exposure(name: str) -> None:
    painted, metered = environment(LIGHTINGS[name])
    behind = painted[painted.shape[0] // 2, 0]
    assert behind @ LUMINANCE / metered == pytest.approx(LIGHTINGS[name].fill_share, rel=1e-5)


@pytest.mark.parametrize("elevation", [-80.0, 0.0, 35.0, 88.0])
def test_a_disc_gives_the_irradiance_that_was_asked_for(elevation: float) -> None:
    light = Light(azimuth_deg=20, elevation_deg=elevation, irradiance=2.5)
    painted, _ = environment(Lighting("one", (light,), fill_share=0.0))
    height = len(painted)
    theta = np.linspace(0, np.pi, height)[:, None]
    phi = (2 * np.pi * (np.arange(2 * height) + 0.5) / (2 * height))[None]
    towards = np.stack(
        np.broadcast_arrays(
            np.sin(phi) * np.sin(theta), np.cos(theta), -np.cos(phi) * np.sin(theta)
        ),
        axis=-1,
    )
    cosine = np.clip(towards @ light.direction(), 0, None)
    step = np.pi / (height - 1) * np.pi / height
    irradiance = (painted @ LUMINANCE * cosine * np.sin(theta) * step).sum()
    assert irradiance == pytest.approx(2.5, rel=2e-3)


def test_a_small_frontal_light_is_metered_by_lamberts_law() -> None:
    light = Light(azimuth_deg=0, elevation_deg=0, diameter_deg=6, irradiance=np.pi)
    _, metered = environment(Lighting("flash", (light,), fill_share=0.0))
    assert metered == pytest.approx(2 / 3, rel=0.01)


def test_coloured_light_keeps_its_luminance() -> None:
    plain, white = environment(Lighting("w", (Light(30, 30),)))
    coloured, warm = environment(Lighting("w", (Light(30, 30, rgb=(1, 0.6, 0.2)),)))
    assert warm == pytest.approx(white)
    assert (coloured @ LUMINANCE).max() == pytest.approx((plain @ LUMINANCE).max())
    assert coloured[..., 0].max() > 2 * coloured[..., 2].max()


def test_fill_alone_is_metered_as_one() -> None:
    painted, metered = environment(Lighting("cloudy", (), fill_share=1.0))
    assert metered == 1.0
    np.testing.assert_allclose(painted, 1.0)


@pytest.mark.parametrize("name", ROOMS)
def test_a_room_keeps_its_share_of_fill_beside_its_window(name: str) -> None:
    room = ROOMS[name]
    painted, metered = environment(room)
    assert painted[0, 0] @ LUMINANCE / metered == pytest.approx(room.fill_share, rel=1e-5)
    key = sum(panel_metered(panel) for panel in room.panels)
    # The window hides a little of the fill.
    assert 1 - room.fill_share < key / metered < 1 - 0.9 * room.fill_share


def test_a_panel_hides_its_solid_angle() -> None:
    rng = np.random.default_rng(0)
    directions = rng.normal(size=(200000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    # A square of side 2 d at the distance d is one face of a cube: a sixth of the sphere.
    share = hides(Panel((300.0, -200.0, 600.0), 1400.0, 1400.0), directions).mean()
    assert share == pytest.approx(1 / 6, abs=4 * math.sqrt(5 / 36 / 200000))


@pytest.mark.parametrize("distance_mm", [300.0, 1000.0, 20000.0])
def test_a_square_panel_has_the_radiance_of_the_textbook(distance_mm: float) -> None:
    # View factor from a small area to a coaxial parallel square (Howell, configuration C-11):
    # 4 times that of a corner, a / sqrt(1 + a²) atan(a / sqrt(1 + a²)) / π with a = half side / d.
    panel = Panel((0.0, 0.0, distance_mm), 400.0, 400.0, irradiance=2.5)
    a = 200.0 / distance_mm
    factor = 4 / math.pi * (a / math.hypot(1, a)) * math.atan(a / math.hypot(1, a))
    assert panel_radiance(panel) == pytest.approx(2.5 / (math.pi * factor), rel=2e-3)


def test_a_far_panel_is_metered_as_a_far_disc_of_its_solid_angle() -> None:
    light = Light(azimuth_deg=50, elevation_deg=20, diameter_deg=6.0)
    solid = 2 * math.pi * (1 - math.cos(math.radians(3)))
    where = 1e5 * light.direction()
    side = 1e5 * math.sqrt(solid)
    panel = Panel(tuple(where.tolist()), side, side)
    _, by_disc = environment(Lighting("disc", (light,), 0.3))
    _, by_panel = environment(Lighting("panel", fill_share=0.3, panels=(panel,)))
    assert by_panel == pytest.approx(by_disc, rel=0.01)


def test_twice_as_near_makes_a_small_panel_a_quarter_as_bright_for_the_same_irradiance() -> None:
    near, far = (
        panel_radiance(Panel((0.0, 0.0, distance), 10.0, 10.0)) for distance in (500.0, 1000.0)
    )
    assert far / near == pytest.approx(4, rel=1e-3)


def write(path: Path, values: np.ndarray) -> str:
    _start().Bitmap(np.ascontiguousarray(values, dtype=np.float32)).write(str(path))
    return str(path)


def test_an_even_map_is_an_even_fill(tmp_path: Path) -> None:
    even = write(tmp_path / "even.exr", np.full((32, 64, 3), 7.0))
    light = (Light(0.0, 60.0),)
    with_map, metered = environment(Lighting("map", light, map=even))
    without, expected = environment(Lighting("fill", light))
    assert metered == pytest.approx(expected)
    np.testing.assert_allclose(with_map, without, rtol=1e-4)


def test_a_map_alone_is_metered_as_one_and_keeps_its_colours(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    room = write(tmp_path / "room.exr", rng.uniform(0, 9, (64, 128, 3)))
    painted, metered = environment(Lighting("map", (), 1.0, map=room))
    assert metered == 1.0
    height = len(painted)
    theta = np.linspace(0, np.pi, height)[:, None]
    phi = (2 * np.pi * (np.arange(2 * height) + 0.5) / (2 * height))[None]
    phase = lambert_phase(np.arccos(np.clip(-np.cos(phi) * np.sin(theta), -1, 1)))
    weights = np.broadcast_to(np.sin(theta), phase.shape)
    read = (painted @ LUMINANCE * phase * weights).sum() / weights.sum() * 4
    assert read == pytest.approx(1, rel=1e-4)


def test_a_map_that_lights_nothing_is_refused(tmp_path: Path) -> None:
    black = write(tmp_path / "black.exr", np.zeros((32, 64, 3)))
    with pytest.raises(InputError, match="lights nothing: it is black on all sides"):
        environment(Lighting("map", (), 1.0, map=black))
