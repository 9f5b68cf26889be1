"""How well does each method tell people apart, and does one do it better? All in one pass.

Every measure is made of counts, sums and the highest scores, gathered tile by tile: the matrix of
scores is never held, and the same numbers come out whether it exists or not.
"""

import itertools
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from lrsr.errors import ScoreError
from lrsr.evaluation.delong import (
    AucComparison,
    AucEstimate,
    DifferenceSums,
    check_level,
    estimate_auc_of,
    normal_quantile,
)
from lrsr.evaluation.placements import Ints
from lrsr.evaluation.rates import CmcCurve, OperatingPoint, Rates, equal_error_rate
from lrsr.evaluation.roc import RocCurve, trace_roc_of
from lrsr.evaluation.scores import ScoreSource, Tile
from lrsr.evaluation.subjects import Tally, jackknife_std

Pair = tuple[str, str]
_Result = TypeVar("_Result", AucEstimate, AucComparison)


@dataclass(frozen=True, eq=False)
class Summary:
    """What is measured of one method.

    Attributes:
        area: AUC with DeLong's interval and, beside it, that of the subjects.
        curve: The whole ROC curve; :func:`lrsr.evaluation.roc.band` puts a band round it.
        eer: Equal error rate.
        d_prime: Distance of the means over the pooled deviation.
        cmc: How often the right person is among the first ranks.
        fta: Share of the probes without a score.
        fnmr: FNMR at each of the target FMRs, with the FMR that was achieved.
    """

    area: AucEstimate
    curve: RocCurve
    eer: float
    d_prime: float
    cmc: CmcCurve
    fta: float
    fnmr: tuple[OperatingPoint, ...]


@dataclass(frozen=True)
class Evaluation:
    """What :func:`summarise` finds.

    Attributes:
        summaries: By method.
        comparisons: By pair; a positive difference favours the first of the two.
    """

    summaries: Mapping[str, Summary]
    comparisons: Mapping[Pair, AucComparison]


def summarise(
    methods: Mapping[str, ScoreSource],
    *,
    pairs: Collection[Pair] | None = None,
    level: float = 0.95,
    target_fmrs: Collection[float] = (1e-1, 1e-2, 1e-3),
) -> Evaluation:
    """Evaluate methods on the same probes and gallery, and test pairs of them against each other.

    A failure to acquire is counted and not compared; a pair of methods is compared on what both
    acquired. Of matrices and of cosines that are made on the way the results are the same. Memory
    over the inputs is, for each method, some tiles (2 MiB each) and the impostor scores that the
    largest target FMR lets pass (100 MB for 0.1 of 10^8).

    Args:
        methods: Scores by method.
        pairs: Which methods are compared; None: every one with all before it.
        level: Confidence level of all intervals, in (0, 1).
        target_fmrs: Where the FNMR is measured, each in [0, 1]; may be empty.

    Raises:
        ScoreError: No method, methods with different probes or gallery, fewer than two genuine or
            impostor scores of a method or of a pair of them, no spread at all in both kinds, an
            infinite score, a pair of unknown methods, a target outside [0, 1], or a level outside
            (0, 1). The message names the method.

    Example:
        >>> from lrsr.evaluation.scores import Scores
        >>> people = [f"p{k}" for k in range(50)]
        >>> noise = np.random.default_rng(0).normal(size=(2, 50, 50))
        >>> found = summarise({
        ...     "base": Scores(noise[0] + np.eye(50), people, people),
        ...     "better": Scores(noise[1] + 2 * np.eye(50), people, people),
        ... })
        >>> area, test = found.summaries["base"].area, found.comparisons["better", "base"]
        >>> round(area.auc, 3), round(area.std, 3), round(area.subject_std, 3)
        (0.761, 0.027, 0.027)
        >>> test.difference > 0, test.p < 0.01
        (True, True)
    """
    level = check_level(level)
    if not methods:
        raise ScoreError("no method to evaluate: give the scores of at least one")
    first = next(iter(methods.values()))
    for name, source in methods.items():
        first.check_same_pairs(source, name)
    if pairs is None:
        pairs = [(b, a) for a, b in itertools.combinations(methods, 2)]
    for name in itertools.chain.from_iterable(pairs):
        if name not in methods:
            raise ScoreError(f"no method {name!r} to compare: choose of {', '.join(methods)}")
    passes = {name: _Method(name, source, target_fmrs) for name, source in methods.items()}
    tests = {(a, b): _Test(passes[a], passes[b]) for a, b in pairs}
    for tiles in zip(*(source.tiles() for source in methods.values()), strict=True):
        tile_of = dict(zip(methods, tiles, strict=True))
        placements = {name: passes[name].add(tile) for name, tile in tile_of.items()}
        for (a, b), test in tests.items():
            test.add((tile_of[a], tile_of[b]), (placements[a], placements[b]))
    return Evaluation(
        {name: method.summary(level) for name, method in passes.items()},
        {pair: test.comparison(level) for pair, test in tests.items()},
    )


