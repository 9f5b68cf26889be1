"""How unlike are the pictures of strangers by a trial camera? The objective of the fit, and slopes.

See :mod:`lrsr.calibration.fit` for the formulas.
"""

import os
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from threading import Lock

import numpy as np
import torch
from numpy.typing import NDArray

from lrsr.calibration.parameters import Parameter
from lrsr.calibration.picture_statistics import NAMES, bend, describe, leave_one_out
from lrsr.errors import InputError

LEAST_IMAGES = 20
"""Pictures at least, to tell how much people differ."""
_MODEL_ERROR = 0.02
"""Standard deviation that no statistic is believed beyond, in units of its spread over pictures."""
_LEAST_VARIANCE = 1e-6
"""Of a statistic that is the same in all pictures."""
_FOLDS = 10
"""Of the people: what chance does is told by people whom the weights were not made from. There are
more statistics than people at times; among their own makers such weights see too little chance."""

Floats = NDArray[np.float64]
Shoot = Callable[[Mapping[str, float], int], torch.Tensor]
"""Parameters and the number of a draw of the noise, to pictures of always the same strangers."""


class Objective:
    """Means of the statistics, real and simulated, and how sure their differences are.

    Args:
        srgb: ``(n, 3, H, W)``, [0, 1], n >= 20: the real pictures.
        shoot: Photographs always the same k >= 20 strangers; is called by several threads.
        parameters: In the order of the coordinates ``(P,)``, each in units of its doubt.
        part: Share of the sides that counts.

    Attributes:
        measured: ``(S,)``, means of the real pictures.
        ranges: ``(2, P)``, lowest and highest coordinates.
        trials: How often the strangers were photographed.
        strangers: How many they are.
        spread: ``(S,)``, standard deviation of the differences by chance alone; of :meth:`weigh`.

    Raises:
        InputError: Too few pictures of either kind.
    """

    def __init__(
        self, srgb: torch.Tensor, shoot: Shoot, parameters: tuple[Parameter, ...], part: float
    ) -> None:
        self.shoot, self.parameters, self.part = shoot, parameters, part
        _enough(srgb, "pictures to fit")
        plain = describe(srgb, part)
        self._typical = torch.stack([plain.mean(0), plain.std(0)])
        self._real = np.asarray(bend(plain, leave_one_out(plain)))
        self.measured: Floats = self._real.mean(0)
        bounds = [(p.coordinate(p.low), p.coordinate(p.high)) for p in parameters]
        self.ranges: tuple[Floats, Floats] = tuple(
            np.array(bounds, dtype=np.float64).T
        )  # low, high
        self.trials, self._counting = 0, Lock()
        self._kept: dict[tuple[bytes, int], tuple[Floats, Floats]] = {}
        self.strangers = len(self._numbers(np.zeros(len(parameters))))

    def weigh(self, place: Floats | None, *, shrinkage: float, bent: bool = True) -> None:
        """Set the weights from how pictures differ.

        Args:
            place: Coordinates ``(P,)`` of a camera near enough for its pictures to tell, too; None:
                the real pictures alone.
            shrinkage: Of the covariance towards its diagonal, 0..1 (O. Ledoit, M. Wolf, J.
                Multivariate Analysis 88(2), 2004): keeps it invertible.
            bent: Heed the bent columns, which are of use near the answer only.
        """
        self._used = slice(None) if bent else slice(len(NAMES))
        pooled = self._real - self.measured if place is None else self._pooled(place)
        people = pooled[:, self._used]
        exact = 1 / len(self._real) + 1 / self.strangers
        self._known: Floats = exact * _LEAST_VARIANCE + _MODEL_ERROR**2 * _variance(people)
        self.spread: Floats = np.sqrt(exact * _variance(people) + self._known)
        self._whiten = self._whitening(people, shrinkage, exact)
        self._left_out: list[tuple[Floats, Floats]] = []
        scale = np.sqrt(exact * len(people) / (len(people) - 2))  # two means were taken off
        for k in range(_FOLDS):
            whiten = self._whitening(np.delete(people, np.s_[k::_FOLDS], 0), shrinkage, exact)
            self._left_out.append((scale * people[k::_FOLDS] / np.sqrt(len(people)), whiten))

    def simulated(self, place: Floats, draw: int = 0) -> Floats:
        """Return the means ``(S,)`` at coordinates ``(P,)``, of one draw of the noise."""
        return np.asarray(np.mean(self._halves(place, draw), axis=0))

    def residuals(self, place: Floats, draw: int = 0) -> Floats:
        """Return whitened differences, then the distances from the guess."""
        return np.concatenate([self._whitened(self.measured - self.simulated(place, draw)), place])

    def slopes(self, place: Floats, steps: Floats, draws: int = 1) -> tuple[Floats, Floats]:
        """Return how the whitened means move with the coordinates, by either half of the strangers.

        Args:
            place: Coordinates ``(P,)``.
            steps: Of the central differences, ``(P,)``, cut short at the end of a range.
            draws: Of the noise; their mean is less rough.

        Returns:
            Two times ``(S, P)``.
        """
        one = partial(self._slope, place, steps=steps, draws=draws)
        with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
            columns = list(pool.map(one, range(len(place))))
        first, second = (self._whitened(np.stack(half, 1)) for half in zip(*columns, strict=True))
        return first, second

    @staticmethod
    def jacobian(slopes: tuple[Floats, Floats]) -> Floats:
        """Return that of :meth:`residuals`, of both halves' slopes."""
        return np.concatenate([-(slopes[0] + slopes[1]) / 2, np.eye(slopes[0].shape[1])])

    def misfit(self, means: Floats) -> float:
        """Return the square of the whitened differences, of which chance alone gives about 1."""
        chance = np.square(self._whiten * np.sqrt(self._known)).sum()
        chance += sum(np.square(people @ whiten.T).sum() for people, whiten in self._left_out)
        return float(np.square(self._whitened(self.measured - means)).sum() / chance)

    def covariance(self, slopes: tuple[Floats, Floats]) -> Floats:
        """Return that ``(P, P)`` of the estimated coordinates, in squares of the doubts."""
        first, second = slopes
        guess = np.eye(first.shape[1])
        # Halves disagree on slopes that are noise; a negative curvature would make errors endless.
        curvature, axes = np.linalg.eigh((first.T @ second + second.T @ first) / 2)
        bread = np.linalg.inv(axes * curvature.clip(0) @ axes.T + guess)
        both = (first + second) / 2
        plain = np.linalg.solve(self._whiten, both)
        known = np.sqrt(self._known)[:, None] * (self._whiten.T @ both)
        moved = [people @ whiten.T @ (whiten @ plain) for people, whiten in self._left_out]
        meat = np.concatenate([*moved, known, guess])
        return np.asarray(bread @ (meat.T @ meat) @ bread.T)

    def _whitening(self, people: Floats, shrinkage: float, exact: float) -> Floats:
        """Return what whitens the differences of two means of such people, of mean 0 each."""
        covariance, variance = people.T @ people / (len(people) - 1), _variance(people)
        shrunk = (1 - shrinkage) * covariance + shrinkage * np.diag(variance)
        chance = shrunk * exact + np.diag(self._known)
        return np.asarray(np.linalg.inv(np.linalg.cholesky(chance)))

    def _slope(
        self, place: Floats, index: int, *, steps: Floats, draws: int
    ) -> tuple[Floats, Floats]:
        """Return the slopes ``(S,)`` of the means of either half along one coordinate."""
        ends = []
        for step, bound in ((-steps[index], self.ranges[0]), (steps[index], self.ranges[1])):
            end = place.copy()
            end[index] = np.clip(place[index] + step, *sorted((place[index], bound[index])))
            ends.append((end[index], np.mean([self._halves(end, k) for k in range(draws)], axis=0)))
        (low, below), (high, above) = ends
        first, second = (above - below) / (high - low)
        return first, second

    def _pooled(self, place: Floats) -> Floats:
        """Return the numbers of all people, real and strangers, each about their own mean."""
        strangers = self._numbers(place)
        return np.concatenate([self._real - self.measured, strangers - strangers.mean(0)])

    def _whitened(self, differences: Floats) -> Floats:
        return np.asarray(self._whiten @ differences[self._used])

    def _halves(self, place: Floats, draw: int = 0) -> tuple[Floats, Floats]:
        key = place.tobytes(), draw
        if key not in self._kept:
            numbers = self._numbers(place, draw)
            self._kept[key] = numbers[::2].mean(0), numbers[1::2].mean(0)
        return self._kept[key]

    def _numbers(self, place: Floats, draw: int = 0) -> Floats:
        with self._counting:
            self.trials += 1
        values = {
            parameter.name: min(max(parameter.value(float(c)), parameter.low), parameter.high)
            for parameter, c in zip(self.parameters, place, strict=True)
        }
        pictures = self.shoot(values, draw)
        _enough(pictures, "rendered people")
        return np.asarray(bend(describe(pictures, self.part), self._typical))


def _variance(people: Floats) -> Floats:
    return np.asarray(np.square(people).sum(0) / (len(people) - 1)).clip(_LEAST_VARIANCE)


def _enough(srgb: torch.Tensor, what: str) -> None:
    if len(srgb) < LEAST_IMAGES:
        raise InputError(f"{len(srgb)} {what}: give at least {LEAST_IMAGES}, of different people")
