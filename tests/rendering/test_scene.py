"""Poses and lightings: directions, the meter's law, and that conf says the same as the tables."""

import numpy as np
import pytest
from hydra.utils import instantiate
from omegaconf import OmegaConf

from lrsr.errors import InputError
from lrsr.paths import config_folder
from lrsr.rendering.scene import (
    LIGHTINGS,
    LUMINANCE,
    PIVOT_MM,
    POSES,
    Light,
    Lighting,
    Pose,
    environment,
    find_lighting,
    find_pose,
    lambert_phase,
)


@pytest.mark.parametrize(
    ("pose", "nose", "crown"),
    [
        (Pose("left", yaw_deg=90), (1, 0, 0), (0, 1, 0)),
        (Pose("up", pitch_deg=90), (0, 1, 0), (0, 0, -1)),
        (Pose("tipped", roll_deg=90), (0, 0, 1), (1, 0, 0)),
    ],
    ids=lambda value: getattr(value, "name", ""),
)
def test_positive_angles_turn_as_documented(pose: Pose, nose: tuple, crown: tuple) -> None:
    np.testing.assert_allclose(pose.rotation() @ [0, 0, 1], nose, atol=1e-12)
    np.testing.assert_allclose(pose.rotation() @ [0, 1, 0], crown, atol=1e-12)


def test_a_pose_is_rigid() -> None:
    rotation = Pose("any", 33, -21, 8).rotation()
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(rotation) == pytest.approx(1)


def test_the_pivot_stays_where_it_is() -> None:
    np.testing.assert_allclose(Pose("any", 33, -21, 8).turn(PIVOT_MM[None]), PIVOT_MM[None])


def test_a_frontal_head_does_not_move() -> None:
    assert POSES["frontal"].frame_offset_mm() == (0.0, 0.0)


def test_a_pose_refuses_nan() -> None:
    with pytest.raises(InputError, match="give finite numbers"):
        Pose("broken", yaw_deg=float("nan"))


def test_poses_are_found_by_name_and_changed() -> None:
    assert find_pose("left", yaw_deg=12.0) == Pose("left", yaw_deg=12.0)
    assert find_pose(Pose("own", 1.0)) == Pose("own", 1.0)


def test_an_unknown_pose_names_the_known() -> None:
    with pytest.raises(InputError, match="'sideways' does not exist; choose one of frontal, up"):
        find_pose("sideways")


def test_lightings_are_found_by_name_and_changed() -> None:
    assert find_lighting("side", fill_share=0.5).fill_share == 0.5
    assert find_lighting(LIGHTINGS["below"]) is not None


def test_an_unknown_lighting_names_the_known() -> None:
    with pytest.raises(InputError, match="'sun' does not exist; choose one of frontal, above"):
        find_lighting("sun")


@pytest.mark.parametrize("group", ["pose", "lighting"])
def test_the_configuration_offers_exactly_the_tables(group: str) -> None:
    table = {"pose": POSES, "lighting": LIGHTINGS}[group]
    files = {path.stem: path for path in (config_folder() / group).glob("*.yaml")}
    assert {name: instantiate(OmegaConf.load(path)) for name, path in files.items()} == table


def test_lights_from_a_configuration_are_values() -> None:
    config = OmegaConf.create(
        {
            "_target_": "lrsr.rendering.Lighting",
            "name": "window",
            "lights": [
                {"azimuth_deg": 40, "elevation_deg": 50, "rgb": [1, 0.9, 0.7]},
            ],
        }
    )
    light = Light(azimuth_deg=40, elevation_deg=50, rgb=(1, 0.9, 0.7))
    lighting = instantiate(config)
    assert lighting == Lighting("window", (light,))
    assert hash(lighting) == hash(Lighting("window", (light,)))


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


@pytest.mark.parametrize(
    ("lights", "share", "fill"),
    [
        ((), 0.5, (1, 1, 1)),
        ((Light(0, 0),), 1.0, (1, 1, 1)),
        ((Light(0, 0),), -0.1, (1, 1, 1)),
        ((Light(0, 0),), 0.2, (0, 0, 0)),
    ],
    ids=["dark", "no room for the light", "negative", "no colour"],
)
def test_a_lighting_refuses_what_cannot_be(lights: tuple, share: float, fill: tuple) -> None:
    with pytest.raises(InputError, match="lighting 'bad'"):
        Lighting("bad", lights, share, fill)


@pytest.mark.parametrize(
    "broken",
    [{"irradiance": 0.0}, {"diameter_deg": 0.0}, {"diameter_deg": 200.0}, {"rgb": (1, -1, 0)}],
)
def test_a_light_refuses_what_cannot_be(broken: dict) -> None:
    with pytest.raises(InputError, match="light: irradiance"):
        Light(0, 0, **broken)
