"""Angles between people, and who has to be drawn again."""

import itertools
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from lrsr.errors import ScoreError
from lrsr.evaluation.distinctness import (
    Distinct,
    Drawn,
    Pair,
    _unit_rows,
    closest_pairs,
    draw_distinct,
    pairwise_angles_deg,
    summarise,
)

NOBODY = [np.nan, np.nan, np.nan]


def people(count: int, seed: int = 0, dimension: int = 3) -> NDArray[np.float64]:
    return np.random.default_rng(seed).normal(size=(count, dimension))


class Crowd:
    """Embeds people: at the angle on a circle that is given, else anywhere; notes who was asked."""

    def __init__(self, angles_deg: Mapping[Drawn, float] | None = None) -> None:
        self.angles_deg = dict(angles_deg or {})
        self.asked: list[Drawn] = []

    def __call__(self, drawn: Sequence[Drawn]) -> NDArray[np.float64]:
        self.asked += drawn
        return np.stack([self._row(one) for one in drawn])

    def _row(self, one: Drawn) -> NDArray[np.float64]:
        if one in self.angles_deg:
            angle = np.radians(self.angles_deg[one])
            return 3.0 * np.array([np.cos(angle), np.sin(angle), 0 * angle])
        return np.random.default_rng(one).normal(size=3)


def distinct(crowd: Crowd, count: int, angle_deg: float = 20.0, most: int = 5) -> Distinct:
    return draw_distinct(range(count), crowd, smallest_angle_deg=angle_deg, most_redraws=most)


def one_by_one(crowd: Crowd, count: int, angle_deg: float, most: int) -> tuple[int, ...]:
    """The slow and obvious way: settle the first, then the second, ..."""
    left: list[NDArray[np.float64]] = []
    draws = []
    for index in range(count):
        rows = [crowd([(index, draw)])[0] for draw in range(most + 1)]
        nearest = [
            min([np.inf, *(pairwise_angles_deg(np.stack([row, other]))[0] for other in left)])
            for row in rows
        ]
        far = [draw for draw, angle in enumerate(nearest) if angle >= angle_deg]
        draws.append(far[0] if far else int(np.argmax(nearest)))
        left.append(rows[draws[-1]])
    return tuple(draws)


def test_angles_are_those_of_each_pair_in_order() -> None:
    rows = people(700)  # more than one block
    found = pairwise_angles_deg(rows)
    assert found.shape == (700 * 699 // 2,)
    assert found.dtype == np.float32
    pairs = list(itertools.combinations(range(700), 2))
    for k in (0, 1, 698, 699, 100_000, 200_000, len(pairs) - 1):
        a, b = rows[pairs[k][0]], rows[pairs[k][1]]
        between = np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))
        assert found[k] == pytest.approx(between, abs=1e-4)


def test_the_length_of_an_embedding_does_not_count() -> None:
    rows = people(20)
    longer = rows * np.geomspace(0.01, 100, 20)[:, None]
    assert pairwise_angles_deg(longer) == pytest.approx(pairwise_angles_deg(rows), abs=1e-3)


def test_who_was_not_found_is_in_no_pair() -> None:
    rows = people(6)
    rows[[1, 4]] = np.nan
    np.testing.assert_array_equal(
        pairwise_angles_deg(rows), pairwise_angles_deg(rows[[0, 2, 3, 5]])
    )


@pytest.mark.parametrize("rows", [[[1.0, 0, 0]], [NOBODY, [1.0, 0, 0]], np.empty((0, 3))])
def test_nobody_to_compare_with_is_no_angle(rows: object) -> None:
    assert pairwise_angles_deg(rows).shape == (0,)  # type: ignore[arg-type]  # an array or a list
    assert closest_pairs(rows, 3) == []  # type: ignore[arg-type]


def test_a_person_is_at_no_angle_from_himself() -> None:
    for row in people(50):  # the cosine of some with themselves exceeds 1 by rounding
        angles = pairwise_angles_deg([row, row, -3 * row])
        assert angles == pytest.approx([0.0, 180.0, 180.0], abs=1e-4)


def test_unit_rows_have_length_one_and_keep_their_direction() -> None:
    rows = np.array([[3.0, 4.0], [0.0, -0.5]], dtype=np.float32)
    assert _unit_rows(rows).tolist() == [[0.6, 0.8], [0.0, -1.0]]


