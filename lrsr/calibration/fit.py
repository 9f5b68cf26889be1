"""Which camera took these pictures? One whose pictures of strangers look the same on average.

No picture needs a reference. Rendered strangers go through the camera with trial parameters θ, and
the means of some numbers a picture (:mod:`lrsr.calibration.picture_statistics`) are made to agree
with the real ones': the method of simulated moments (D. McFadden, Econometrica 57(5), 1989,
doi:10.2307/1913621; as indirect inference, C. Gouriéroux, A. Monfort, E. Renault, J. Applied
Econometrics 8, 1993, doi:10.1002/jae.3950080507). Minimised is

    (m - s(θ))ᵀ W (m - s(θ)) + Σ u(θ)²,   W = (C (1/n + 1/k))⁻¹

with C the covariance of the numbers between pictures, n and k how many there are, and u the
distance from the guess in units of its doubt, so that what the pictures do not show stays where the
guess has it. W discounts what differs between people, such as albedo, and what goes with it. The
noise keeps its seeds, so s(θ) is a function; Gauss and Newton's steps come from finite differences,
because the true codec has no gradient.

Standard errors are those of the estimator that was used, whatever its weights (a sandwich: L. P.
Hansen, Econometrica 50(4), 1982, doi:10.2307/1912775, theorem 3.1): with J the slopes of s,

    V = A⁻¹ (Jᵀ W C (1/n + 1/k) W J + 1) A⁻ᵀ,   A = Jᵀ W J + 1.

In it C is that of a tenth of the people each, and W made from the other nine: with few people W
would else see too little chance in those whom it was made from (2.5 times too little with 20
pictures and 20 strangers, 1.1 to 1.2 times with 50 and 200).

Slopes that are mere noise of the simulation would feign curvature, and certainty, in Jᵀ W J; the
product of the slopes of two halves of the strangers does not, because their noises are strangers
too.

What can be known: blur and sharpening apart from each other, since noise is sharpened but not
blurred, and noise of the colours is neither; less so without noise. Read and shot noise as shares
of white, as far as the codec leaves any; read noise in electrons only as well as the electrons at
white, by the growth of noise with brightness. Exposure only together with the subjects' albedo,
and contrast with the lighting's; the cast relative to the rendered population's skin, hair and
light. What in these pictures the guess decides rather than the pictures is marked: ``known`` is
false.

Noise that the strangers' renderings have is taken from the camera's: give them samples enough.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from math import exp, sqrt

import numpy as np
import torch
from scipy.optimize import least_squares

from lrsr.calibration.objective import Floats, Objective, Shoot
from lrsr.calibration.parameters import PARAMETERS, Parameter
from lrsr.camera.checks import check_setting

_STEPS = (0.3, 1.0)
"""Of finite differences, in units of a parameter's doubt: as long as its standard error, within
these. A codec's rounding makes a rough ground, which long steps level."""
_SHRINKAGE = 0.3
"""Of the covariance towards its diagonal."""
_SETTLINGS = (1, 3, 3)
"""Draws of the noise for the slopes; slopes and weights are made anew as often."""
_DRAWS, _GAINS = 18, (0.5, 0.25, 0.1)
"""How many steps are taken after each, and which share of a whole one each is: the smaller ones
where the larger do not lead downhill."""
_LONGEST = 0.5
"""A step is no longer than that in any coordinate, since slopes are those of one place."""
_JUDGES = 3
"""Further draws, which tell whether the steps led downhill."""
_INTERVAL_SD = 1.96
"""Half the width of an interval that holds 95 % of a normal variable."""


@dataclass(frozen=True)
class Fitted:
    """A parameter's value, and how well it is known.

    Attributes:
        value: In the unit that the name says.
        error: Standard error, in the same unit (of first order).
        low: Lower end of the interval of 95 %: of a logarithm, where a factor makes more sense.
        high: Upper end.
        known: The pictures halve the guess's doubt at least.
    """

    value: float
    error: float
    low: float
    high: float
    known: bool


@dataclass(frozen=True)
class Fit:
    """What came out.

    Attributes:
        values: By parameter.
        parameters: What was searched for.
        covariance: ``(P, P)`` of the estimates, each in units of its parameter's doubt.
        measured: Means of the statistics of the real pictures, ``(S,)``, named
            :data:`lrsr.calibration.picture_statistics.BENT_NAMES`.
        before: Those of the camera that the search began with.
        after: Those of the fitted camera.
        spread: Standard deviation by which two such means differ by chance alone, ``(S,)``.
        misfit_before: Mean square of the differences, whitened; chance alone gives about 1.
        misfit_after: The same of the fitted camera.
        trials: How often the strangers were photographed.
    """

    values: dict[str, Fitted]
    parameters: tuple[Parameter, ...]
    covariance: Floats
    measured: Floats
    before: Floats
    after: Floats
    spread: Floats
    misfit_before: float
    misfit_after: float
    trials: int

    @property
    def plain(self) -> dict[str, float]:
        """The values alone."""
        return {name: fitted.value for name, fitted in self.values.items()}

    def product(self, *names: str) -> Fitted:
        """Return the product of parameters that are searched by their logarithms.

        Their errors may cancel or add up, which the standard errors of each do not tell.
        """
        factors = np.array([p.doubt * (p.name in names) for p in self.parameters])
        value = float(np.prod([self.values[name].value for name in names]))
        sd = sqrt(float(factors @ self.covariance @ factors))
        return _factor(value, sd, known=sd < sqrt(float(factors @ factors)) / 2)


