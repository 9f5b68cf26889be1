import numpy as np
import pytest
from numpy.typing import NDArray

from lrsr.identities.morphable import template
from lrsr.identities.shape.basis import load_basis
from lrsr.identities.shape.proportions import (
    _MEASURES,
    Gauge,
    draw_measures,
    fit_measures,
    load_gauge,
)

NAMES = [measure.name for measure in _MEASURES]


def test_measures_find_their_points_on_the_template() -> None:
    skin = template().skin
    for measure in _MEASURES:
        for point in (measure.high, measure.low):
            assert np.linalg.norm(skin - np.array(point), axis=1).min() < 4.0, measure.name


@pytest.mark.parametrize(
    ("field", "measure", "sign"),
    [
        ("nose/nose-scale-vert-decr-incr/+", "height of the nose", 1),
        ("nose/nose-scale-horiz-decr-incr/+", "width of the nose", 1),
        ("mouth/mouth-scale-horiz-decr-incr/-", "width of the mouth", -1),
        ("chin/chin-height-decr-incr/+", "height of the chin", 1),
        ("eyes/eye-trans-in-out/+", "outer canthi", 1),
        ("nose/nose-scale-depth-decr-incr/+", "protrusion of the nose", 1),
        ("chin/chin-prominent-decr-incr/+", "protrusion of the chin", 1),
    ],
)
def test_fields_change_the_measures_that_their_names_promise(
    field: str, measure: str, sign: int
) -> None:
    effect = load_gauge().effects[NAMES.index(measure), load_basis().column[field]]
    assert sign * effect > 0.5


@pytest.fixture(scope="module")
def drawn() -> NDArray[np.float64]:
    rng = np.random.default_rng(3)
    average = [np.mean(measure.means_mm) for measure in _MEASURES]
    lower_face, *parts = (
        NAMES.index(f"height of the {part}") for part in ("lower face", "upper lip", "chin")
    )
    average[lower_face] = sum(average[part] for part in parts)
    return np.array([draw_measures(rng, 0.5) for _ in range(4000)]) - average


def test_a_sex_moves_means_and_nothing_else() -> None:
    woman, man = (draw_measures(np.random.default_rng(3), masculinity) for masculinity in (0, 1))
    canthi, nose = NAMES.index("inner canthi"), NAMES.index("width of the nose")
    women_mm, men_mm = _MEASURES[canthi].means_mm
    assert man[canthi] - woman[canthi] == pytest.approx(men_mm - women_mm)
    assert man[nose] == woman[nose]


def test_measures_spread_as_those_of_adults_do(drawn: NDArray[np.float64]) -> None:
    spread = drawn.std(axis=0) / [measure.sd_mm for measure in _MEASURES]
    assert spread.min() > 0.9  # the farthest are drawn in
    assert spread.max() < 1.1
    assert np.abs(drawn.mean(axis=0) / [measure.sd_mm for measure in _MEASURES]).max() < 0.06


@pytest.mark.parametrize(
    ("one", "other", "low", "high"),
    [
        ("width between cheekbones", "width between jaw angles", 0.45, 0.65),  # Farkas: 0.6
        ("width of the nose", "width of the mouth", 0.15, 0.35),
        ("width between cheekbones", "height of the nose", -0.06, 0.06),
    ],
)
def test_measures_go_together_as_those_of_adults_do(
    drawn: NDArray[np.float64], one: str, other: str, low: float, high: float
) -> None:
    pair = drawn[:, [NAMES.index(one), NAMES.index(other)]]
    assert low < np.corrcoef(pair.T)[0, 1] < high


def test_a_lower_face_is_as_high_as_lip_and_chin_together(drawn: NDArray[np.float64]) -> None:
    whole, lip, chin = (
        drawn[:, NAMES.index(f"height of the {part}")]
        for part in ("lower face", "upper lip", "chin")
    )
    np.testing.assert_allclose(whole, lip + chin)


def test_both_sides_get_the_same(drawn: NDArray[np.float64]) -> None:
    for left in (name for name in NAMES if "left" in name):
        right = left.replace("left", "right")
        np.testing.assert_array_equal(drawn[:, NAMES.index(left)], drawn[:, NAMES.index(right)])


ENDS = np.array([[0, 1], [2, 3]])


def gauge_of(minus: float, plus: float, *, unseen: bool = False) -> Gauge:
    """A gauge whose first measure is moved by two sliders, or only by the first of them."""
    effects = np.zeros((len(_MEASURES), 4))
    effects[0] = [minus, plus, 0.0 if unseen else minus, 0.0 if unseen else plus]
    return Gauge(effects, np.zeros((3, 4)), np.zeros(3))


def wanted(mm: float) -> NDArray[np.float64]:
    return np.array([mm] + [0.0] * (len(_MEASURES) - 1))


def fit(
    gauge: Gauge,
    drawn: list[float],
    mm: float,
    usual: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0),
    width: tuple[float, float] = (0.5, 0.5),
) -> NDArray[np.float64]:
    return fit_measures(gauge, np.array(usual), np.array(drawn), ENDS, np.array(width), wanted(mm))


@pytest.mark.parametrize("mm", [-6.0, 0.0, 3.0])
def test_sliders_give_the_measure_that_is_wanted(mm: float) -> None:
    values = fit(gauge_of(-4.0, 9.0), [0.7, -0.2], mm)
    measure = sum(9.0 * max(value, 0.0) + 4.0 * min(value, 0.0) for value in values)
    assert measure == pytest.approx(mm, abs=0.1)


def test_a_measure_is_counted_from_that_of_the_average_person() -> None:
    values = fit(gauge_of(-4.0, 4.0, unseen=True), [0.1, 0.0], 2.0, usual=(0.0, 0.25, 0.0, 0.0))
    assert values[0] == pytest.approx(0.75, abs=0.01)


def test_sliders_that_give_it_already_stay_as_drawn() -> None:
    drawn = [0.5, -0.25]
    np.testing.assert_allclose(fit(gauge_of(-4.0, 4.0), drawn, 1.0), drawn, atol=1e-12)


def test_a_slider_that_no_measure_sees_stays_as_drawn() -> None:
    assert fit(gauge_of(-9.0, 9.0, unseen=True), [1.0, 0.7], 0.0)[1] == pytest.approx(0.7)


def test_wide_sliders_give_way_more_than_narrow_ones() -> None:
    values = fit(gauge_of(-3.0, 3.0), [1.0, 1.0], 2.0, width=(0.5, 0.1))
    assert 1 - values[0] > 5 * (1 - values[1])


def test_the_input_is_left_alone() -> None:
    drawn, usual = np.array([1.0, 0.5]), np.zeros(4)
    fit_measures(gauge_of(-4.0, 4.0), usual, drawn, ENDS, np.full(2, 0.5), wanted(1.0))
    assert drawn.tolist() == [1.0, 0.5]
    assert not usual.any()
