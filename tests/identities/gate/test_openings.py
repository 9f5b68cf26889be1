import numpy as np
import pytest
from numpy.typing import NDArray

from lrsr.identities.face.eyes import Eyes
from lrsr.identities.face.lids import clear_lids
from lrsr.identities.face.template import template
from lrsr.identities.gate.openings import (
    _covered,
    measure_eyes,
    mouth_area_mm2,
    nostril_area_mm2,
)

Points = NDArray[np.float64]

IRIS_RAD = 0.37
SHEET = np.array([[[-1.0, -1.0, 1.0], [3.0, -1.0, 1.0], [-1.0, 3.0, 1.0]]])


def skin() -> Points:
    """The template, its lids lifted by the corneas."""
    average = template()
    return clear_lids(average.skin, average.eyes, average.lids)


def eyes() -> Eyes:
    return template().eyes


def around_an_eye(which: int, *, above: bool) -> NDArray[np.int64]:
    """Vertices of the upper or the lower lid of one eye."""
    index = template().lids.vertices[which]
    offset = skin()[index] - eyes().pupils[which]
    side = offset[:, 1] > 0.5 if above else offset[:, 1] < -0.5
    return index[side & (np.abs(offset[:, 0]) < 15.0) & (np.abs(offset[:, 1]) < 12.0)]


@pytest.mark.parametrize(
    ("point", "hidden"),
    [((0, 0, 0), True), ((0, 0, 2), False), ((2.9, 2.9, 0), False), ((0, 0, 1), False)],
    ids=["behind", "before", "beside", "on"],
)
def test_only_what_lies_behind_a_sheet_is_covered(
    point: tuple[float, float, float], hidden: bool
) -> None:
    assert _covered(np.array([point], float), SHEET).tolist() == [hidden]


def test_which_way_a_sheet_faces_does_not_matter() -> None:
    points = np.random.default_rng(0).uniform(-2, 4, (200, 3))
    turned = SHEET[:, ::-1]
    np.testing.assert_array_equal(_covered(points, SHEET), _covered(points, turned))


def test_nothing_is_covered_by_nothing_and_by_sheets_seen_edge_on() -> None:
    assert not _covered(np.zeros((3, 3)), np.zeros((0, 3, 3))).any()
    assert not _covered(np.zeros((1, 3)), SHEET[:, :, [2, 1, 0]] * (0.0, 1.0, 1.0)).any()


def test_the_templates_eyes_open_as_adults_eyes_do() -> None:
    for eye in measure_eyes(skin(), eyes(), IRIS_RAD):
        assert eye.pupil_free
        assert 7.0 < eye.height_mm < 12.0
        assert 0.5 < eye.iris_share < 0.95
        assert eye.crossed_mm == pytest.approx(0, abs=0.02)


def test_both_eyes_of_the_template_are_alike() -> None:
    left, right = measure_eyes(skin(), eyes(), IRIS_RAD)
    assert left == pytest.approx(right)


def test_a_larger_iris_shows_less_of_itself() -> None:
    shares = [measure_eyes(skin(), eyes(), rad)[0].iris_share for rad in (0.2, 0.37, 0.5)]
    assert shares == sorted(shares, reverse=True)
    assert shares[0] == 1.0


def test_a_hanging_upper_lid_hides_iris_and_pupil() -> None:
    hanging = skin()
    hanging[around_an_eye(0, above=True), 1] -= 7.0
    closed, other = measure_eyes(hanging, eyes(), IRIS_RAD)
    assert closed.iris_share < 0.4
    assert not closed.pupil_free
    assert other.pupil_free


def test_lids_that_pass_each_other_have_crossed() -> None:
    crossed = skin()
    crossed[around_an_eye(1, above=True), 1] -= 6.0
    crossed[around_an_eye(1, above=False), 1] += 6.0
    usual, wrong = measure_eyes(crossed, eyes(), IRIS_RAD)
    assert wrong.crossed_mm > 0.3
    assert usual.crossed_mm == 0.0


def test_the_template_hardly_shows_its_nostrils() -> None:
    assert nostril_area_mm2(skin()) < 40.0


def test_a_nose_turned_up_shows_more_and_more_of_its_nostrils() -> None:
    areas = []
    for angle in np.radians([0.0, 20.0, 40.0]):
        turned, origin = skin(), np.array([0.0, -30.0, 0.0])
        nose = (np.abs(turned[:, 0]) < 18) & (np.abs(turned[:, 1] + 45) < 13) & (turned[:, 2] > 5)
        y, z = (turned[nose] - origin)[:, 1:].T
        turned[nose, 1] = origin[1] + y * np.cos(angle) + z * np.sin(angle)
        turned[nose, 2] = -y * np.sin(angle) + z * np.cos(angle)
        areas.append(nostril_area_mm2(turned))
    assert areas == sorted(areas)
    assert areas[-1] > 62.0


def test_noses_twice_as_large_show_four_times_the_area() -> None:
    assert nostril_area_mm2(2 * skin()) == pytest.approx(4 * nostril_area_mm2(skin()))


def test_the_template_hardly_shows_the_inside_of_its_mouth() -> None:
    assert mouth_area_mm2(skin()) < 30.0


def test_a_lower_lip_drawn_down_bares_the_inside_of_the_mouth() -> None:
    lowered = skin()
    lip = (np.abs(lowered[:, 0]) < 25) & (np.abs(lowered[:, 1] + 80) < 7) & (lowered[:, 2] > -5)
    lowered[lip, 1] -= 9.0
    assert mouth_area_mm2(lowered) > 48.0
