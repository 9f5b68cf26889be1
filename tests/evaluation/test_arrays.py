"""Tests of lrsr/evaluation/arrays.py."""

import json
import subprocess
import sys
from dataclasses import asdict
from decimal import Decimal
from fractions import Fraction
from math import nan
from typing import Any

import numpy as np
import pytest
import torch
from fakes.measures import d_prime, fnmr_at_fmr, trace_roc

from lrsr.errors import ImageContractError, ScoreError
from lrsr.evaluation.arrays import check_scores, plain_array, plain_number
from lrsr.evaluation.calibrators import elub, fit_kde, fit_logistic, fit_pav
from lrsr.evaluation.delong import compare_aucs, estimate_auc
from lrsr.evaluation.likelihood import cllr, cllr_min, cross_entropy
from lrsr.evaluation.multiplicity import holm_adjusted
from lrsr.evaluation.quality import psnr_y
from lrsr.evaluation.roc import wilson_interval
from lrsr.evaluation.scores import Scores

GENUINE, IMPOSTOR = np.array([2.0, 3, 1, 5]), np.array([0.0, 1, 2, 0, 3])


class Table:
    """What a column of a table looks like to NumPy."""

    def __init__(self, values: np.ndarray) -> None:
        self.values = values

    def __array__(self, dtype: Any = None, copy: Any = None) -> np.ndarray:
        return self.values


def learns(values: np.ndarray) -> torch.Tensor:
    return torch.from_numpy(values).requires_grad_()


ORIGINS = {
    **{
        np.dtype(kind).name: lambda values, kind=kind: values.astype(kind)
        for kind in ("?", "i1", "u1", "i2", "u4", "i8", "u8", "f2", "f4", "f8")
    },
    "big-endian": lambda values: values.astype(">f8"),
    "big-endian-integers": lambda values: values.astype(">i2"),
    "every-other": lambda values: np.repeat(values, 2)[::2],
    "backwards": lambda values: values[::-1].copy()[::-1],
    "column": lambda values: values[:, None],
    "matrix": lambda values: np.asmatrix(values),
    "read-only": lambda values: np.frombuffer(values.tobytes()),
    "list": lambda values: values.tolist(),
    "tuple-of-integers": lambda values: tuple(map(int, values)),
    "numpy-scalars": list,
    "nested-lists": lambda values: [[value] for value in values.tolist()],
    "nothing-masked": np.ma.masked_array,
    "table": Table,
    "tensor": torch.from_numpy,
    "gradient": learns,
    "bfloat16": lambda values: torch.from_numpy(values).bfloat16(),
    "half-that-learns": lambda values: learns(values).half(),
    "list-of-tensors-that-learn": lambda values: [learns(values)[k] for k in range(len(values))],
    "list-of-bfloat16": lambda values: list(torch.from_numpy(values).bfloat16()),
    "sparse": lambda values: torch.from_numpy(values).to_sparse(),
    "negated-view": lambda values: (
        torch.complex(torch.zeros(len(values)).double(), torch.from_numpy(-values)).conj().imag
    ),
}
EXACT = set(ORIGINS) - {"bool"}


@pytest.mark.filterwarnings("ignore:the matrix subclass:PendingDeprecationWarning")
@pytest.mark.parametrize("origin", sorted(EXACT))
def test_numbers_of_any_origin_give_the_same_estimate(origin: str) -> None:
    genuine, impostor = ORIGINS[origin](GENUINE), ORIGINS[origin](IMPOSTOR)
    plain = estimate_auc(GENUINE, IMPOSTOR)
    assert estimate_auc(genuine, impostor) == plain
    assert estimate_auc(genuine, IMPOSTOR) == plain
    assert compare_aucs(genuine, impostor, GENUINE, IMPOSTOR).p == 1
    assert trace_roc(genuine, impostor).auc == plain.auc
    assert d_prime(genuine, impostor) == d_prime(GENUINE, IMPOSTOR)
    assert fnmr_at_fmr(genuine, impostor, 0.2).fnmr == fnmr_at_fmr(GENUINE, IMPOSTOR, 0.2).fnmr


def test_booleans_are_zeros_and_ones() -> None:
    assert check_scores([True, False], "genuine").tolist() == [1, 0]


REFUSED = [
    pytest.param(np.ma.masked_array([1.0, 2.0], [True, False]), "masked in part", id="masked"),
    pytest.param(np.ma.masked_array([1, 2], [True, False]), "masked in part", id="masked-integers"),
    pytest.param([1.0, np.ma.masked], "masked in part", id="masked-in-a-list"),
    pytest.param(
        [np.ma.masked_array([1.0], [True]), [2.0]], "masked in part", id="masked-deep-in-a-list"
    ),
    pytest.param(np.array([1.0, 2.0], object), "dtype object", id="objects"),
    pytest.param([1.0, None], "dtype object", id="none"),
    pytest.param([2**70, 1], "dtype object", id="beyond-64-bits"),
    pytest.param(Table(np.array([1.0, None])), "dtype object", id="table-with-gaps"),
    pytest.param({"a": 1.0}, "dtype object", id="mapping"),
    pytest.param(iter([1.0, 2.0]), "dtype object", id="iterator"),
    pytest.param([[1.0], [1.0, 2.0]], "make no array", id="ragged"),
    pytest.param(np.array([1j, 2]), "dtype complex128", id="complex"),
    pytest.param(torch.tensor([1j, 2]), "dtype complex64", id="complex-tensor"),
    pytest.param(torch.zeros(2, device="meta"), "make no array", id="tensor-without-values"),
    pytest.param(np.longdouble([1, 2]), "dtype", id="long-double"),
    pytest.param(["1.0", "2.0"], "dtype <U3", id="text"),
    pytest.param(np.array(["2020-01-01", "2021-01-01"], "M8[D]"), "dtype datetime64", id="dates"),
    pytest.param(np.zeros(2, [("x", float)]), "dtype", id="records"),
]


