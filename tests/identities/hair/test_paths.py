from typing import Any

import numpy as np
import pytest

from lrsr.identities.hair.anchors import load_anchors
from lrsr.identities.hair.paths import (
    COLUMNS,
    Paths,
    _group_tufts,
    follow_paths,
    plan_paths,
    smooth_noise,
)
from lrsr.identities.hair.styles import style_parameters


def plan(style: str, **changes: Any) -> Paths:
    hair = style_parameters(style, np.random.default_rng(5)) | changes
    return plan_paths(hair, load_anchors().template, np.random.default_rng(1))


def test_columns_of_a_crop_go_all_the_way_round() -> None:
    azimuth = plan("crop").azimuth
    assert abs(azimuth[0]) < 1e-9
    assert abs(azimuth[-1]) < 1e-9
    assert np.abs(np.abs(azimuth[COLUMNS // 2 - 1 : COLUMNS // 2 + 1]) - 180.0).max() < 1.0


def test_parted_hair_leaves_the_face_open() -> None:
    assert np.abs(plan("long_straight").azimuth).min() >= 38.0


def test_whorl_is_the_root_of_all_unparted_hair() -> None:
    root = plan("crop", crown_x_deg=2.0, crown_z_deg=-20.0).root
    np.testing.assert_allclose(root, np.broadcast_to([2.0, -20.0], (COLUMNS, 2)))


def test_parting_starts_at_the_front_hairline() -> None:
    paths = plan("bob", parting_deg=0.0)
    assert paths.root[0] == pytest.approx([0.0, 58.0], abs=8.0)
    np.testing.assert_allclose(paths.root[0], paths.root[-1])
    assert paths.on_parting[0] == 1.0


def test_longer_hair_has_longer_columns() -> None:
    short, long = (plan("bob", lower_mm=[y] * 6).length_mm for y in (-60.0, -110.0))
    np.testing.assert_allclose(long - short, 50.0, atol=1e-9)


def test_only_hanging_tips_are_free() -> None:
    assert plan("slicked_back").free.max() == 0.0
    assert plan("long_straight").free.min() == 1.0
    behind = plan("tucked")
    assert behind.free[np.abs(behind.azimuth) < 80.0].max() == 0.0
    assert behind.free[np.abs(behind.azimuth) > 125.0].min() == 1.0


def test_layers_shorten_the_hair_at_the_face_only() -> None:
    plain, layered = (plan("long_straight", layer_mm=mm) for mm in (0.0, 40.0))
    shorter = plain.length_mm - layered.length_mm
    assert shorter[0] == pytest.approx(40.0)
    assert shorter[COLUMNS // 2] == pytest.approx(0.0)


def test_paths_go_from_root_to_where_they_leave_the_skull() -> None:
    paths = plan("bob")
    share = np.tile([0.0, 1.0, 3.0], (COLUMNS, 1))
    flat = follow_paths(paths, share, bow=0.2)
    np.testing.assert_allclose(flat[:, 0], paths.root, atol=1e-9)
    np.testing.assert_allclose(flat[:, 1], paths.leave, atol=1e-9)
    np.testing.assert_allclose(flat[:, 2], paths.leave, atol=1e-9)


def test_bowed_strands_swing_to_the_front() -> None:
    half = np.full((COLUMNS, 1), 0.5)
    straight, bowed = (follow_paths(plan("bob"), half, bow=bow) for bow in (0.0, 0.3))
    assert (bowed - straight)[0, 0, 1] > 5.0
    np.testing.assert_array_equal(bowed[..., 0], straight[..., 0])


def test_tufts_run_from_one_side_to_the_other() -> None:
    tuft = _group_tufts(20.0, np.random.default_rng(0))
    assert np.abs(tuft).max() <= 1.0
    step = np.diff(tuft)
    assert 15 < (step < 0).sum() < 70
    assert step[step > 0].max() < 1.0


def test_noise_has_the_asked_spread() -> None:
    noise = smooth_noise(np.random.default_rng(0), (200, 100), (4.0, 2.0), spread=3.0)
    assert noise.mean() == pytest.approx(0.0, abs=1e-12)
    assert noise.std() == pytest.approx(3.0)
