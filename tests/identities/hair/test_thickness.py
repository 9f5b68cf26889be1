from typing import Any

import numpy as np
import pytest

from lrsr.identities.hair.anchors import load_anchors
from lrsr.identities.hair.paths import plan_paths
from lrsr.identities.hair.styles import style_parameters
from lrsr.identities.hair.thickness import Course, lay_thickness

BARE = {"front_lift_mm": 0.0, "parting_dip": 0.0}


def lay(style: str, share: float, polar: float, **changes: Any) -> Any:
    hair = style_parameters(style, np.random.default_rng(5)) | BARE | changes
    paths = plan_paths(hair, load_anchors().template, np.random.default_rng(1))
    along = paths.length_mm[:, None] * np.array([[share, share]])
    down = np.maximum(along - paths.over_skull_mm[:, None], 0.0)
    azimuth = np.repeat(paths.azimuth[:, None], 2, axis=1)
    course = Course(along, down, azimuth, np.full_like(along, polar))
    height, fade = lay_thickness(hair, paths, course)
    return height[:, 0], fade[:, 0], paths


def test_crown_is_as_thick_as_the_top() -> None:
    height, fade, _ = lay("crop", 0.0, 20.0, top_mm=12.0)
    np.testing.assert_allclose(height, 12.0)
    np.testing.assert_allclose(fade, 1.0)


def test_hair_dips_below_the_skin_at_a_hairline() -> None:
    height, fade, _ = lay("slicked_back", 1.0, 60.0)
    np.testing.assert_allclose(height, -2.4)
    np.testing.assert_allclose(fade, 0.0)


def test_hanging_tips_keep_their_thickness() -> None:
    height, fade, paths = lay("long_straight", 1.0, 80.0, tip_mm=5.0, side_mm=9.0, back_mm=9.0)
    np.testing.assert_allclose(height[paths.leading == 1.0], 5.0)
    assert fade[paths.leading == 1.0].min() == 1.0


def test_sides_and_back_have_their_own_thickness() -> None:
    height, _, paths = lay("crop", 0.0, 90.0, side_mm=4.0, back_mm=8.0)
    away = np.abs(paths.azimuth)
    assert height[away < 90.0] == pytest.approx(4.0)
    assert height[away > 135.0] == pytest.approx(8.0)


def test_lift_raises_the_front() -> None:
    plain, _, paths = lay("quiff", 0.3, 50.0)
    raised, _, _ = lay("quiff", 0.3, 50.0, front_lift_mm=10.0)
    front = np.abs(paths.azimuth) < 5.0
    assert (raised - plain)[front].max() == pytest.approx(10.0, abs=0.5)
    assert np.abs(raised - plain)[np.abs(paths.azimuth) > 120.0].max() < 0.01


def test_round_hair_falls_steeper_at_its_edge() -> None:
    soft, _, _ = lay("afro", 0.85, 60.0, roundness=0.0, taper_mm=40.0)
    round_, _, _ = lay("afro", 0.85, 60.0, roundness=1.0, taper_mm=40.0)
    assert (round_ > soft).all()


def test_bald_front_of_a_horseshoe_is_sunk() -> None:
    height, _, paths = lay("horseshoe", 0.5, 70.0, bald_deg=50.0)
    assert height[np.abs(paths.azimuth) < 25.0].max() < -4.0
    assert height[np.abs(paths.azimuth) > 120.0].min() > 0.0


def test_bun_stands_on_the_back_of_the_crown() -> None:
    plain, _, paths = lay("pulled_back", 0.5, 30.0, bun_mm=0.0)
    knotted, _, _ = lay("pulled_back", 0.5, 30.0, bun_mm=40.0, bun_z_deg=-30.0)
    rise, away = knotted - plain, np.abs(paths.azimuth)
    assert rise[away > 178.0].max() == pytest.approx(40.0, abs=1.0)
    assert rise[away < 90.0].max() == 0.0