@pytest.mark.parametrize("count", [0, 1, 10, 10**6])
def test_the_closest_pairs_are_those_of_the_smallest_angles(count: int) -> None:
    rows = people(600)[: 600 if count < 100 else 30]
    found = closest_pairs(rows, count)
    angles = pairwise_angles_deg(rows)
    order = np.argsort(angles, kind="stable")[:count]
    pairs = list(itertools.combinations(range(len(rows)), 2))
    assert [(pair.first, pair.second) for pair in found] == [pairs[k] for k in order]
    assert [pair.angle_deg for pair in found] == pytest.approx(angles[order], abs=1e-3)


def test_the_last_of_many_people_are_found_too() -> None:
    rows = people(600)
    rows[590] = 2 * rows[550]
    (pair,) = closest_pairs(rows, 1)
    assert (pair.first, pair.second) == (550, 590)


def test_pairs_keep_their_numbers_when_somebody_was_not_found() -> None:
    (pair,) = closest_pairs([[1.0, 0, 0], NOBODY, [1.0, 0, 1.0]], 5)
    assert (pair.first, pair.second) == (0, 2)
    assert pair.angle_deg == pytest.approx(45.0)


def test_equal_angles_come_in_the_order_of_the_rows() -> None:
    pairs = closest_pairs(np.eye(4), 3)
    assert pairs == [Pair(0, 1, 90.0), Pair(0, 2, 90.0), Pair(0, 3, 90.0)]


def test_a_summary_is_numpys_percentiles() -> None:
    angles = np.random.default_rng(0).uniform(0, 180, 1001)
    found = summarise(angles)
    ordered = np.sort(angles)  # of 1001, every per mille falls on one
    assert found == {
        "pairs": 1001,
        "min": ordered[0],
        "p0_1": pytest.approx(ordered[1]),
        "p1": pytest.approx(ordered[10]),
        "p5": pytest.approx(ordered[50]),
        "median": ordered[500],
        "p95": pytest.approx(ordered[950]),
        "p99": pytest.approx(ordered[990]),
        "max": ordered[1000],
    }


def test_a_summary_of_nothing_is_a_number_alone() -> None:
    assert summarise([]) == {"pairs": 0}


def test_people_far_apart_stay_as_they_are() -> None:
    crowd = Crowd({(0, 0): 0.0, (1, 0): 60.0, (2, 0): 120.0})
    assert distinct(crowd, 3) == Distinct((0, 0, 0), (), ())
    assert crowd.asked == [(0, 0), (1, 0), (2, 0)]


def test_the_later_of_two_look_alikes_is_redrawn() -> None:
    crowd = Crowd({(0, 0): 0.0, (1, 0): 60.0, (2, 0): 70.0, (2, 1): 120.0})
    outcome = distinct(crowd, 3)
    assert outcome.draws == (0, 0, 1)
    assert outcome.unresolved == ()
    ((index, draw, near, angle),) = outcome.rejected
    assert (index, draw, near) == (2, 0, 1)
    assert angle == pytest.approx(10.0)


def test_a_redrawn_person_is_compared_with_everybody_anew() -> None:
    crowd = Crowd({(0, 0): 0.0, (1, 0): 60.0, (2, 0): 70.0, (2, 1): 5.0, (2, 2): 120.0})
    outcome = distinct(crowd, 3)
    assert outcome.draws == (0, 0, 2)
    assert [entry[:3] for entry in outcome.rejected] == [(2, 0, 1), (2, 1, 0)]


def test_somebody_settled_later_is_no_reason_to_redraw_who_came_before() -> None:
    # Person 1 is redrawn onto the place of person 2, who has to give way.
    crowd = Crowd(
        {(0, 0): 0.0, (1, 0): 5.0, (1, 1): 90.0, (2, 0): 92.0, (2, 1): 150.0, (3, 0): 152.0}
        | {(3, 1): 45.0}
    )
    assert distinct(crowd, 4).draws == (0, 1, 1, 1)


def test_an_angle_that_is_just_reached_is_enough() -> None:
    crowd = Crowd({(0, 0): 0.0, (1, 0): 90.0})
    assert distinct(crowd, 2, angle_deg=90.0 - 1e-9).draws == (0, 0)
    assert distinct(crowd, 2, angle_deg=90.1, most=0).unresolved == (1,)


def test_who_stays_too_near_keeps_the_farthest_draw_and_is_named() -> None:
    crowd = Crowd({(0, 0): 0.0, (1, 0): 3.0, (1, 1): 9.0, (1, 2): 6.0, (2, 0): 90.0})
    outcome = distinct(crowd, 3, most=2)
    assert outcome.draws == (0, 1, 0)
    assert outcome.unresolved == (1,)
    assert [entry[:2] for entry in outcome.rejected] == [(1, 0), (1, 2)]


