"""Which face, held how, has its points there? Gauss-Newton over pose, camera, shape and expression.

A face is ``mean + components z + units e`` (:mod:`lrsr.identities.photographs.space`), its points
are vertices of it with the network's own noise (:mod:`~lrsr.identities.photographs.correspondence`)
and a perspective (:mod:`~lrsr.identities.photographs.perspective`). The prior is the population
itself, a little widened; face units stay between 0 and 1.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from lrsr.identities.face.eyes import find_eyes
from lrsr.identities.photographs.correspondence import Correspondence, tip_of
from lrsr.identities.photographs.perspective import Perspective
from lrsr.identities.photographs.space import load_space
from lrsr.identities.shape.basis import load_basis

Points = NDArray[np.float64]

_STEPS = 7
_TRUSTED_STEPS = 3
"""Before points that do not fit lose weight."""
_OUTLIER = 2.5
"""A point that is off by this many standard deviations counts half."""
_NOISE_SHARE = 0.4
"""Of the network's noise on rendered faces on photographs, which it knows better: a judgement."""
_LEAST_REST_MM = 0.6
"""Noise of each point for itself."""
_WIDER = 1.3
"""Standard deviation of the components: photographed people differ more than drawn ones."""
_FARTHEST = 3.5
_UNIT_SPREAD = 0.25
_NEARNESS = (1 / 1000, 1 / 2500)
"""Mean and standard deviation of 1/distance, 1/mm."""
_NEARNESS_LIMITS = (1 / 20_000, 1 / 350)
_POSE = 7
"""Unknowns before the face's own: turn (3), log scale, shift (2), nearness per metre."""
_LARGEST_ZOOM = 0.3
_ROUNDS = 8
"""Of the active set, at most."""


@dataclass(frozen=True, eq=False)
class Fit:
    """A face that was fitted to points.

    Attributes:
        rest: ``(K,)`` coefficients of the shape space, without expression.
        units: Strength of each face unit, [0, 1].
        perspective: Of the axes of the basis.
        residual_mm: ``(N,)`` how far each point is from where the face has it, bias aside.
        strangeness: Root mean square of the components: about 1 for drawn people.
    """

    rest: Points
    units: Mapping[str, float]
    perspective: Perspective
    residual_mm: Points
    strangeness: float

    @property
    def acting(self) -> Points:
        """Coefficients of the face as it was photographed: ``(K,)``."""
        column, weights = load_basis().column, self.rest.copy()
        for unit, strength in self.units.items():
            weights[column[f"unit/{unit}"]] += strength
        return weights


@dataclass(frozen=True, eq=False)
class _State:
    """Where Gauss-Newton stands; axes of the basis from :attr:`FaceFitter.origin`."""

    seen: Perspective
    face: Points


