"""Tests of lrsr/evaluation/lookup.py."""

import numpy as np
import pytest

from lrsr.evaluation.lookup import build_table, compare, sorting_is_slow


def spread(kind: str, size: int) -> np.ndarray:
    rng = np.random.default_rng(0)
    draw = rng.standard_cauchy(size) if kind == "cauchy" else rng.normal(size=size)
    return (draw * 1e6).astype(np.int64) if kind == "integers" else draw


@pytest.mark.parametrize("kind", ["normal", "cauchy", "integers"])
def test_bins_rise_with_the_score(kind: str) -> None:
    table = build_table(np.unique(spread(kind, 300)))
    assert table is not None
    bins = table.bins(np.sort(spread(kind, 50_000)))
    assert (np.diff(bins) >= 0).all()
    assert 0 <= bins[0] <= bins[-1] < table.close.size


@pytest.mark.parametrize("kind", ["normal", "cauchy", "integers"])
def test_a_bin_without_a_value_gives_the_class(kind: str) -> None:
    values, scores = np.unique(spread(kind, 300)), spread(kind, 50_000)
    table = build_table(values)
    assert table is not None
    bins = table.bins(scores)
    away = ~table.close[bins]
    assert away.any()
    assert (2 * table.below[bins][away] == compare(scores[away], values)).all()


@pytest.mark.parametrize("kind", ["normal", "cauchy", "integers"])
def test_a_bin_with_values_gives_the_class_after_comparison(kind: str) -> None:
    values = np.unique(spread(kind, 300))
    scores = np.concatenate((spread(kind, 50_000), values))
    table = build_table(values)
    assert table is not None
    bins = table.bins(scores)
    close = table.close[bins]
    classes = table.classify(scores[close], bins[close], values)
    assert (classes == compare(scores[close], values)).all()


def test_comparison_counts_the_values_below_and_at() -> None:
    values, scores = np.array([1.0, 2.0, 4.0]), np.array([0.0, 1.0, 3.0, 4.0, 5.0])
    below = (values < scores[:, None]).sum(axis=1)
    at_or_below = (values <= scores[:, None]).sum(axis=1)
    assert compare(scores, values).tolist() == (below + at_or_below).tolist()


@pytest.mark.parametrize(
    "values",
    [
        pytest.param(np.arange(3.0), id="few"),
        pytest.param(np.arange(40_000.0), id="too-many-for-the-bins"),
        pytest.param(np.linspace(-1, 1, 9) * 1.7e308, id="too-wide-for-the-dtype"),
        pytest.param(np.arange(9) * 5e-324, id="denormal"),
    ],
)
def test_there_is_no_table_where_none_would_be_fair(values: np.ndarray) -> None:
    assert build_table(values) is None


@pytest.mark.parametrize("dtype", ["<f4", "<f8", "<i8", "|b1"])
def test_the_way_is_chosen_for_each_dtype(dtype: str) -> None:
    assert isinstance(sorting_is_slow(dtype), bool)
