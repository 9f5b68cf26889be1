import json

import pytest

from lrsr.identities.gate.gate import draw_plausible, record, tally


def judge(number: int) -> list[str]:
    """Pass even numbers from 0 to 10."""
    return ["size"] * (not 0 <= number <= 10) + ["odd"] * (number % 2)


def drawn_from(*numbers: int) -> tuple[int, list[list[str]]]:
    return draw_plausible(lambda attempt: numbers[attempt], judge)


def test_a_first_draw_that_passes_is_kept() -> None:
    assert drawn_from(4, 2) == (4, [])


def test_nothing_is_drawn_that_is_not_needed() -> None:
    asked: list[int] = []

    def draw(attempt: int) -> int:
        asked.append(attempt)
        return (11, 3, 8, 2)[attempt]

    draw_plausible(draw, judge)
    assert asked == [0, 1, 2]


def test_the_first_that_passes_is_kept_with_the_reasons_of_those_before() -> None:
    assert drawn_from(11, 20, 3, 8, 2) == (8, [["size", "odd"], ["size"], ["odd"]])


def test_a_gate_that_lets_nothing_pass_says_so() -> None:
    with pytest.raises(RuntimeError, match="none of 1000 draws passes"):
        draw_plausible(lambda attempt: 3, judge)


def test_the_record_of_a_person_is_plain() -> None:
    written = record(drawn_from(11, 20, 8)[1])
    assert json.loads(json.dumps(written)) == written
    assert written == {"redraws": 2, "failures": [["size", "odd"], ["size"]]}


def test_the_record_of_somebody_who_passes_at_once_is_empty() -> None:
    assert record(drawn_from(2)[1]) == {"redraws": 0, "failures": []}


def test_a_tally_counts_people_and_draws_and_each_reason_once_per_person() -> None:
    people = [record(drawn_from(*numbers)[1]) for numbers in ((2,), (20, 30, 4), (11, 40, 8))]
    written = tally(people)
    assert json.loads(json.dumps(written)) == written
    assert written == {"people": 3, "redrawn": 2, "redraws": 4, "reasons": {"size": 2, "odd": 1}}
    assert list(written["reasons"]) == ["size", "odd"]


def test_a_tally_of_nobody_is_empty() -> None:
    written = tally([])
    assert (written["people"], written["redrawn"], written["reasons"]) == (0, 0, {})
