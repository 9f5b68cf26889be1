"""What is a milder draw of an anatomy? The mean of several: as typical on average, less extreme.

Some people are so near the limits of what adults have, by ancestry and sex alone, that most of
their draws fail; more of the same would not help them, but the mean of n draws strays from their
average by 1/sqrt(n) of what one does.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from lrsr.identities.shape.anatomy import Anatomy

PATIENCE = 6
"""Draws that are as wild as the first."""
_DRAWS_OF_A_KIND = 3
"""Attempts between which the number of draws that are averaged rises by one."""


def draws_averaged(attempt: int) -> int:
    """Return of how many draws the anatomy of an attempt is the mean.

    Args:
        attempt: 0, 1, 2, ...

    Example:
        >>> [draws_averaged(attempt) for attempt in (0, 5, 6, 8, 9, 31)]
        [1, 1, 2, 2, 3, 10]
    """
    return 1 if attempt < PATIENCE else 2 + (attempt - PATIENCE) // _DRAWS_OF_A_KIND


def mean_anatomy(drawn: Sequence[Anatomy]) -> Anatomy:
    """Average anatomies, number by number; what one of them lacks is 0 there.

    Args:
        drawn: At least one; a single one is returned as it is.
    """
    if len(drawn) == 1:
        return drawn[0]
    return {
        "muscle": float(np.mean([one["muscle"] for one in drawn])),
        "weight": float(np.mean([one["weight"] for one in drawn])),
        "head_shapes": _mean([one["head_shapes"] for one in drawn]),
        "sliders": _mean([one["sliders"] for one in drawn]),
        "asymmetry": _mean([one["asymmetry"] for one in drawn]),
        "expression": _mean([one["expression"] for one in drawn]),
    }


def _mean(drawn: Sequence[Mapping[str, float]]) -> dict[str, float]:
    names = dict.fromkeys(name for one in drawn for name in one)
    return {name: sum(one.get(name, 0.0) for one in drawn) / len(drawn) for name in names}
