"""What is one score worth? Its likelihood ratio by scores of other people, and how sure that is.

The interval is that of the bootstrap over the people who were calibrated on: under every draw of
them calibration and bounds are found anew. It tells what other people of the same kind would have
changed, and nothing about pictures of another kind.
"""

from dataclasses import dataclass

import numpy as np

from lrsr.errors import ScoreError
from lrsr.evaluation.arrays import Array
from lrsr.evaluation.bootstrap import draw_people, percentiles
from lrsr.evaluation.calibrators import Floats, elub
from lrsr.evaluation.likelihood import check_enough, find_calibrator
from lrsr.evaluation.pooled import PooledPairs
from lrsr.evaluation.scores import ScoreSource

_MOST_PAIRS = 10_000
"""Impostor pairs of a draw; of more, so many are taken by chance, which widens no interval much."""


@dataclass(frozen=True)
class Ratio:
    """A likelihood ratio; every field goes to JSON.

    Attributes:
        score: Whose ratio it is.
        llr: log10 LR, cut to the bounds.
        low: Lower end of its interval over people; None where none were drawn.
        high: Upper end.
        bound_low: Empirical lower bound of the calibration, log10 LR.
        bound_high: Empirical upper bound.
        cut: The calibration said more than the bounds allow.
        beyond: The score is lower or higher than all that were calibrated on.
        n_people: People who were calibrated on.
        n_genuine: Genuine pairs of those.
        n_impostor: Impostor pairs of those.
    """

    score: float
    llr: float
    low: float | None
    high: float | None
    bound_low: float
    bound_high: float
    cut: bool
    beyond: bool
    n_people: int
    n_genuine: int
    n_impostor: int


def ratio_of(
    score: float,
    source: ScoreSource,
    calibration: str = "logistic",
    *,
    bootstrap: int = 0,
    seed: int = 0,
    level: float = 0.95,
) -> Ratio:
    """Return the likelihood ratio of a score by scores of people whose identity is known.

    Args:
        score: A finite number.
        source: Scores of the same recogniser, on pictures of the same kind.
        calibration: One of :data:`lrsr.evaluation.calibrators.CALIBRATORS`.
        bootstrap: Draws of people for the interval; 0: none.
        seed: Of the draws.
        level: Of the interval, in (0, 1).

    Raises:
        ScoreError: The score is not finite, no such calibration, or fewer than ten people with a
            genuine score.

    Example:
        >>> from lrsr.evaluation.scores import Scores
        >>> people = [f"p{k}" for k in range(20)]
        >>> scores = Scores(np.eye(20) + np.linspace(0, 1.2, 400).reshape(20, 20), people, people)
        >>> low, high = (ratio_of(score, scores) for score in (0.2, 1.8))
        >>> low.llr < 0 < high.llr <= high.bound_high, high.n_people
        (True, 20)
    """
    if not np.isfinite(score):
        raise ScoreError(f"a score of {score} has no likelihood ratio: give a finite one")
    learn = find_calibrator(calibration)
    check_enough(source)
    pairs = PooledPairs(source)

    def measure(genuine: Array, impostor: Array) -> Floats:
        """Return log10 LR before and after it is cut, and the bounds."""
        calibrate = learn(genuine, impostor)
        bounds = elub(calibrate(genuine), calibrate(impostor))
        llr = float(calibrate([score])[0])
        return np.array([llr, np.clip(llr, bounds.low, bounds.high), bounds.low, bounds.high])

    plain, llr, bound_low, bound_high = measure(pairs.genuine, pairs.impostor).tolist()
    low, high = None, None
    if bootstrap and source.people_known:
        rng = np.random.default_rng(seed)
        found = []
        for drawn in draw_people(source, bootstrap, seed).T:
            genuine = np.repeat(pairs.genuine, drawn[pairs.who].astype(np.intp))
            number = (drawn[pairs.left] * drawn[pairs.right]).astype(np.intp)
            impostor = np.repeat(pairs.impostor, number)
            if impostor.size > _MOST_PAIRS:
                impostor = rng.choice(impostor, _MOST_PAIRS, replace=False)
            try:
                found.append(float(measure(genuine, impostor)[1]))
            except ScoreError:  # a draw of too few people says nothing
                found.append(np.nan)
        low, high = percentiles(np.array(found), level)
    everything = np.append(pairs.genuine, pairs.impostor)
    return Ratio(
        score=float(score),
        llr=llr,
        low=low,
        high=high,
        bound_low=bound_low,
        bound_high=bound_high,
        cut=plain != llr,
        beyond=not everything.min() <= score <= everything.max(),
        n_people=len({*source.probe_ids}),
        n_genuine=pairs.genuine.size,
        n_impostor=pairs.impostor.size,
    )
