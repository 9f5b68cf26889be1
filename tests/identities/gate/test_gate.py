import json

from lrsr.identities.gate.gate import Accepted, draw_plausible, record, tally
from lrsr.identities.gate.plausibility import Plausibility, Verdict


def judge(number: int) -> Plausibility:
    """Pass numbers from 0 to 10; say "odd" of all odd ones, too."""
    size = Verdict("size", number, 0.0, 10.0)
    odd = Verdict("odd", number % 2, 0.0, 0.0)
    return Plausibility((size, odd))


def drawn_from(*numbers: int) -> Accepted[int]:
    return draw_plausible(lambda attempt: numbers[attempt], judge, most=len(numbers))


def test_a_first_draw_that_passes_is_kept() -> None:
    assert drawn_from(4, 2) == Accepted(4, 0, (), ())


def test_nothing_is_drawn_that_is_not_needed() -> None:
    asked: list[int] = []

    def draw(attempt: int) -> int:
        asked.append(attempt)
        return (11, 3, 8, 2)[attempt]

    draw_plausible(draw, judge)
    assert asked == [0, 1, 2]


def test_the_first_that_passes_is_kept_with_the_reasons_of_those_before() -> None:
    assert drawn_from(11, 20, 3, 8, 2) == Accepted(8, 3, (("size", "odd"), ("size",), ("odd",)), ())


def test_if_none_passes_the_one_that_missed_by_least_is_kept_and_says_so() -> None:
    assert drawn_from(40, 12, 30) == Accepted(12, 1, (("size",), ("size",)), ("size",))


def test_of_two_that_missed_alike_the_first_is_kept() -> None:
    assert drawn_from(12, -2).attempt == 0


def test_the_outcome_does_not_depend_on_how_many_more_could_be_drawn() -> None:
    numbers = (13, 7, 6, 2, 4)
    few, many = (
        draw_plausible(lambda attempt: numbers[attempt], judge, most=most) for most in (3, 5)
    )
    assert few == many


def test_the_record_of_a_person_adds_up_all_gates_and_is_plain() -> None:
    face, hair = drawn_from(11, 20, 8), drawn_from(40, 12)
    written = record([face, hair])
    assert json.loads(json.dumps(written)) == written
    assert written == {
        "redraws": 3,
        "failures": [["size", "odd"], ["size"], ["size"]],
        "unresolved": ["size"],
    }


def test_the_record_of_somebody_who_passes_at_once_is_empty() -> None:
    assert record([drawn_from(2)]) == {"redraws": 0, "failures": [], "unresolved": []}


def test_a_tally_counts_people_and_draws_and_each_reason_once_per_person() -> None:
    people = [
        record([drawn_from(2)]),
        record([drawn_from(20, 30, 4)]),
        record([drawn_from(11, 8), drawn_from(40, 12)]),
    ]
    written = tally(people)
    assert json.loads(json.dumps(written)) == written
    assert written == {
        "people": 3,
        "redrawn": 2,
        "redraws": 4,
        "reasons": {"size": 2, "odd": 1},
        "unresolved": 1,
    }
    assert list(written["reasons"]) == ["size", "odd"]


def test_a_tally_of_nobody_is_empty() -> None:
    written = tally([])
    assert (written["people"], written["redrawn"], written["reasons"]) == (0, 0, {})
