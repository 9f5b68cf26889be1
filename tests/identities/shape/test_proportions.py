import numpy as np
import pytest

from lrsr.identities.morphable import template
from lrsr.identities.shape.basis import load_basis
from lrsr.identities.shape.proportions import MEASURES, Gauge, load_gauge, restrain

NAMES = [measure.name for measure in MEASURES]


def test_measures_find_their_points_on_the_template() -> None:
    skin = template().skin
    for measure in MEASURES:
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


def gauge_of(effects: list[list[float]], limits: list[float]) -> Gauge:
    return Gauge(np.array(effects), np.array(limits))


def test_a_measure_far_beyond_its_limit_comes_back_to_it() -> None:
    gauge = gauge_of([[-4.0, 4.0]], [1.0])
    kept = restrain(gauge, np.array([1.0]), np.array([[0, 1]]), np.array([0.5]))
    assert 4.0 * kept[0] == pytest.approx(1.0, abs=0.05)


def test_sliders_within_half_the_limits_stay_as_drawn() -> None:
    gauge = gauge_of([[-4.0, 4.0, 0.0, 1.0]], [10.0])
    drawn = np.array([1.0, -0.5])
    kept = restrain(gauge, drawn, np.array([[0, 1], [2, 3]]), np.array([0.5, 0.5]))
    np.testing.assert_allclose(kept, drawn, atol=1e-12)


def test_a_slider_that_no_measure_sees_stays_as_drawn() -> None:
    gauge = gauge_of([[-9.0, 9.0, 0.0, 0.0]], [1.0])
    kept = restrain(gauge, np.array([1.0, 0.7]), np.array([[0, 1], [2, 3]]), np.array([0.5, 0.5]))
    assert kept[1] == pytest.approx(0.7)


def test_wide_sliders_give_way_more_than_narrow_ones() -> None:
    gauge = gauge_of([[-3.0, 3.0, -3.0, 3.0]], [2.0])
    kept = restrain(gauge, np.array([1.0, 1.0]), np.array([[0, 1], [2, 3]]), np.array([0.5, 0.1]))
    assert 1 - kept[0] > 5 * (1 - kept[1])


def test_mirror_images_are_restrained_alike() -> None:
    gauge = gauge_of([[-3.0, 3.0], [2.0, -2.0]], [1.0, 3.0])
    ends = np.array([[0, 1]])
    up = restrain(gauge, np.array([0.9]), ends, np.array([0.4]))
    down = restrain(gauge, np.array([-0.9]), ends, np.array([0.4]))
    np.testing.assert_allclose(up, -down)


def test_the_input_is_left_alone() -> None:
    drawn = np.array([1.0])
    restrain(gauge_of([[-4.0, 4.0]], [1.0]), drawn, np.array([[0, 1]]), np.array([0.5]))
    assert drawn.tolist() == [1.0]