class FaceFitter:
    """Fits faces to the points of one network.

    Args:
        noise: Where its points are on our mesh, and how wrong it is.
    """

    def __init__(self, noise: Correspondence) -> None:
        basis, self.space = load_basis(), load_space()
        directions = self.space.directions
        base = basis.shape(self.space.mean)
        self.origin = find_eyes(basis, base).pupils.mean(axis=0)
        rows = basis.surface.matrix[noise.vertices]
        moved = (basis.fields @ directions).reshape(-1, 3, directions.shape[1])[: basis.n_skin]
        count = len(noise.vertices)
        self._mean = rows @ base.skin - self.origin
        self._moves = (rows @ moved.reshape(basis.n_skin, -1)).reshape(count, 3, -1)
        self._bias = noise.bias_mm
        self._noise = _NOISE_SHARE * noise.components_mm
        self._rest_mm = max(_LEAST_REST_MM, _NOISE_SHARE * noise.rest_mm)
        n_units = len(self.space.units)
        n_shapes = directions.shape[1] - n_units
        self._spread = np.repeat([_WIDER, _UNIT_SPREAD], [n_shapes, n_units])
        self._low = np.repeat([-_FARTHEST, 0.0], [n_shapes, n_units])
        self._high = np.repeat([_FARTHEST, 1.0], [n_shapes, n_units])

    def __call__(self, points_px: Points) -> Fit:
        """Fit a face.

        Args:
            points_px: ``(N, 2)`` (x, y) of the correspondence's points on the picture.
        """
        found = points_px * [1, -1]
        state, trust = self._start(found), np.ones(len(found))
        for step in range(_STEPS):
            error = found - self._expected(state)
            state = self._step(state, error, trust)
            if step >= _TRUSTED_STEPS - 1:
                far = np.linalg.norm(error, axis=1) / state.seen.px_per_mm / self._rest_mm
                trust = 1 / (1 + (far / np.sqrt(2) / _OUTLIER) ** 2)
        return self._finished(state, found)

    def _points(self, state: _State) -> Points:
        return np.asarray(self._mean + self._moves @ state.face)

    def _expected(self, state: _State) -> Points:
        """Return where the network finds the points of a face: bias included, y up."""
        px, _ = state.seen.project(self._points(state))
        tip = tip_of(state.seen.rotation)
        return np.asarray(px * [1, -1] + state.seen.px_per_mm * self._bias @ tip.T)

    def _start(self, found: Points) -> _State:
        """Begin with the mean face in weak perspective."""
        centred = self._mean - self._mean.mean(axis=0)
        linear = np.linalg.lstsq(centred, found - found.mean(axis=0), rcond=None)[0].T
        left, sizes, right = np.linalg.svd(linear, full_matrices=False)
        x, y = left @ right
        rotation, scale = np.stack([x, y, np.cross(x, y)]), float(sizes.mean())
        shift = found.mean(axis=0) - scale * (rotation[:2] @ self._mean.mean(axis=0))
        seen = Perspective(rotation, scale, shift, _NEARNESS[0], np.zeros(3))
        return _State(seen, np.zeros(self._moves.shape[2]))

    def _slopes(self, state: _State) -> Points:
        """Return how each point moves with each unknown: ``(N, 2, unknowns)``, px."""
        seen = state.seen
        turned = seen.turned(self._points(state))
        larger = 1 / (1 - seen.nearness * turned[:, 2])
        scale, flat = seen.px_per_mm, turned[:, :2] * larger[:, None]
        by_place = np.zeros((len(turned), 2, 3))
        by_place[:, 0, 0] = by_place[:, 1, 1] = scale * larger
        by_place[:, :, 2] = scale * flat * (larger * seen.nearness)[:, None]
        turns = np.stack([np.cross(axis, turned) for axis in np.eye(3)], axis=2)
        slopes = np.empty((len(turned), 2, _POSE + len(state.face)))
        slopes[:, :, :3] = by_place @ turns
        slopes[:, :, 3] = scale * flat
        slopes[:, :, 4:6] = np.eye(2)
        slopes[:, :, 6] = scale * flat * (larger * turned[:, 2])[:, None] / 1000
        slopes[:, :, _POSE:] = by_place @ (seen.rotation @ self._moves)
        return slopes

    def _step(self, state: _State, error: Points, trust: Points) -> _State:
        """Improve pose and face together.

        The noise is a few components and a diagonal, so its inverse is Woodbury's.
        """
        seen, face = state.seen, state.face
        slopes = self._slopes(state)
        weight = (np.sqrt(trust) / (seen.px_per_mm * self._rest_mm))[:, None]
        rows = (weight[..., None] * slopes).reshape(-1, slopes.shape[2])
        wanted = (weight * error).ravel()
        together = seen.px_per_mm * self._noise @ tip_of(seen.rotation).T * weight
        noise = together.reshape(len(together), -1).T
        inner = np.eye(noise.shape[1]) + noise.T @ noise
        shared = rows.T @ noise
        hessian = rows.T @ rows - shared @ np.linalg.solve(inner, shared.T)
        gradient = rows.T @ wanted - shared @ np.linalg.solve(inner, noise.T @ wanted)
        own = np.arange(_POSE, len(gradient))
        hessian[own, own] += 1 / self._spread**2
        gradient[own] -= face / self._spread**2
        usual, spread = (1000 * part for part in _NEARNESS)
        hessian[6, 6] += 1 / spread**2
        gradient[6] += (usual - 1000 * seen.nearness) / spread**2
        low = np.concatenate([np.full(_POSE, -np.inf), self._low - face])
        high = np.concatenate([np.full(_POSE, np.inf), self._high - face])
        low[6], high[6] = (1000 * (limit - seen.nearness) for limit in _NEARNESS_LIMITS)
        return _moved(state, _solve_bounded(hessian, gradient, low, high))

    def _finished(self, state: _State, found: Points) -> Fit:
        n_shapes = len(state.face) - len(self.space.units)
        shapes, acting = state.face[:n_shapes], state.face[n_shapes:]
        error = np.linalg.norm(found - self._expected(state), axis=1) / state.seen.px_per_mm
        return Fit(
            rest=self.space.mean + self.space.components @ shapes,
            units=dict(zip(self.space.units, acting.tolist(), strict=True)),
            perspective=replace(state.seen, offset_mm=-state.seen.rotation @ self.origin),
            residual_mm=error,
            strangeness=float(np.sqrt(np.mean(shapes**2))),
        )


def _moved(state: _State, step: Points) -> _State:
    seen = state.seen
    return _State(
        Perspective(
            Rotation.from_rotvec(step[:3]).as_matrix() @ seen.rotation,
            seen.px_per_mm * float(np.exp(np.clip(step[3], -_LARGEST_ZOOM, _LARGEST_ZOOM))),
            seen.shift_px + step[4:6],
            seen.nearness + float(step[6]) / 1000,
            seen.offset_mm,
        ),
        state.face + step[_POSE:],
    )


def _solve_bounded(hessian: Points, gradient: Points, low: Points, high: Points) -> Points:
    """Minimise ``x'Hx / 2 - g'x`` within bounds: fix what leaves them, let go what wants back.

    Args:
        hessian: ``(n, n)``, positive definite.
        gradient: ``(n,)``.
        low: ``(n,)``, <= 0.
        high: ``(n,)``, >= 0.

    Example:
        >>> _solve_bounded(np.eye(2), np.array([3.0, 0.5]), np.full(2, -1.0), np.ones(2))
        array([1. , 0.5])
    """
    fixed, solution = np.zeros(len(gradient), bool), np.zeros(len(gradient))
    for _ in range(_ROUNDS):
        free = ~fixed
        pull = gradient[free] - hessian[np.ix_(free, fixed)] @ solution[fixed]
        solution[free] = np.linalg.solve(hessian[np.ix_(free, free)], pull)
        out = free & ((solution < low) | (solution > high))
        solution = np.clip(solution, low, high)
        slope = hessian @ solution - gradient
        back = fixed & (((solution <= low) & (slope < 0)) | ((solution >= high) & (slope > 0)))
        if not (out | back).any():
            break
        fixed = (fixed | out) & ~back
    return solution
