import numpy as np
import pytest
from numpy.typing import NDArray
from oracles.lids import pierced_mm

from lrsr.identities.face.eyes import Eyes, find_eyes
from lrsr.identities.face.lids import (
    _MARGIN_POINTS,
    Lids,
    _lid_heights,
    clear_lids,
    closing_strengths,
    lid_margins,
    rest_lids,
)
from lrsr.identities.face.resting import rest_face
from lrsr.identities.face.template import template
from lrsr.identities.shape.basis import load_basis


def make_eyes() -> Eyes:
    forwards = (0.0, 0.0, 1.0)
    return Eyes(
        np.array([[-30.0, 0.0, -12.0], [30.0, 0.0, -12.0]]),
        np.array([12.0, 12.0]),
        np.array([forwards, forwards]),
    )


def lids_of(points: NDArray[np.float64], eyes: Eyes) -> Lids:
    """A few loose points around the image's left eye, without margins."""
    away = np.linalg.norm(points - eyes.centres[0], axis=1) / eyes.radii[0]
    near, none = np.flatnonzero(away < 1.5), np.zeros(0, np.int64)
    return Lids((near, none), (away[near], np.zeros(0)), ())


def test_lids_that_clear_the_eye_stay_and_pierced_ones_are_pushed_out() -> None:
    eyes = make_eyes()
    usual = np.array([[-30.0, 8.0, -2.0], [-30.0, 9.0, -2.0], [-30.0, 60.0, 0.0]])
    lids = lids_of(usual, eyes)
    pierced = usual.copy()
    pierced[0] = [-30.0, 7.0, -4.0]
    moved = clear_lids(pierced, eyes, lids)
    assert np.linalg.norm(moved[0] - eyes.centres[0]) == pytest.approx(12.36)  # 1.03 radii
    np.testing.assert_array_equal(moved[1:], usual[1:])


def test_rims_that_dip_into_the_eye_keep_doing_so() -> None:
    eyes = make_eyes()
    usual = np.array([[-30.0, 0.0, -0.6]])  # 0.95 radii
    floating = np.array([[-30.0, 0.0, 2.0]])
    moved = clear_lids(floating, eyes, lids_of(usual, eyes))
    assert np.linalg.norm(moved[0] - eyes.centres[0]) == pytest.approx(0.985 * 1.06 * 12)


def test_clearing_the_template_makes_room_for_the_cornea_alone() -> None:
    average = template()
    moved = clear_lids(average.skin, average.eyes, average.lids)
    assert np.abs(moved - average.skin).max() < 0.6


def test_clearing_the_lids_heals_what_was_pierced() -> None:
    average = template()
    pierced = clear_lids(average.skin, average.eyes, average.lids)
    assert pierced_mm(pierced, average.eyes, average.lids) < 0.02
    index = average.lids.vertices[0]
    above = average.skin[index, 1] - average.eyes.pupils[0, 1]
    pierced[index[(above > 0.5) & (above < 12.0)], 2] -= 2.0
    assert 0.8 < pierced_mm(pierced, average.eyes, average.lids) < 2.1
    healed = clear_lids(pierced, average.eyes, average.lids)
    assert pierced_mm(healed, average.eyes, average.lids) < 0.02


def test_faces_at_rest_have_lids_that_clear_their_eyes() -> None:
    face = rest_face(load_basis().neutral)
    assert pierced_mm(face.skin, face.eyes, template().lids) < 0.1


def test_margins_run_along_the_eyeball_from_the_inner_corner_to_the_outer() -> None:
    average = template()
    margins = lid_margins(average.skin, average.eyes, average.lids)
    assert margins.shape == (2, 2, _MARGIN_POINTS, 3)
    offset = margins - average.eyes.centres[:, None, None]
    distance = np.linalg.norm(offset, axis=-1) / average.eyes.radii[:, None, None]
    np.testing.assert_allclose(distance, 1.0, atol=0.02)
    across = np.abs(margins[..., 0])
    assert (across[..., -1] - across[..., 0] > 20).all()
    upper, lower = margins[:, 0, 8:-8, 1], margins[:, 1, 8:-8, 1]
    assert (upper - lower > 5).all()
    np.testing.assert_allclose(margins[0] * [-1, 1, 1], margins[1], atol=0.2)


def test_lids_of_the_average_adult_stand_where_those_of_adults_do_and_stay() -> None:
    basis, lids = load_basis(), template().lids
    heights = _lid_heights(basis, basis.neutral, lids)
    assert heights == pytest.approx([4.0, 4.0], abs=0.6)
    rested = rest_lids(basis, basis.neutral, lids)
    assert _lid_heights(basis, rested, lids) == pytest.approx(heights, abs=0.3)


@pytest.mark.parametrize(("unit", "strength"), [("eyeWide", 0.8), ("eyeBlink", 0.35)])
def test_startled_and_drooping_lids_come_to_rest(unit: str, strength: float) -> None:
    basis, lids = load_basis(), template().lids
    weights = basis.neutral.copy()
    for side in ("Left", "Right"):
        weights[basis.column[f"unit/{unit}{side}"]] += strength
    before, after = (
        _lid_heights(basis, w, lids) for w in (weights, rest_lids(basis, weights, lids))
    )
    assert np.all((before < 2.4) | (before > 5.2))
    assert np.all((after > 2.4) & (after < 5.2))


def test_the_average_eye_closes_at_full_strength_and_a_larger_one_beyond() -> None:
    basis, lids = load_basis(), template().lids
    larger = basis.neutral.copy()
    for slider in ("eyes/eye-scale-decr-incr/+", "eyes/eye-height2-decr-incr/+"):
        larger[basis.column[slider]] += 1.0
    assert closing_strengths(basis, basis.neutral, lids) == pytest.approx([1.0, 1.0], abs=0.2)
    assert (closing_strengths(basis, larger, lids) > 1.1).all()


def test_lids_meet_at_the_strength_that_closes_them() -> None:
    basis, lids = load_basis(), template().lids
    weights = basis.neutral.copy()
    weights[basis.column["eyes/eye-scale-decr-incr/+"]] += 1.0
    strengths = closing_strengths(basis, weights, lids)
    for strength, side in zip(strengths, ("Right", "Left"), strict=True):
        weights[basis.column[f"unit/eyeBlink{side}"]] = strength
    head = basis.shape(weights)
    margins = lid_margins(basis.surface.matrix @ head.skin, find_eyes(basis, head), lids)
    apart = (margins[:, 0] - margins[:, 1])[:, 12:-12, 1]
    assert (apart < 0.0).all()
    assert (apart > -5.0).all()