def fit_camera(
    srgb: torch.Tensor,
    shoot: Shoot,
    *,
    parameters: Sequence[Parameter] = PARAMETERS,
    part: float = 0.75,
    rounds: int = 12,
) -> Fit:
    """Find the parameters with which ``shoot`` makes pictures like ``srgb``.

    Args:
        srgb: ``(n, 3, H, W)``, [0, 1], n >= 20: all of one camera, of different people.
        shoot: Photographs always the same k >= 20 other people with given parameters:
            ``(k, 3, H, W)``, with the same noise each time; is called by several threads.
        parameters: What to search for.
        part: Share of the sides that counts: :func:`lrsr.calibration.picture_statistics.describe`.
        rounds: Steps of Gauss and Newton at most, >= 1, of the first, coarse part of the search.

    Returns:
        The parameters and how well they agree.

    Raises:
        InputError: Too few pictures of either kind, or ``rounds`` < 1.
        ImageContractError: The images break the contract or are too small.
    """
    check_setting("rounds", rounds, rounds >= 1, "at least 1")
    with _one_thread():
        return _fit(Objective(srgb, shoot, tuple(parameters), part), rounds)


def expected_trials(parameters: int = len(PARAMETERS), rounds: int = 12) -> int:
    """Return how often :func:`fit_camera` photographs the strangers, about: a search ends early."""
    slopes = 2 * parameters
    settling = sum(draws * slopes + _DRAWS + 2 * _JUDGES for draws in _SETTLINGS)
    return rounds * (slopes + 1) + settling + _SETTLINGS[-1] * slopes


@contextmanager
def _one_thread() -> Iterator[None]:
    """Keep torch to one thread a trial: on small pictures many threads take 7 times as long.

    Trials for the slopes run beside each other instead.
    """
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(before)


def _fit(objective: Objective, rounds: int) -> Fit:
    start = np.zeros(len(objective.parameters))
    objective.weigh(None, shrinkage=_SHRINKAGE, bent=False)
    place, steps = _descended(objective, start, rounds), np.full(len(start), _STEPS[0])
    for draws in _SETTLINGS:
        objective.weigh(place, shrinkage=_SHRINKAGE)
        slopes = objective.slopes(place, steps, draws)
        place = _settled(objective, place, slopes)
        steps = np.sqrt(np.diag(objective.covariance(slopes))).clip(*_STEPS)
    objective.weigh(place, shrinkage=_SHRINKAGE)
    covariance = objective.covariance(objective.slopes(place, steps, _SETTLINGS[-1]))
    before, after = objective.simulated(start), objective.simulated(place)
    return Fit(
        values={
            parameter.name: _fitted(parameter, float(coordinate), sqrt(float(variance)))
            for parameter, coordinate, variance in zip(
                objective.parameters, place, np.diag(covariance), strict=True
            )
        },
        parameters=objective.parameters,
        covariance=covariance,
        measured=objective.measured,
        before=before,
        after=after,
        spread=objective.spread,
        misfit_before=objective.misfit(before),
        misfit_after=objective.misfit(after),
        trials=objective.trials,
    )


def _descended(objective: Objective, place: Floats, rounds: int) -> Floats:
    """Return where Gauss and Newton's steps from a place end, on one draw of the noise."""
    steps = np.full(len(place), _STEPS[0])
    found = least_squares(
        objective.residuals,
        place,
        jac=lambda here: objective.jacobian(objective.slopes(here, steps)),
        bounds=objective.ranges,
        max_nfev=rounds,
        xtol=1e-3,
        ftol=1e-3,
    )
    return np.asarray(found.x)


def _settled(objective: Objective, place: Floats, slopes: tuple[Floats, Floats]) -> Floats:
    """Return the mean of steps on fresh draws, which no draw's rough ground holds up.

    Stochastic approximation with averaging (B. T. Polyak, A. B. Juditsky, SIAM J. Control and
    Optimization 30(4), 1992, doi:10.1137/0330046); the first third only gets there. Where the
    slopes mislead, as those of noise below a codec's coarsest step do, shorter steps are tried, and
    at last none.
    """
    inverse = np.linalg.pinv(objective.jacobian(slopes)).astype(np.float64)
    before = _cost(objective, place)
    for gain in _GAINS:
        mean = _wandered(objective, place, gain * inverse)
        if _cost(objective, mean) < before:
            return mean
    return place


def _wandered(objective: Objective, place: Floats, inverse: Floats) -> Floats:
    visited = []
    for draw in range(1, _DRAWS + 1):
        step = inverse @ objective.residuals(place, draw)
        place = (place - step / max(1.0, np.abs(step).max() / _LONGEST)).clip(*objective.ranges)
        visited.append(place)
    return np.asarray(np.mean(visited[_DRAWS // 3 :], axis=0))


def _cost(objective: Objective, place: Floats) -> float:
    """Return the square of the residuals, of draws of the noise that no step was taken on."""
    draws = range(_DRAWS + 1, _DRAWS + 1 + _JUDGES)
    mean = np.mean([objective.residuals(place, draw) for draw in draws], axis=0)
    return float(np.square(mean).sum())


def _fitted(parameter: Parameter, coordinate: float, doubt: float) -> Fitted:
    value, sd = parameter.value(coordinate), parameter.doubt * doubt
    if parameter.logarithmic:
        return _factor(value, sd, known=doubt < 0.5)
    away = _INTERVAL_SD * sd
    return Fitted(value, sd, value - away, value + away, known=doubt < 0.5)


def _factor(value: float, sd: float, *, known: bool) -> Fitted:
    """Return a value whose logarithm has the standard error ``sd``."""
    away = exp(_INTERVAL_SD * sd)
    return Fitted(value, sd * value, value / away, value * away, known)
