"""Which differences remain when several tests were made at once?"""

from collections.abc import Sequence

from lrsr.errors import ScoreError
from lrsr.evaluation.arrays import plain_number


def holm_adjusted(p_values: Sequence[float]) -> list[float]:
    """Return p values adjusted for their number by Holm's step-down rule, in the order given.

    Rejecting where the adjusted value is below alpha keeps the chance of any false rejection below
    alpha, whatever the dependence of the tests (Holm, Scandinavian Journal of Statistics 6, 1979).

    Args:
        p_values: Each in [0, 1]; may be empty.

    Raises:
        ScoreError: A value lies outside [0, 1].

    Example:
        >>> [round(p, 3) for p in holm_adjusted([0.01, 0.04, 0.03])]
        [0.03, 0.06, 0.06]
    """
    p_values = [plain_number(p, f"p value {index}") for index, p in enumerate(p_values)]
    for index, p in enumerate(p_values):
        if not 0 <= p <= 1:
            raise ScoreError(f"p value {index} is {p}: wanted a number from 0 to 1")
    adjusted = [0.0] * len(p_values)
    so_far = 0.0
    for rank, index in enumerate(sorted(range(len(p_values)), key=p_values.__getitem__)):
        so_far = max(so_far, min(1.0, (len(p_values) - rank) * p_values[index]))
        adjusted[index] = so_far
    return adjusted
