"""Whose numbers are these? Lists, tensors and arrays of any origin become plain NumPy arrays."""

from contextlib import suppress
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lrsr.errors import InputError, ScoreError

Array = NDArray[Any]


def plain_array(
    values: Any,
    name: str,
    *,
    kinds: str = "biuf",
    wanted: str = "float32, float64 or integers",
    error: type[InputError] = ScoreError,
    masked: float | None = None,
) -> Array:
    """Return numbers as a native NumPy array, exactly; what would have to be guessed is refused.

    Tensors are known by what they can do (torch is not imported): one that needs a gradient, lies
    on another device, is sparse or bfloat16 is taken by its values. Booleans and float16 are
    widened to float32; any byte order, stride and shape is taken.

    Args:
        values: An array, a tensor, a list, or whatever NumPy takes.
        name: What the message calls them, plural.
        kinds: NumPy's letters of the kinds of numbers that are taken.
        wanted: The remedy that the message gives where the dtype is another.
        error: What is raised.
        masked: What stands for a masked value; None: it is refused.

    Raises:
        InputError: A value is masked, the values make no array, or their dtype is not taken:
            complex, text, objects, wider than 64 bits. Of the class ``error``.

    Example:
        >>> plain_array(np.array([1, 2], ">i2"), "scores")
        array([1, 2], dtype=int16)
    """
    if masked is not None and _is_masked(values):
        values = np.ma.filled(np.ma.asarray(values).astype(np.float64), masked)
    if _is_masked(values):
        raise error(f"{name} are masked in part: leave out what is masked, or give NaN for it")
    try:
        array = np.asarray(_detached(values))
    except (TypeError, ValueError, RuntimeError, OverflowError) as cause:
        reason = str(cause).partition("\n")[0]
        raise error(f"{name} make no array ({reason}): give {wanted}") from cause
    if array.dtype.kind not in kinds or array.dtype.itemsize > 8:
        raise error(f"{name} have dtype {array.dtype}: give {wanted}")
    if array.dtype.kind == "b" or (array.dtype.itemsize == 2 and array.dtype.kind == "f"):
        return array.astype(np.float32)
    return array.astype(array.dtype.newbyteorder("="), copy=False)


def _is_masked(values: Any) -> bool:
    if isinstance(values, (list, tuple)):
        parts = (list, tuple, np.ma.MaskedArray)
        return any(isinstance(value, parts) and _is_masked(value) for value in values)
    return bool(np.ma.is_masked(values))


def _detached(values: Any) -> Any:
    """Return tensors' values as arrays; what NumPy has no dtype for (bfloat16) as float32."""
    if isinstance(values, (list, tuple)) and any(hasattr(value, "detach") for value in values):
        return [_detached(value) for value in values]
    if not hasattr(values, "detach"):
        return values
    strided = values.detach().to_dense()
    try:
        return strided.numpy(force=True)
    except TypeError:
        return strided.float().numpy(force=True)


def plain_number(value: Any, name: str, *, error: type[InputError] = ScoreError) -> float:
    """Return one finite number of any width and origin; ``name`` is what the message calls it.

    Raises:
        InputError: It is none. Of the class ``error``.
    """
    exact = isinstance(value, (Decimal, Fraction))
    with suppress(ScoreError, OverflowError):
        array = plain_array(float(value) if exact else value, name, kinds="iuf")
        if array.ndim == 0 and np.isfinite(array):
            return float(array)
    raise error(f"{name} is {value!r}: wanted a number")


def float_array(values: Any, name: str) -> NDArray[np.float64]:
    """Return numbers of any shape and origin as float64; see :func:`plain_array`.

    Raises:
        ScoreError: They are none.
    """
    return np.asarray(plain_array(values, name), dtype=np.float64)


def check_scores(scores: Any, name: str, *, at_least: int = 1) -> Array:
    """Return scores as a flat array of float32, float64 or integers.

    Finiteness is looked at later, block by block; see :func:`check_finite`.

    Args:
        scores: Any shape and origin; see :func:`plain_array`.
        name: What the message calls them, e.g. "genuine".
        at_least: How many there must be.

    Raises:
        ScoreError: Too few scores, or no plain real numbers.
    """
    array = plain_array(scores, f"{name} scores")
    if array.size < at_least:
        raise ScoreError(f"{array.size} {name} scores, wanted at least {at_least}: give more pairs")
    return array.reshape(-1)


def check_finite(scores: Array, name: str, start: int = 0) -> None:
    """Refuse NaN and infinities.

    Args:
        scores: ``(n,)``.
        name: What the message calls them.
        start: Index of the first of them in the user's array.

    Raises:
        ScoreError: One is not finite; the message gives the index of the first.
    """
    if scores.dtype.kind != "f":
        return
    finite = np.isfinite(scores)
    if not finite.all():
        first = int(np.argmin(finite))
        raise ScoreError(
            f"{name} score {start + first} is {scores[first]}: scores must be finite; "
            "a failure to acquire is counted apart (Scores.fta), not compared"
        )


def to_common(a: Array, b: Array) -> tuple[Array, Array]:
    """Return two sets of scores in one dtype that holds both exactly.

    Raises:
        ScoreError: Integers beyond 2**53 against a dtype that is not theirs.
    """
    if a.dtype == b.dtype:
        return a, b
    common = np.result_type(a, b)
    if common.kind == "f":
        common = np.dtype(np.float64)
        if max(_magnitude(part) for part in (a, b)) > 1 << 53:
            raise ScoreError(
                "integer scores beyond 2**53 cannot be compared with another dtype exactly: "
                "give all scores in one dtype"
            )
    return a.astype(common, copy=False), b.astype(common, copy=False)


def _magnitude(scores: Array) -> int:
    """Return the largest absolute value of integers; 0 for fractions, which need no care."""
    if scores.dtype.kind == "f" or scores.size == 0:
        return 0
    return max(abs(int(scores.min())), abs(int(scores.max())))
