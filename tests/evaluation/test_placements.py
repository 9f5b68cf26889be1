"""Tests of lrsr/evaluation/placements.py."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import ArrayLike

from lrsr.errors import ScoreError
from lrsr.evaluation.placements import BLOCK, Placements, class_placements, place

Draw = Callable[[np.random.Generator, int], np.ndarray]

DRAWS: dict[str, Draw] = {
    "normal": lambda rng, n: rng.normal(size=n),
    "one-decimal": lambda rng, n: rng.normal(size=n).round(1),
    "cauchy": lambda rng, n: rng.standard_cauchy(n),
    "bits": lambda rng, n: rng.integers(0, 2, n).astype(float),
    "tiny": lambda rng, n: rng.normal(size=n) * 1e-38,
    "huge": lambda rng, n: rng.normal(size=n).clip(-3, 3) * 1e38,
    "narrow": lambda rng, n: 1 + rng.normal(size=n) * 1e-6,
    "denormal": lambda rng, n: rng.integers(0, 9, n) * 5e-324,
    "widest": lambda rng, n: rng.uniform(-1, 1, n) * 1.7e308,
    "integers": lambda rng, n: rng.normal(size=n) * 1e6 // 1,
    "crowded": lambda rng, n: np.where(rng.random(n) < 0.5, 1e-9, 1) * rng.normal(size=n),
}


def count(genuine: ArrayLike, parts: list[np.ndarray]) -> Placements:
    placements = Placements(genuine)
    for part in parts:
        placements.count(placements.classes(part))
    return placements


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("draw", DRAWS.values(), ids=DRAWS.keys())
@pytest.mark.parametrize("m", [1, 2, 50, 3000])
def test_counts_equal_those_in_the_sorted_scores(draw: Draw, m: int, dtype: type) -> None:
    rng = np.random.default_rng(m)
    with np.errstate(over="ignore", under="ignore"):
        genuine, impostor = draw(rng, m).astype(dtype), draw(rng, 20_000).astype(dtype)
    if not np.isfinite(impostor).all():
        pytest.skip("float32 does not reach so far")
    counts = place(genuine, impostor)
    ordered = np.sort(impostor)
    assert (counts.values == np.unique(genuine)).all()
    assert (counts.lo == np.searchsorted(ordered, counts.values, side="left")).all()
    assert (counts.hi == np.searchsorted(ordered, counts.values, side="right")).all()


def test_one_stray_genuine_score_changes_no_count() -> None:
    rng = np.random.default_rng(3)
    genuine, impostor = rng.normal(1, 1, 200), rng.normal(0, 1, 50_000)
    with_stray = place([*genuine, -1e6], impostor)
    assert with_stray.lo[1:].tolist() == place(genuine, impostor).lo.tolist()


@given(
    genuine=st.lists(st.floats(width=32, allow_nan=False, allow_infinity=False), min_size=1),
    impostor=st.lists(st.floats(width=32, allow_nan=False, allow_infinity=False), min_size=1),
)
@settings(deadline=None, max_examples=50)
def test_counts_equal_plain_counting(genuine: list[float], impostor: list[float]) -> None:
    counts = place(np.float32(genuine), np.float64(impostor))
    for value, lo, hi in zip(counts.values, counts.lo, counts.hi, strict=True):
        assert lo == sum(score < value for score in impostor)
        assert hi == sum(score <= value for score in impostor)


def test_blocks_add_up_to_the_whole() -> None:
    rng = np.random.default_rng(0)
    genuine, impostor = rng.normal(1, 1, 30), rng.normal(0, 1, 3 * BLOCK + 5)
    counts = count(genuine, np.array_split(impostor, 7))
    assert counts.hi.tolist() == place(genuine, impostor).hi.tolist()
    assert counts.n_impostor == impostor.size


def test_blocks_of_different_dtypes_add_up() -> None:
    genuine = np.float32([0.5, 1.5, 2.5, 3.5, 4.5])
    parts = [np.float32([0.5, 1.0]), np.array([1, 2]), np.array([0.5 + 1e-12]), np.float32([9])]
    counts = count(genuine, parts)
    assert counts.lo.tolist() == [0, 4, 5, 5, 5]
    assert counts.hi.tolist() == [1, 4, 5, 5, 5]


def test_values_are_told_in_the_widest_dtype_that_was_compared() -> None:
    # Else the next float32 above a genuine score would jump over a float64 impostor score.
    assert place(np.float32([0.5]), [0.5 + 1e-12]).values.dtype == np.float64


def test_float32_is_compared_with_float64_without_rounding() -> None:
    # float32(0.1) is 0.100000001490116, above the float64 0.1.
    assert place(np.float32([0.1]), [0.1]).lo.tolist() == [1]


def test_negative_zero_equals_zero() -> None:
    counts = place([-0.0, 0.0], [0.0, -0.0, 0.0])
    assert (counts.ties.tolist(), counts.lo.tolist(), counts.hi.tolist()) == ([2], [0], [3])


def test_large_integers_are_compared_exactly() -> None:
    large = 2**62
    counts = place(np.array([large + 1]), np.array([large, large + 1, large + 2]))
    assert (counts.lo.tolist(), counts.hi.tolist()) == ([1], [2])


@pytest.mark.parametrize(
    "dtype", [np.bool_, np.int8, np.uint8, np.int16, np.int64, np.uint64, np.float16]
)
def test_any_real_dtype_is_taken(dtype: type) -> None:
    counts = place(np.array([1], dtype), np.array([0, 1, 1], dtype))
    assert (counts.lo.tolist(), counts.hi.tolist()) == ([1], [3])


def test_signed_and_unsigned_integers_are_compared_by_value() -> None:
    assert place(np.array([-1]), np.array([0, 1], np.uint64)).hi.tolist() == [0]


def test_classes_hold_every_impostor_score_once() -> None:
    counts = place([1, 2, 2, 5], [0, 1, 1.5, 2, 2, 7])
    assert class_placements(counts.ties).tolist() == [8, 7, 6, 4, 2, 1, 0]
    assert counts.sizes.tolist() == [1, 1, 1, 2, 0, 0, 1]


@pytest.mark.parametrize("decimals", [0, 2, 9])
@pytest.mark.parametrize("shape", [(4000,), (40, 100), (8, 10, 50)], ids=str)
def test_placements_are_twice_the_genuine_scores_above(
    shape: tuple[int, ...], decimals: int
) -> None:
    rng = np.random.default_rng(5)
    scores, impostor = rng.normal(1, 1, 60).round(decimals), rng.normal(size=shape).round(decimals)
    genuine = Placements(scores)
    above, tied = scores > impostor[..., None], scores == impostor[..., None]
    placements = genuine.of_impostor(genuine.classes(impostor))
    assert (placements == 2 * above.sum(-1) + tied.sum(-1)).all()


def test_each_genuine_score_beats_what_lies_below_it() -> None:
    placements = place([3.0, 1.0, 3.0], [0.0, 1, 2, 3, 4])
    assert placements.of_genuine.tolist() == [7, 3, 7]
    assert placements.own_classes.tolist() == [3, 1, 3]


@pytest.mark.parametrize(("k", "dtype"), [(100, np.int16), (20_000, np.int32)])
def test_many_classes_have_room(k: int, dtype: type) -> None:
    genuine = Placements(np.arange(k))
    classes = genuine.classes(np.arange(-1, k + 1) + 0.0)
    assert classes.dtype == dtype
    assert classes.tolist() == [0, *range(1, 2 * k, 2), 2 * k]


def test_class_placements_fall_from_twice_the_number_to_zero() -> None:
    assert class_placements(np.array([3])).tolist() == [6, 3, 0]


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf], ids=str)
def test_the_first_genuine_score_that_is_not_finite_is_named(bad: float) -> None:
    with pytest.raises(ScoreError, match=rf"genuine score 1 is {bad}"):
        place([0.5, bad, bad], [0.1])


@pytest.mark.parametrize("index", [0, BLOCK - 1, BLOCK, 2 * BLOCK + 17])
def test_the_first_impostor_score_that_is_not_finite_is_named(index: int) -> None:
    impostor = np.zeros(2 * BLOCK + 20, np.float32)
    impostor[index:] = np.nan
    with pytest.raises(ScoreError, match=rf"impostor score {index} is nan"):
        place([0.5], impostor)


def test_the_index_goes_on_where_an_earlier_part_ended() -> None:
    with pytest.raises(ScoreError, match="impostor score 3 is inf"):
        Placements([0.5]).classes(np.array([1.0, np.inf]), start=2)


@pytest.mark.parametrize(
    ("genuine", "impostor", "message"),
    [
        pytest.param([], [1.0], "0 genuine scores, wanted at least 1", id="no-genuine"),
        pytest.param([1.0], [], "0 impostor scores, wanted at least 1", id="no-impostor"),
        pytest.param([1j], [1.0], "genuine scores have dtype complex128", id="complex"),
        pytest.param([1.0], ["a"], "impostor scores have dtype <U1", id="text"),
        pytest.param(np.longdouble([1]), [1.0], "float128|longdouble", id="long-double"),
        pytest.param([2**53 + 2], [1.5], r"beyond 2\*\*53", id="large-integers"),
    ],
)
def test_scores_that_cannot_be_compared_are_refused(
    genuine: list[float], impostor: list[float], message: str
) -> None:
    with pytest.raises(ScoreError, match=message):
        place(genuine, impostor)


def test_inputs_are_left_as_they_were() -> None:
    genuine, impostor = np.array([3.0, 1.0]), np.array([2.0, 0.0, 5.0])
    place(genuine, impostor)
    assert (genuine.tolist(), impostor.tolist()) == ([3, 1], [2, 0, 5])
