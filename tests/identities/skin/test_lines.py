import json

import numpy as np
import pytest

from lrsr.identities.skin.canvas import Canvas, FloatMap
from lrsr.identities.skin.lines import _Engraving, draw_lines, sample_lines

FACE = Canvas(left_mm=-84.0, top_mm=100.0, width_mm=168.0, height_mm=230.0, pixel_mm=0.4)
SMOOTH = {
    "forehead": 0.0,
    "glabella": 0.0,
    "crows_feet": 0.0,
    "under_eye": 0.0,
    "nasolabial": 0.0,
    "marionette": 0.0,
    "forehead_count": 3,
    "paths_seed": 1,
    "eye_bags": 0.0,
    "upper_lip": 0.0,
    "cheeks": 0.0,
    "chin": 0.0,
    "lid_crease": 0.0,
}


def _row(y: float) -> int:
    return int((FACE.top_mm - y) / FACE.pixel_mm)


def _carved(
    begin_mm: float, end_mm: float, y_mm: float, depth_mm: float, width_mm: float
) -> FloatMap:
    cuts = _Engraving(FACE)
    middle = (begin_mm + end_mm) / 2
    cuts.carve([(begin_mm, y_mm), (middle, y_mm), (end_mm, y_mm)], depth_mm, width_mm)
    return cuts.heights()


def test_a_groove_has_the_depth_and_the_gaussian_profile_it_was_given() -> None:
    profile = _carved(-40.0, 40.0, 0.1, depth_mm=0.8, width_mm=1.2)[:, FACE.shape[1] // 2]
    assert profile.min() == pytest.approx(-0.8, rel=0.03)
    at = int(profile.argmin())
    assert profile[at + 3] == pytest.approx(-0.8 * np.exp(-0.5), rel=0.06)  # 1.2 mm away
    assert profile[at + 6] == pytest.approx(-0.8 * np.exp(-2.0), rel=0.15)


def test_a_groove_takes_the_nearest_width() -> None:
    np.testing.assert_array_equal(_carved(-9, 9, 0, 0.5, 1.3), _carved(-9, 9, 0, 0.5, 1.2))


def test_a_groove_runs_out_at_its_ends() -> None:
    along = _carved(-30.0, 30.0, 0.0, depth_mm=1.0, width_mm=0.8).min(axis=0)
    near_end = int((-29.0 - FACE.left_mm) / FACE.pixel_mm)
    assert along[near_end] > 0.5 * along.min()
    assert (along[: near_end - 20] == 0).all()


def test_a_groove_beyond_the_sheet_or_of_no_depth_changes_nothing() -> None:
    assert not _carved(300.0, 330.0, 0.0, depth_mm=1.0, width_mm=1.2).any()
    assert not _carved(-30.0, 30.0, 0.0, depth_mm=0.0, width_mm=1.2).any()


def test_a_groove_may_leave_the_sheet() -> None:
    sheet = _carved(-200.0, 200.0, 0.0, depth_mm=1.0, width_mm=1.2)
    assert sheet.min() == pytest.approx(-1.0, rel=0.05)


def test_a_smooth_face_has_no_lines() -> None:
    assert not draw_lines(SMOOTH, FACE).any()


@pytest.mark.parametrize(
    ("group", "place", "elsewhere"),
    [
        ("forehead", (0.0, 48.0), (0.0, -60.0)),
        ("glabella", (5.0, 18.0), (0.0, 60.0)),
        ("crows_feet", (56.0, -1.0), (0.0, 0.0)),
        ("under_eye", (28.0, -14.0), (28.0, 20.0)),
        ("lid_crease", (32.0, 7.0), (32.0, -40.0)),
        ("cheeks", (46.0, -55.0), (0.0, -55.0)),
        ("upper_lip", (5.0, -59.0), (0.0, 40.0)),
        ("chin", (5.0, -91.5), (0.0, 0.0)),
        ("nasolabial", (28.0, -57.0), (0.0, -57.0)),
        ("marionette", (31.0, -88.0), (0.0, -88.0)),
    ],
)
def test_each_group_lies_in_its_place_on_both_sides(
    group: str, place: tuple[float, float], elsewhere: tuple[float, float]
) -> None:
    sheet = draw_lines(SMOOTH | {group: 1.0}, FACE)

    def deepest(x: float, y: float, reach: int = 14) -> float:
        column = int((x - FACE.left_mm) / FACE.pixel_mm)
        return sheet[_row(y) - reach : _row(y) + reach, column - reach : column + reach].min()

    assert deepest(*place) < -0.06
    assert deepest(-place[0], place[1]) < -0.06
    assert abs(deepest(*elsewhere)) < 1e-6


def test_bags_under_the_eyes_stand_out() -> None:
    sheet = draw_lines(SMOOTH | {"eye_bags": 1.0}, FACE)
    column = int((30.0 - FACE.left_mm) / FACE.pixel_mm)
    assert sheet[:, column].max() > 0.5
    assert sheet.min() == 0
    assert abs(FACE.top_mm - sheet[:, column].argmax() * FACE.pixel_mm + 17.0) < 3.0


def test_a_negative_depth_makes_a_ridge() -> None:
    groove, ridge = (_carved(-30.0, 30.0, 0.0, depth, 1.2) for depth in (0.5, -0.5))
    np.testing.assert_array_equal(ridge, -groove)


WORN = ("forehead", "glabella", "crows_feet", "under_eye", "marionette", "eye_bags", "upper_lip")


def _depths(group: str, ages: tuple[float, ...]) -> list[float]:
    depths = []
    for age in ages:
        rng = np.random.default_rng(0)
        depths.append(
            float(np.mean([sample_lines(rng, age=age, masculinity=0.5)[group] for _ in range(60)]))
        )
    return depths


@pytest.mark.parametrize("group", [*WORN, "nasolabial", "chin", "cheeks"])
def test_lines_deepen_with_age(group: str) -> None:
    depths = _depths(group, (0.0, 0.4, 0.6, 0.8, 1.0))
    assert depths == sorted(set(depths))


@pytest.mark.parametrize("group", WORN)
def test_at_25_nothing_is_worn_and_at_75_most_of_it(group: str) -> None:
    young, old = _depths(group, (0.0, 1.0))
    assert young == 0.0
    assert 1.0 < old < 1.7


def test_no_line_is_deeper_than_a_deep_wrinkle() -> None:
    rng = np.random.default_rng(1)
    oldest = [sample_lines(rng, age=1.0, masculinity=0.5) for _ in range(300)]
    assert max(person[group] for person in oldest for group in WORN) <= 1.7
    sheets = [draw_lines(person, FACE) for person in oldest[:6]]
    assert min(sheet.min() for sheet in sheets) > -2.5  # mm


def test_the_fold_beside_the_nose_is_there_from_youth() -> None:
    lines = sample_lines(np.random.default_rng(0), age=0.0, masculinity=0.5)
    assert 0.06 <= lines["nasolabial"] <= 0.21
    assert json.loads(json.dumps(lines)) == lines
