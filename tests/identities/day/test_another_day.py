import numpy as np
import pytest
from fakes.scenes import DAYS

from lrsr.errors import InputError
from lrsr.identities.day.another_day import _CHANCES, _SPANS, SAME_DAY, AnotherDay


def test_the_same_person_and_day_draw_the_same_and_another_day_something_else() -> None:
    day = AnotherDay("x", day=3, years=(1, 9))
    assert day.amount(5, "years") == AnotherDay("y", day=3, years=(1, 9)).amount(5, "years")
    assert day.amount(5, "years") != day.later(1).amount(5, "years")
    assert day.amount(5, "years") != day.amount(6, "years")


def test_an_amount_is_uniform_within_its_span() -> None:
    day = AnotherDay("x", years=(2, 6))
    drawn = np.array([day.amount(seed, "years") for seed in range(1500)])
    assert drawn.min() >= 2
    assert drawn.max() <= 6
    assert drawn.mean() == pytest.approx(4, abs=4 * (16 / 12 / 1500) ** 0.5)


@pytest.mark.parametrize("kind", _CHANCES)
def test_a_chance_is_as_frequent_as_it_says(kind: str) -> None:
    day = AnotherDay("x", **{kind: 0.3})
    count = sum(day.wears(seed, kind) for seed in range(1000))
    assert count == pytest.approx(300, abs=4 * (1000 * 0.3 * 0.7) ** 0.5)


def test_one_kind_does_not_change_what_another_draws() -> None:
    alone, both = AnotherDay("x", years=(1, 9)), AnotherDay("y", years=(1, 9), cap=1.0)
    assert alone.amount(5, "years") == both.amount(5, "years")


def test_nothing_changes_on_the_same_day_and_nothing_is_recorded_of_it() -> None:
    assert SAME_DAY.is_same
    assert not SAME_DAY.record()
    assert SAME_DAY.later(5) is SAME_DAY


@pytest.mark.parametrize("name", [name for name in DAYS if name != "none"])
def test_every_file_changes_something_and_names_what(name: str) -> None:
    day = DAYS[name]
    assert not day.is_same
    if name != "everything":
        assert [kind for kind in (*_CHANCES, *_SPANS) if day.record()[kind] not in (0, (0, 0))] == [
            name
        ]


def test_numbers_of_any_kind_make_equal_days() -> None:
    numpys = AnotherDay("x", day=np.int64(1), cap=np.float32(1), years=[1, np.float64(2)])  # type: ignore[arg-type]
    assert numpys == AnotherDay("x", cap=1, years=(1.0, 2.0))
    assert hash(numpys) == hash(AnotherDay("x", cap=1, years=(1, 2)))


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"cap": 1.5}, r"another_day\.cap=1\.5: wanted 0 to 1"),
        ({"hair": "yes"}, r"another_day\.hair=yes: wanted a number"),
        ({"day": 0}, r"another_day\.day=0: wanted 1 to"),
        ({"day": 1.5}, r"another_day\.day=1\.5: wanted a whole number"),
        ({"years": 5}, r"another_day\.years=5: wanted \[least,most\], 0 <= least"),
        ({"years": [5]}, r"another_day\.years=\[5\]: wanted \[least,most\]"),
        ({"years": [9, 4]}, r"another_day\.years=\[9,4\]: wanted \[least,most\]"),
        ({"years": [0, 50]}, r"another_day\.years=\[0,50\]: .* <= 20"),
        ({"tan": ["a", "b"]}, r"another_day\.tan=a: wanted a number"),
        ({"weight": "ab"}, r"another_day\.weight=\[a,b\]: wanted"),
    ],
)
def test_what_is_no_number_or_out_of_range_is_refused(
    wrong: dict[str, object], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        AnotherDay("x", **wrong)  # type: ignore[arg-type]