def test_no_smallest_angle_redraws_nobody() -> None:
    assert distinct(Crowd({(0, 0): 0.0, (1, 0): 0.0}), 2, angle_deg=0.0) == Distinct((0, 0), (), ())


def test_no_redraw_allowed_draws_everybody_once() -> None:
    crowd = Crowd({(0, 0): 0.0, (1, 0): 1.0})
    assert distinct(crowd, 2, most=0) == Distinct((0, 0), (1,), ())
    assert crowd.asked == [(0, 0), (1, 0)]


def test_who_was_not_found_is_near_to_nobody() -> None:
    crowd = Crowd({(0, 0): 0.0, (1, 0): np.nan, (2, 0): 1.0, (2, 1): 90.0})
    outcome = distinct(crowd, 3)
    assert outcome.draws == (0, 0, 1)
    assert outcome.rejected[0][2] == 0


@pytest.mark.parametrize(("angle_deg", "most"), [(15.0, 8), (25.0, 3), (40.0, 2)])
def test_the_outcome_is_that_of_settling_one_after_the_other(angle_deg: float, most: int) -> None:
    outcome = distinct(Crowd(), 30, angle_deg, most)
    assert outcome.draws == one_by_one(Crowd(), 30, angle_deg, most)
    assert sum(outcome.draws) > 5


def test_a_person_does_not_depend_on_how_many_follow() -> None:
    whole = distinct(Crowd(), 30)
    assert len(set(whole.draws)) > 2
    for count in (1, 2, 10, 29):
        part = distinct(Crowd(), count)
        assert part.draws == whole.draws[:count]
        assert part.unresolved == tuple(index for index in whole.unresolved if index < count)
        assert part.rejected == tuple(entry for entry in whole.rejected if entry[0] < count)


def test_the_same_people_are_left_each_time() -> None:
    assert distinct(Crowd(), 25) == distinct(Crowd(), 25)


def test_those_left_are_far_apart_but_for_the_unresolved() -> None:
    outcome = distinct(Crowd(), 25, most=3)
    assert outcome.unresolved
    left = [index for index in range(25) if index not in outcome.unresolved]
    rows = Crowd()([(index, outcome.draws[index]) for index in left])
    assert pairwise_angles_deg(rows).min() >= 20.0 - 1e-3


def test_nobody_is_embedded_twice() -> None:
    crowd = Crowd()
    distinct(crowd, 30)
    assert len(crowd.asked) == len(set(crowd.asked))


def test_numbers_need_not_begin_at_zero() -> None:
    crowd = Crowd({(70, 0): 0.0, (71, 0): 4.0, (71, 1): 50.0})
    outcome = draw_distinct([70, 71], crowd, smallest_angle_deg=20, most_redraws=3)
    assert outcome.draws == (0, 1)
    assert outcome.rejected[0][:3] == (71, 0, 70)


def test_nobody_at_all_is_no_error() -> None:
    assert distinct(Crowd(), 0) == Distinct((), (), ())


def test_a_negative_number_of_redraws_is_refused() -> None:
    with pytest.raises(ValueError, match="most_redraws must be >= 0, got -1"):
        distinct(Crowd(), 2, most=-1)


@pytest.mark.parametrize("kind", ["gradient", "bfloat16", "half", "integers", "list"])
def test_angles_are_those_of_any_kind_of_numbers(kind: str) -> None:
    rows = torch.tensor([[1.0, 0.0], [0.0, 2.0], [-3.0, 0.0]])
    given: Any = {
        "gradient": rows.clone().requires_grad_(),
        "bfloat16": rows.bfloat16(),
        "half": rows.half(),
        "integers": rows.int(),
        "list": list(rows.clone().requires_grad_()),
    }[kind]
    assert pairwise_angles_deg(given).tolist() == [90.0, 180.0, 90.0]
    assert closest_pairs(given, 1)[0].angle_deg == 90.0


@pytest.mark.parametrize(
    ("rows", "says"),
    [
        (np.ma.masked_array(np.eye(2), np.eye(2) > 0), "masked"),
        (1j * np.eye(2), "complex"),
        (np.ones(2), r"shape \(2,\), wanted \(N, D\)"),
        ([[1.0, 0.0], [np.inf, 1.0]], "embedding 1 is infinite or all zeros"),
        ([[0.0, 0.0], [1.0, 1.0]], "embedding 0 is infinite or all zeros"),
    ],
    ids=["masked", "complex", "row", "infinite", "zeros"],
)
def test_what_has_no_angle_is_refused(rows: Any, says: str) -> None:
    with pytest.raises(ScoreError, match=says):
        pairwise_angles_deg(rows)