class _Method:
    """Gathers what the measures of one method need."""

    def __init__(self, name: str, source: ScoreSource, target_fmrs: Collection[float]) -> None:
        self.name, self.source, self.mated_scores = name, source, source.mated_scores()
        self._rates = Rates(source, target_fmrs)
        with _named(name):
            self.tally = Tally(source, self.mated_scores)

    def add(self, tile: Tile) -> Ints:
        """Take the next tile; return the placements of its impostor scores."""
        self._rates.add(tile)
        return self.tally.add(tile, tile.others)

    def summary(self, level: float) -> Summary:
        with _named(self.name):
            area = estimate_auc_of(self.tally.placements, level)
            curve = trace_roc_of(self.tally.placements)
            return Summary(
                area=_with_subjects(area, area.auc, [self.tally], (0.0, 1.0)),
                curve=curve,
                eer=equal_error_rate(curve),
                d_prime=self._rates.d_prime(),
                cmc=self._rates.cmc(),
                fta=self._rates.fta,
                fnmr=self._rates.fnmr(level),
            )


class _Test:
    """Gathers what the paired test of two methods needs."""

    def __init__(self, a: _Method, b: _Method) -> None:
        self._name, self._sums = f"{a.name} against {b.name}", DifferenceSums()
        self._tallies = [a.tally, b.tally]
        self._shared = a.source.complete and b.source.complete
        if not self._shared:
            fails = np.isnan(a.mated_scores) | np.isnan(b.mated_scores)
            with _named(self._name):
                self._tallies = [
                    Tally(method.source, np.where(fails, np.nan, method.mated_scores))
                    for method in (a, b)
                ]

    def add(self, tiles: Sequence[Tile], placements: Sequence[Ints]) -> None:
        """Take the next tile of both, and what was found of all that each of them acquired."""
        if not self._shared:
            others = np.union1d(tiles[0].others, tiles[1].others)
            placements = [
                tally.add(tile, others) for tally, tile in zip(self._tallies, tiles, strict=True)
            ]
        self._sums.add(*placements)

    def comparison(self, level: float) -> AucComparison:
        a, b = self._tallies
        with _named(self._name):
            test = self._sums.compare(a.placements, b.placements, level)
        return _with_subjects(test, test.difference, self._tallies, (-1.0, 1.0))


def _with_subjects(
    result: _Result, value: float, tallies: Sequence[Tally], limits: tuple[float, float]
) -> _Result:
    """Add the interval of the jackknife over people, where there are enough of them."""
    try:
        areas = [tally.areas() for tally in tallies]
    except ScoreError:
        return result
    std = jackknife_std(areas[0] - areas[1] if len(areas) > 1 else areas[0])
    reach = normal_quantile(result.level) * std
    low, high = max(limits[0], value - reach), min(limits[1], value + reach)
    return replace(result, subject_std=std, subject_low=low, subject_high=high)


@contextmanager
def _named(what: str) -> Iterator[None]:
    try:
        yield
    except ScoreError as error:
        raise ScoreError(f"{what}: {error}") from error