@pytest.mark.parametrize(("values", "message"), REFUSED)
def test_what_would_have_to_be_guessed_is_refused(values: Any, message: str) -> None:
    with pytest.raises(ScoreError, match=f"genuine scores .*{message}"):
        estimate_auc(values, IMPOSTOR)


@pytest.mark.parametrize("values", [0.5, np.float32(0.5), np.array(0.5), torch.tensor(0.5), []])
def test_one_number_or_none_has_no_variance(values: Any) -> None:
    with pytest.raises(ScoreError, match=r"[01] genuine scores, wanted at least 2"):
        estimate_auc(values, IMPOSTOR)


def test_a_matrix_with_a_masked_score_is_refused() -> None:
    with pytest.raises(ScoreError, match="scores of the matrix are masked"):
        Scores(np.ma.masked_less(np.eye(2), 0.5), ["a", "b"], ["a", "b"])


def test_a_matrix_may_be_a_tensor() -> None:
    assert Scores(torch.eye(2), ["a", "b"], ["a", "b"]).genuine().tolist() == [1, 1]  # type: ignore[arg-type] # duck-typed


NUMBERS = {
    "numpy": np.float32(0.25),
    "half": np.float16(0.25),
    "no-axes": np.array(0.25),
    "decimal": Decimal("0.25"),
    "fraction": Fraction(1, 4),
    "tensor": torch.tensor(0.25),
    "gradient": torch.tensor(0.25, requires_grad=True),
    "bfloat16": torch.tensor(0.25).bfloat16(),
}


@pytest.mark.parametrize("origin", NUMBERS)
def test_one_number_may_be_of_any_width_and_origin(origin: str) -> None:
    value: Any = NUMBERS[origin]
    assert plain_number(value, "level") == 0.25
    estimate = estimate_auc(GENUINE, IMPOSTOR, value)
    assert estimate == estimate_auc(GENUINE, IMPOSTOR, 0.25)
    json.dumps(asdict(estimate))
    assert fnmr_at_fmr(GENUINE, IMPOSTOR, value) == fnmr_at_fmr(GENUINE, IMPOSTOR, 0.25)
    assert holm_adjusted([value, value]) == [0.5, 0.5]


@pytest.mark.parametrize(
    "value", [None, "0.5", True, nan, [0.5], 1j, np.ma.masked, 10**400], ids=repr
)
def test_what_is_no_number_is_refused_in_one_line(value: Any) -> None:
    for measure in (
        lambda: estimate_auc(GENUINE, IMPOSTOR, value),
        lambda: fnmr_at_fmr(GENUINE, IMPOSTOR, value),
        lambda: wilson_interval(1, value),
        lambda: holm_adjusted([value]),
    ):
        with pytest.raises(ScoreError, match="wanted a number"):
            measure()
    with pytest.raises(ImageContractError, match=r"shave is .*: wanted a number"):
        psnr_y(np.zeros((3, 4, 4)), np.ones((3, 4, 4)), value)


@pytest.mark.parametrize(
    "measure",
    [
        lambda x: cllr(x, [0.0]),
        lambda x: cllr_min(x, [0.0]),
        lambda x: cross_entropy([1.0], [0.0], x),
        lambda x: elub(x, [0.0]),
        lambda x: fit_pav([1.0, 2.0], [0.0, 1.0])(x),
        lambda x: fit_logistic([1.0, 2.0], [0.0, 1.0])(x),
        lambda x: fit_kde([1.0, 2.0], [0.0, 1.0])(x),
    ],
    ids=["cllr", "cllr_min", "cross_entropy", "elub", "pav", "logistic", "kde"],
)
def test_ratios_of_any_origin_are_taken_and_what_makes_none_is_refused(measure: Any) -> None:
    values = torch.tensor([0.5, 2.0])
    for same in (values.bfloat16(), values.clone().requires_grad_(), values.to_sparse()):
        np.testing.assert_array_equal(measure(same), measure([0.5, 2.0]))
    for wrong in ((x for x in (1.0,)), {1.0}, b"abc", {"a": 1}, np.array([1j])):
        with pytest.raises(ScoreError, match=r"make no array|have dtype"):
            measure(wrong)


def test_odds_that_are_none_are_refused() -> None:
    with pytest.raises(ScoreError, match="prior odds: a NaN"):
        cross_entropy([1.0], [0.0], [0.0, nan])


def test_the_error_is_the_callers() -> None:
    with pytest.raises(ImageContractError, match="images have dtype int64: give floats"):
        plain_array([1], "images", kinds="f", wanted="floats", error=ImageContractError)


def test_evaluation_imports_neither_torch_nor_the_rest_of_lrsr() -> None:
    code = "import sys, lrsr.evaluation; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    modules = set(done.stdout.split())
    assert not modules & {"torch", "sklearn", "scipy.stats", "matplotlib"}
    ours = {name for name in modules if name.split(".")[0] == "lrsr"}
    assert {name for name in ours if not name.startswith("lrsr.evaluation")} == {
        "lrsr",
        "lrsr.errors",
    }
