import json

import numpy as np
import pytest
from numpy.typing import NDArray

from lrsr.identities.skin import brows as eyebrows
from lrsr.identities.skin.brows import (
    CANVAS,
    Brows,
    _brow_line,
    _brow_strands,
    _brow_thickness,
    cover_brows,
    lay_brows,
)

PLAIN = {
    "start_mm": 12.0,
    "end_mm": 50.0,
    "height_mm": 0.0,
    "arch_mm": 4.0,
    "peak": 0.6,
    "slope_mm": 0.0,
    "tail_mm": 2.0,
    "thickness_mm": 4.2,
    "taper": 0.7,
    "density": 1.0,
    "strand_mm": 6.0,
    "bridge": 0.0,
    "unevenness_mm": 0.0,
    "sparse_tail": 0.0,
}


def _coverage(brows: dict[str, float], seed: int = 0) -> NDArray[np.float64]:
    return cover_brows(lay_brows(brows, np.random.default_rng(seed))).astype(float)


def test_a_plain_brow_has_420_strands() -> None:
    assert _brow_strands(PLAIN, np.random.default_rng(0)).shape == (420, 4, 2)


@pytest.mark.parametrize("masculinity", [0.0, 0.5, 1.0])
def test_samples_keep_to_the_recipes_ranges(masculinity: float) -> None:
    rng = np.random.default_rng(1)
    drawn = [eyebrows.sample_brows(rng, masculinity=masculinity, age=0.3) for _ in range(300)]
    limits = {
        "start_mm": (9.0, 22.0),
        "end_mm": (42.0, 60.0),
        "arch_mm": (0.3, 6.3),
        "peak": (0.44, 0.82),
        "thickness_mm": (2.6, 10.0),
        "bridge": (0, 1),
    }
    for name, (low, high) in limits.items():
        values = [brows[name] for brows in drawn]
        assert low <= min(values), name
        assert max(values) <= high, name
    assert json.loads(json.dumps(drawn[0])) == drawn[0]


def _sample(masculinity: float, count: int = 400) -> list[Brows]:
    rng = np.random.default_rng(2)
    return [eyebrows.sample_brows(rng, masculinity=masculinity, age=0.3) for _ in range(count)]


def test_womens_brows_are_thinner_higher_and_more_arched_than_mens() -> None:
    women, men = _sample(0.15), _sample(0.85)  # the averages of both sexes

    def mean(people: list[Brows], name: str) -> float:
        return float(np.mean([person[name] for person in people]))

    assert mean(women, "thickness_mm") < 0.75 * mean(men, "thickness_mm")
    assert mean(women, "height_mm") > mean(men, "height_mm") + 1.5
    assert mean(women, "arch_mm") > mean(men, "arch_mm") + 0.8


def test_womens_brows_thin_out_with_age_and_mens_do_not() -> None:
    def density(masculinity: float, age: float) -> float:
        draws = (np.random.default_rng(seed) for seed in range(200))
        brows = [
            eyebrows.sample_brows(rng, masculinity=masculinity, age=age)["density"] for rng in draws
        ]
        return float(np.mean(brows))

    assert density(0.1, 1.0) < 0.8 * density(0.1, 0.0)
    assert density(1.0, 1.0) == density(1.0, 0.0)


@pytest.mark.parametrize("masculinity", [0.02, 0.25, 0.75, 0.98])
def test_brows_keep_away_from_the_upper_lid_and_from_the_forehead(masculinity: float) -> None:
    along = np.linspace(0, 1, 101)
    for brows in _sample(masculinity):
        line, thickness = _brow_line(brows, along), _brow_thickness(brows, along)
        over_pupil = np.abs(line[:, 0] - 32.0).argmin()
        assert line[over_pupil, 1] - thickness[over_pupil] / 2 > 7.0  # the lid is at 4
        assert line[over_pupil, 1] + thickness[over_pupil] / 2 < 32.0


def test_the_line_runs_from_nose_to_temple_and_peaks_where_told() -> None:
    along = np.linspace(0, 1, 401)
    line = _brow_line(PLAIN, along)
    assert line[0, 0] == 12.0
    assert line[-1, 0] == 50.0
    assert along[line[:, 1].argmax()] == pytest.approx(0.6, abs=0.01)


def test_the_brow_tapers_to_a_tip() -> None:
    thickness = _brow_thickness(PLAIN, np.array([0.25, 0.6, 0.9, 1.0]))
    assert thickness[0] == pytest.approx(4.2)
    assert (np.diff(thickness) < 0).all()
    assert thickness[-1] == pytest.approx(0.42)


def test_brows_lie_above_the_eyes_on_both_sides() -> None:
    sheet = _coverage(PLAIN)
    rows, columns = np.nonzero(sheet > 60)
    x = CANVAS.left_mm + (columns + 0.5) * CANVAS.pixel_mm
    y = CANVAS.top_mm - (rows + 0.5) * CANVAS.pixel_mm
    assert y.min() > 8
    assert y.max() < 28
    assert 7 < np.abs(x).min() < 14
    assert np.mean(x < 0) == pytest.approx(0.5, abs=0.03)


def test_denser_and_thicker_brows_cover_more() -> None:
    dense, thick = PLAIN | {"density": 2.0}, PLAIN | {"thickness_mm": 8.0}
    assert _coverage(dense).sum() > 1.2 * _coverage(PLAIN).sum()
    assert _coverage(thick).sum() > 1.5 * _coverage(PLAIN).sum()


def test_no_tail_ends_far_above_the_head_and_few_brows_meet() -> None:
    rng = np.random.default_rng(3)
    drawn = [eyebrows.sample_brows(rng, masculinity=m, age=0.3) for m in np.tile([0.1, 0.9], 500)]
    ends = np.array([_brow_line(brows, np.array([0.0, 1.0]))[:, 1] for brows in drawn])
    assert (ends[:, 1] - ends[:, 0] < 2.0).all()
    assert 0.0 < np.mean([brows["bridge"] > 0 for brows in drawn]) < 0.03


def test_hairs_stand_up_at_the_nose_and_lie_down_towards_the_temple() -> None:
    hairs = _brow_strands(PLAIN, np.random.default_rng(0))
    move = hairs[:, -1] - hairs[:, 0]
    steep = np.abs(np.arctan2(move[:, 1], move[:, 0]))
    head, tail = hairs[:, 0, 0] < 16, hairs[:, 0, 0] > 40
    assert np.median(steep[head]) > np.radians(55)
    assert np.median(steep[tail]) < np.radians(40)


def test_skin_shows_between_the_hairs_and_more_in_a_sparse_tail() -> None:
    sheet = _coverage(PLAIN)
    assert 0.2 * 255 < sheet[sheet > 20].mean() < 0.75 * 255
    outer = np.abs(CANVAS.left_mm + (np.arange(sheet.shape[1]) + 0.5) * CANVAS.pixel_mm) > 42
    sparse = _coverage(PLAIN | {"sparse_tail": 1.0})
    assert sparse[:, outer].sum() < 0.8 * sheet[:, outer].sum()


def test_a_bridge_joins_the_brows() -> None:
    middle = slice(int(61 / CANVAS.pixel_mm), int(71 / CANVAS.pixel_mm))
    assert _coverage(PLAIN)[:, middle].max() < 20
    assert _coverage(PLAIN | {"bridge": 1.0})[:, middle].max() > 100


def test_the_same_seed_draws_the_same_hairs() -> None:
    np.testing.assert_array_equal(_coverage(PLAIN, 5), _coverage(PLAIN, 5))
    assert (_coverage(PLAIN, 5) != _coverage(PLAIN, 6)).any()
