"""Which camera took these pictures? One whose pictures of strangers look the same on average.

No picture needs a reference. Rendered strangers go through the camera with trial parameters θ, and
the means of some numbers a picture (:mod:`lrsr.camera.statistics`) are made to agree with the real
ones': the method of simulated moments (D. McFadden, Econometrica 57(5), 1989, doi:10.2307/1913621;
as indirect inference, C. Gouriéroux, A. Monfort, E. Renault, J. Applied Econometrics 8, 1993,
doi:10.1002/jae.3950080507). Minimised is

    (m - s(θ))ᵀ W (m - s(θ)) + Σ u(θ)²,   W = (C (1/n + 1/k))⁻¹

with C the covariance of the numbers between pictures, n and k how many there are, and u the
distance from the guess in units of its doubt, so that what the pictures do not show stays where the
guess has it. W discounts what differs between people, such as albedo, and what goes with it. The
noise keeps its seeds, so s(θ) is a function; Gauss and Newton's steps come from finite differences,
because the true codec has no gradient.

What can be known: blur and sharpening apart from each other, since noise is sharpened but not
blurred; less so without noise. Read and shot noise as shares of white, as far as the codec leaves
any; read noise in electrons only as well as the electrons at white. Exposure only together with the
subjects' albedo, and contrast with the lighting's; the cast relative to the rendered population's
skin, hair and light. What in these pictures the guess decides rather than the pictures is marked:
``known`` is false.

Measured on 50 pictures of 32 x 32 of each of three hidden cameras, unlike the start only in what is
fitted, against 100 strangers (JPEG 75 | JPEG 90 | not compressed): blur +2, -6, 0 %; quality exact;
read noise as a share of white -10, -20, -10 %; gains within 2 %. Electrons at white were off by
+84, -59, -30 %, and with them read noise in electrons; sharpening by +44, -6, +10 %. Those standard
errors of electrons were too small. A fourth, JPEG 50: -5, exact, -9, gains -3 and +4 %.
Noise that the strangers' renderings have is taken from the
camera's: give them samples enough.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.optimize import least_squares

from lrsr.camera.contract import check_setting
from lrsr.camera.parameters import PARAMETERS, Parameter
from lrsr.camera.statistics import describe
from lrsr.errors import InputError

LEAST_IMAGES = 20
"""Pictures at least; the covariance of their numbers needs as many as there are numbers."""
STEPS = (0.4, 0.2, 0.1)
"""Of finite differences, in units of a parameter's doubt: a codec's rounding makes a rough ground,
which long steps level; the last are short enough for the minimum."""
SHRINKAGE = 0.3
"""Towards the diagonal, of the covariance (O. Ledoit, M. Wolf, 2004): keeps it invertible."""
MODEL_ERROR = 0.02
"""Standard deviation that no statistic is believed beyond, in units of its spread over pictures."""

Floats = NDArray[np.float64]
Shoot = Callable[[Mapping[str, float]], torch.Tensor]


@dataclass(frozen=True)
class Fitted:
    """A parameter's value, and how well it is known.

    Attributes:
        value: In the unit that the name says.
        error: Standard error, in the same unit (of first order).
        known: The pictures halve the guess's doubt at least.
    """

    value: float
    error: float
    known: bool


@dataclass(frozen=True)
class Fit:
    """What came out.

    Attributes:
        values: By parameter.
        measured: Means of the statistics of the real pictures, ``(S,)``.
        before: Those of the camera that the search began with.
        after: Those of the fitted camera.
        spread: Standard deviation by which two such means differ by chance alone, ``(S,)``.
        misfit_before: Mean square of the differences, whitened; chance alone gives about 1.
        misfit_after: The same of the fitted camera.
        trials: How often the strangers were photographed.
    """

    values: dict[str, Fitted]
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
            ``(k, 3, H, W)``, with the same noise each time.
        parameters: What to search for.
        part: Share of the sides that counts; see :func:`lrsr.camera.statistics.describe`.
        rounds: Steps of Gauss and Newton at most, >= 1, at each of :data:`STEPS`.

    Returns:
        The parameters and how well they agree.

    Raises:
        InputError: Too few pictures of either kind, or ``rounds`` < 1.
        ImageContractError: The images break the contract or are too small.
    """
    check_setting("rounds", rounds, rounds >= 1, "at least 1")
    search = _Search(_described(srgb, part, "pictures to fit"), shoot, tuple(parameters), part)
    start = np.zeros(len(parameters))
    before = search.simulated(start)
    bounds = np.array([(p.coordinate(p.low), p.coordinate(p.high)) for p in parameters]).T
    place = start
    for step in STEPS:
        search.step = step
        search.weigh(place)
        place = least_squares(
            search.residuals,
            place,
            jac=search.slopes,
            bounds=bounds,
            max_nfev=rounds,
            xtol=1e-3,
            ftol=1e-3,
        ).x
    after = search.simulated(place)
    return Fit(
        values=search.judged(place),
        measured=search.measured,
        before=before,
        after=after,
        spread=search.spread,
        misfit_before=search.misfit(before),
        misfit_after=search.misfit(after),
        trials=search.trials,
    )


