"""Does recognition err alike for everybody? The same threshold for all, the rates of each group.

A group's impostors are of the group: two women, two people of sixty. Rates across all groups
together would hide who is mistaken for whom (NIST IR 8280, Grother et al. 2019).
"""

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from lrsr.errors import ScoreError
from lrsr.evaluation.bootstrap import draw_people, percentiles, weighted_means
from lrsr.evaluation.pooled import PooledPairs
from lrsr.evaluation.roc import wilson_interval
from lrsr.evaluation.scores import ScoreSource


@dataclass(frozen=True)
class GroupRates:
    """The error rates within one group of people; every field goes to JSON.

    Attributes:
        people: With a score.
        n_genuine: Genuine pairs.
        n_impostor: Impostor pairs, both people of the group.
        fnmr: False-non-match rate at the threshold of all.
        fnmr_low: Lower end of its interval over people (bootstrap; Wilson's without draws).
        fnmr_high: Upper end.
        fmr: False-match rate at the threshold of all.
        fmr_low: Lower end.
        fmr_high: Upper end.
    """

    people: int
    n_genuine: int
    n_impostor: int
    fnmr: float
    fnmr_low: float
    fnmr_high: float
    fmr: float
    fmr_low: float
    fmr_high: float


def rates_of_group(
    source: ScoreSource,
    people: Collection[str],
    threshold: float,
    *,
    bootstrap: int = 0,
    seed: int = 0,
    level: float = 0.95,
) -> GroupRates:
    """Measure the rates of some people at a threshold that was set on all.

    Args:
        source: All scores.
        people: Of the group.
        threshold: Accept score >= threshold.
        bootstrap: Draws of people for the intervals; 0: Wilson's, which take pairs as independent.
        seed: Of the draws.
        level: Of the intervals.

    Raises:
        ScoreError: The group has no genuine or no impostor score.
    """
    part = source.restricted(people)
    pairs = PooledPairs(part)
    if not (pairs.genuine.size and pairs.impostor.size):
        raise ScoreError(f"{len(set(people))} people without genuine or impostor scores: no rates")
    sides = [
        (pairs.genuine < threshold, (pairs.who, None)),
        (pairs.impostor >= threshold, (pairs.left, pairs.right)),
    ]
    draws = draw_people(part, bootstrap, seed) if bootstrap and part.people_known else None
    found: list[float] = []
    for errors, who in sides:
        rate, number = float(errors.mean()), int(errors.sum())
        if draws is None or number in (0, errors.size):  # draws of no errors have none, either
            low, high = (float(end) for end in wilson_interval(number, errors.size, level))
        else:
            means = weighted_means(draws, errors[None].astype(np.float32), *who)[0]
            low, high = percentiles(means, level)
        found += [rate, low, high]
    people_scored = np.unique(np.concatenate((pairs.who, pairs.left, pairs.right))).size
    return GroupRates(people_scored, pairs.genuine.size, pairs.impostor.size, *found)
