"""How many pairs does a statement need? Before the pictures are taken."""

import math

from lrsr.errors import ScoreError
from lrsr.evaluation.arrays import plain_number
from lrsr.evaluation.delong import check_level
from lrsr.evaluation.roc import wilson_interval


def pairs_for_precision(rate: float, half_width: float, level: float = 0.95) -> int:
    """Return how many independent pairs show a rate with an interval of that half width.

    The least n whose Wilson interval of the expected rate is at most twice as wide.

    Args:
        rate: That is expected, FNMR or FMR, [0, 1].
        half_width: Of the interval, (0, 0.5).
        level: Of the interval, in (0, 1).

    Raises:
        ScoreError: A number is out of its range.

    Example:
        >>> pairs_for_precision(0.1, 0.03)
        388
    """
    expected, half = plain_number(rate, "rate"), plain_number(half_width, "half width")
    if not 0 <= expected <= 1 or not 0 < half < 0.5:
        raise ScoreError(f"rate {rate} and half width {half_width}: wanted 0 to 1, and 0 to 0.5")
    check_level(level)

    def enough(n: int) -> bool:
        low, high = wilson_interval(expected * n, n, level)
        return float(high - low) <= 2 * half

    few, many = 0, 1
    while not enough(many):
        few, many = many, 2 * many
    while many - few > 1:
        middle = (few + many) // 2
        few, many = (few, middle) if enough(middle) else (middle, many)
    return many


def pairs_without_error(rate: float, level: float = 0.95) -> int:
    """Return how many independent pairs without an error show that the rate is below ``rate``.

    Exact; about 3 / rate at 95 %, the "rule of three" (Hanley and Lippman-Hand, JAMA 249, 1983).

    Args:
        rate: To be shown, (0, 1).
        level: Of confidence, in (0, 1).

    Raises:
        ScoreError: A number is out of its range.

    Example:
        >>> pairs_without_error(0.01)
        299
    """
    wanted = plain_number(rate, "rate")
    if not 0 < wanted < 1:
        raise ScoreError(f"rate {rate}: wanted a number between 0 and 1")
    return math.ceil(math.log(1 - check_level(level)) / math.log1p(-wanted))


def rate_without_error(pairs: int, level: float = 0.95) -> float:
    """Return the rate that may hide behind no error among so many independent pairs.

    Raises:
        ScoreError: There is no pair, or the level lies outside (0, 1).

    Example:
        >>> round(rate_without_error(100), 4)
        0.0295
    """
    if pairs < 1:
        raise ScoreError(f"{pairs} pairs: wanted at least 1")
    return float(-math.expm1(math.log(1 - check_level(level)) / pairs))
