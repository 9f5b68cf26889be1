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
from lrsr.evaluation.bootstrap import Draws, draw_people, percentiles, two_sided_p
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
from lrsr.evaluation.roc import PartialArea, RocCurve, partial_area, trace_roc_of
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
        partial: Areas at FMRs up to each target.
        cmc: How often the right person is among the first ranks; None: nobody was looked for in a
            gallery, as pairs are listed.
        fta: Share of the probes without a score.
        fnmr: FNMR at each of the target FMRs, with the FMR that was achieved.
    """

    area: AucEstimate
    curve: RocCurve
    eer: float
    d_prime: float
    partial: tuple[PartialArea, ...]
    cmc: CmcCurve | None
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
    bootstrap: int = 0,
    seed: int = 0,
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
        bootstrap: Draws of people for the bootstrap's intervals; 0: none. A draw costs about 3 ns a
            pair and, a method, 24 bytes a genuine score.
        seed: Of the draws.

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
    draws = draw_people(first, bootstrap, seed) if bootstrap and first.people_known else None
    passes = {name: _Method(name, source, target_fmrs, draws) for name, source in methods.items()}
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

    def __init__(
        self,
        name: str,
        source: ScoreSource,
        target_fmrs: Collection[float],
        draws: Draws | None,
    ) -> None:
        self.name, self.source, self.mated_scores = name, source, source.mated_scores()
        self.draws, self._targets = draws, [float(target) for target in target_fmrs]
        self._rates = Rates(source, target_fmrs)
        with _named(name):
            self.tally = Tally(source, self.mated_scores, draws)

    def add(self, tile: Tile) -> Ints:
        """Take the next tile; return the placements of its impostor scores."""
        self._rates.add(tile)
        return self.tally.add(tile, tile.others)

    def summary(self, level: float) -> Summary:
        with _named(self.name):
            area = estimate_auc_of(self.tally.placements, level)
            curve = trace_roc_of(self.tally.placements)
            return Summary(
                area=self._with_subjects(area),
                curve=curve,
                eer=equal_error_rate(curve),
                d_prime=self._rates.d_prime(),
                partial=tuple(partial_area(curve, fmr) for fmr in self._targets if 0 < fmr < 1),
                cmc=self._rates.cmc(),
                fta=self._rates.fta,
                fnmr=tuple(self._with_draws(point, level) for point in self._rates.fnmr(level)),
            )

    def _with_subjects(self, area: AucEstimate) -> AucEstimate:
        if not self.source.people_known:
            return area
        return _with_subjects(area, area.auc, [self.tally], (0.0, 1.0))

    def _with_draws(self, point: OperatingPoint, level: float) -> OperatingPoint:
        if self.tally.resampled is None:
            return point
        low, high = percentiles(self.tally.resampled.fnmr(point.target_fmr), level)
        return replace(point, bootstrap_low=low, bootstrap_high=high)


class _Test:
    """Gathers what the paired test of two methods needs."""

    def __init__(self, a: _Method, b: _Method) -> None:
        self._name, self._sums = f"{a.name} against {b.name}", DifferenceSums()
        self._tallies = [a.tally, b.tally]
        self._people_known = a.source.people_known
        self._shared = a.source.complete and b.source.complete
        if not self._shared:
            fails = np.isnan(a.mated_scores) | np.isnan(b.mated_scores)
            with _named(self._name):
                self._tallies = [
                    Tally(method.source, np.where(fails, np.nan, method.mated_scores), a.draws)
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
        if not self._people_known:
            return test
        test = _with_subjects(test, test.difference, self._tallies, (-1.0, 1.0))
        if a.resampled is None or b.resampled is None:
            return test
        return replace(test, bootstrap_p=two_sided_p(a.resampled.areas() - b.resampled.areas()))


def _with_subjects(
    result: _Result, value: float, tallies: Sequence[Tally], limits: tuple[float, float]
) -> _Result:
    """Add the intervals over people, of jackknife and bootstrap, where there are enough of them."""
    drawn = [tally.resampled.areas() for tally in tallies if tally.resampled is not None]
    if drawn:
        low, high = percentiles(drawn[0] - drawn[1] if len(drawn) > 1 else drawn[0], result.level)
        result = replace(result, bootstrap_low=low, bootstrap_high=high)
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