class _Search:
    """The objective: remembers the last trial, which residuals and slopes share."""

    def __init__(
        self, real: Floats, shoot: Shoot, parameters: tuple[Parameter, ...], part: float
    ) -> None:
        self.shoot, self.parameters, self.part = shoot, parameters, part
        self.measured = real.mean(0)
        self.trials, self.step = 0, STEPS[0]
        self._kept: dict[bytes, Floats] = {}
        strangers = len(self._numbers(np.zeros(len(parameters))))
        self.real, self.strangers = real, strangers
        self.weigh(np.zeros(len(parameters)))

    def weigh(self, place: Floats) -> None:
        """Set the weights from how pictures differ, the real ones and those at coordinates."""
        pooled = np.cov(self.real.T) / 2 + np.cov(self._numbers(place).T) / 2
        if not self.trials or not place.any():
            pooled = np.cov(self.real.T)
        variance = np.diag(pooled).clip(1e-6)
        covariance = (1 - SHRINKAGE) * pooled + SHRINKAGE * np.diag(variance)
        covariance = covariance * (1 / len(self.real) + 1 / self.strangers)
        covariance += np.diag(MODEL_ERROR**2 * variance)
        self.spread: Floats = np.sqrt(np.diag(covariance))
        self._whiten = np.linalg.inv(np.linalg.cholesky(covariance))

    def simulated(self, place: Floats) -> Floats:
        """Return the means at coordinates ``(P,)``."""
        key = place.tobytes()
        if key not in self._kept:
            self._kept[key] = self._numbers(place).mean(0)
        return self._kept[key]

    def residuals(self, place: Floats) -> Floats:
        """Return whitened differences, then the distances from the guess."""
        return np.concatenate([self._whitened(self.simulated(place)), place])

    def slopes(self, place: Floats) -> Floats:
        """Return the Jacobian of :meth:`residuals`, by differences towards the guess's side."""
        here, columns = self.residuals(place), []
        for index, parameter in enumerate(self.parameters):
            roomy = place[index] + self.step <= parameter.coordinate(parameter.high)
            step = np.zeros_like(place)
            step[index] = self.step if roomy else -self.step
            columns.append((self.residuals(place + step) - here) / step[index])
        return np.stack(columns, 1)

    def misfit(self, means: Floats) -> float:
        """Return the mean square of the whitened differences."""
        return float(np.square(self._whitened(means)).mean())

    def judged(self, place: Floats) -> dict[str, Fitted]:
        """Return values with their standard errors, from the curvature at ``place``."""
        self.step = STEPS[0]
        slopes = self.slopes(place)
        doubts = np.sqrt(np.diag(np.linalg.inv(slopes.T @ slopes)))
        judged = {}
        for parameter, coordinate, doubt in zip(self.parameters, place, doubts, strict=True):
            value = parameter.value(float(coordinate))
            error = parameter.doubt * float(doubt) * (value if parameter.logarithmic else 1.0)
            judged[parameter.name] = Fitted(value, error, bool(doubt < 0.5))
        return judged

    def _whitened(self, means: Floats) -> Floats:
        return np.asarray(self._whiten @ (self.measured - means))

    def _numbers(self, place: Floats) -> Floats:
        self.trials += 1
        values = {
            parameter.name: min(max(parameter.value(float(c)), parameter.low), parameter.high)
            for parameter, c in zip(self.parameters, place, strict=True)
        }
        return _described(self.shoot(values), self.part, "rendered people")


def _described(srgb: torch.Tensor, part: float, what: str) -> Floats:
    if len(srgb) < LEAST_IMAGES:
        raise InputError(f"{len(srgb)} {what}: give at least {LEAST_IMAGES}, of different people")
    numbers: Floats = describe(srgb, part).numpy()
    return numbers
