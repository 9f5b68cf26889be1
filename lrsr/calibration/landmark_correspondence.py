"""Where are a network's points on our faces, and how wrong is it? ``lrsr calibrate-reconstructor``.

The network is shown rendered people whose vertices are known. A point of it is the vertex whose
projection lies nearest to it over all pictures; what remains is the network's noise. Nobody's word
is taken for what a point means, so any network of landmarks can be calibrated so, and any position
map, whose texels are landmarks.
"""

import logging
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lrsr.calibration.landmark_views import View, plan_views, take_views
from lrsr.configuration import number, require, whole_number
from lrsr.errors import InputError
from lrsr.files import write_json
from lrsr.identities.face.template import template
from lrsr.identities.person import Person
from lrsr.identities.photographs.correspondence import (
    Correspondence,
    correspondence_path,
    tip_of,
)
from lrsr.identities.photographs.landmarker import Landmarker
from lrsr.identities.shape.basis import load_basis
from lrsr.identities.shape.build_basis import write
from lrsr.paths import user_path
from lrsr.pictures.cache import RenderCache

if TYPE_CHECKING:
    from omegaconf import DictConfig

_Points = NDArray[np.float64]

_ROUNDS = 3
_OUTLIER = 3.0
"""Points farther off than this many times their usual error do not count in the next round."""
_PART = 2048
"""Points that are held against all vertices at once."""
_COMPONENTS = 50
_TURNED_DEG, _TURNED_WEIGHT = 20.0, 0.5
"""Views of more yaw count for less: half of their points are on the far side."""
_LEAST_PEOPLE, _LEAST_POINTS = 2, 20
_MIRROR = np.array([-1.0, 1.0, 1.0])
"""What x, y and z are multiplied by."""

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class Calibrating:
    """Which network is calibrated, and on whom.

    Attributes:
        model: An ONNX file with its contract beside it.
        count: How many people of the split "train" are rendered.
        start: Number of the first one.
        most_error_mm: Points that are farther from their vertex, root mean square, are dropped.
        most_points: How many of the others are kept, spread over the face.

    Raises:
        InputError: A number is out of its range, or the model or its contract cannot be used.
    """

    model: Path
    count: int
    start: int
    most_error_mm: float
    most_points: int

    def __post_init__(self) -> None:
        least = {"count": _LEAST_PEOPLE, "start": 0, "most_points": _LEAST_POINTS}
        for name, limit in least.items():
            value = getattr(self, name)
            require(value >= limit, name, value, f"at least {limit}")
        require(self.most_error_mm > 0, "most_error_mm", self.most_error_mm, "above 0")
        _ = self.landmarker

    @cached_property
    def landmarker(self) -> Landmarker:
        """The network.

        Raises:
            InputError: It or its contract cannot be used.
        """
        return Landmarker(self.model)

    @classmethod
    def from_config(cls, config: "DictConfig") -> Self:
        """Read a composed configuration of ``lrsr calibrate-reconstructor``.

        Raises:
            InputError: A value is wrong; the message names the setting and the remedy.
        """
        whole = {key: whole_number(config, key) for key in ("count", "start", "most_points")}
        model, most = user_path(config.model, "model"), number(config, "most_error_mm")
        return cls(model=model, most_error_mm=most, **whole)

    def run(self, folder: Path, cache: RenderCache) -> Path:
        """Write ``NAME.npz`` beside the model, and ``calibration.json`` into a folder.

        Renderings are kept in the cache: an interrupted call goes on.

        Args:
            folder: Where figures go.
            cache: Where renderings are kept.

        Raises:
            InputError: Hardly a point of the network follows a face, it cannot take its crops, or
                a file cannot be written.
        """
        people = [Person("train", self.start + index) for index in range(self.count)]
        views = take_views(plan_views(people), cache)
        found, figures = _measure(views, self.landmarker, self.most_error_mm, self.most_points)
        numbers = f"train {self.start} to {self.start + self.count - 1}"
        path = correspondence_path(self.model)
        write(found.arrays(f"lrsr calibrate-reconstructor, {numbers}"), path)
        write_json(folder / "calibration.json", figures | {"file": str(path)})
        logger.info(
            "%s: %d of %d points, %.1f mm from their vertices",
            path, figures["points_kept"], figures["points"], figures["error_mm"],
        )  # fmt: skip
        return folder


def _candidates() -> NDArray[np.int64]:
    """Return the vertices that a point may be: one at each place of the front of the face."""
    surface, points = load_basis().surface, template().skin
    face = np.zeros(len(points), bool)
    face[np.unique(surface.faces[surface.region == 0])] = True
    first = surface.twin == np.arange(len(points))
    near = (points[:, 2] > -75) & (points[:, 1] > -125) & (points[:, 1] < 75)
    return np.flatnonzero(face & first & near)


def _nearest_vertices(found: _Points, projected: _Points, weights: _Points) -> NDArray[np.int64]:
    """Choose for each point the vertex that lies nearest to it over all pictures.

    Args:
        found: ``(n, N, 2)`` points on n pictures, mm.
        projected: ``(n, V, 2)`` vertices on them, mm.
        weights: ``(n,)`` of the pictures.

    Returns:
        ``(N,)`` indices into V.
    """
    parts = range(0, found.shape[1], _PART)
    each = [_nearest_of_few(found[:, k : k + _PART], projected, weights) for k in parts]
    return np.concatenate(each)


def _nearest_of_few(found: _Points, projected: _Points, weights: _Points) -> NDArray[np.int64]:
    every = np.repeat(weights[:, None], found.shape[1], axis=1)
    for _ in range(_ROUNDS):
        # sum of w |l - v|^2 = sum of w |l|^2 - 2 w l.v + w |v|^2, of which the first is no choice
        both = np.einsum("nl,nlk,nvk->lv", every, found, projected, optimize=True)
        cost = every.T @ (projected**2).sum(axis=2) - 2 * both
        nearest = cost.argmin(axis=1)
        error = np.linalg.norm(found - projected[:, nearest], axis=2)
        usual = np.sqrt((every * error**2).sum(axis=0) / every.sum(axis=0))
        every = every * (error < _OUTLIER * usual)
    return np.asarray(nearest)


def _describe_noise(errors: _Points, components: int) -> tuple[_Points, _Points, float]:
    """Return the mean of errors, how they vary together, and the spread of what is left.

    Args:
        errors: ``(n, N, 2)``, mm.
        components: How many principal components are kept, < n.

    Returns:
        ``(N, 2)``, ``(components, N, 2)`` of one standard deviation each, and one number.
    """
    count, points, _ = errors.shape
    bias = errors.mean(axis=0)
    flat = (errors - bias).reshape(count, -1) / np.sqrt(count - 1)
    _, spread, axes = np.linalg.svd(flat, full_matrices=False)
    kept = spread[:components, None] * axes[:components]
    left = np.sqrt((spread[components:] ** 2).sum() / (2 * points))
    return bias, kept.reshape(components, points, 2), float(left)


def _spread_out(places: _Points, count: int) -> NDArray[np.int64]:
    """Choose places that lie far from each other; of equal ones the first.

    Args:
        places: ``(n, 3)``.
        count: How many at most.

    Returns:
        Their numbers, in order; all where they are few enough.

    Example:
        >>> _spread_out(np.array([[0.0], [0.0], [1.0], [9.0]]), 3)
        array([0, 2, 3])
    """
    if len(places) <= count:
        return np.arange(len(places))
    chosen, away = [0], np.full(len(places), np.inf)
    while len(chosen) < count:
        away = np.minimum(away, ((places - places[chosen[-1]]) ** 2).sum(axis=1))
        chosen.append(int(away.argmax()))
        if away[chosen[-1]] == 0:  # every place is taken
            chosen.pop()
            break
    return np.sort(chosen)


@dataclass(frozen=True, eq=False)
class _Observed:
    """What a network finds on pictures, and what is there; mm, x to the right and y up.

    Attributes:
        found: ``(pictures, N, 2)`` its points.
        projected: ``(pictures, V, 2)`` where vertices are that may be meant.
        turns: ``(pictures, 3, 3)`` of the heads.
    """

    found: _Points
    projected: _Points
    turns: _Points

    def with_mirror_images(self, points: NDArray[np.int64], vertices: NDArray[np.int64]) -> Self:
        """Add every picture as a mirror shows it.

        Args:
            points: ``(N,)`` which point each one becomes.
            vertices: ``(V,)`` which vertex each one becomes.
        """
        return type(self)(
            np.concatenate([self.found, self.found[:, points] * _MIRROR[:2]]),
            np.concatenate([self.projected, self.projected[:, vertices] * _MIRROR[:2]]),
            np.concatenate([self.turns, _MIRROR[:, None] * self.turns * _MIRROR]),
        )

    def weights(self) -> _Points:
        """Return what each picture counts for: ``(pictures,)``."""
        yaw_deg = np.degrees(np.arctan2(self.turns[:, 0, 2], self.turns[:, 2, 2]))
        return np.where(np.abs(yaw_deg) > _TURNED_DEG, _TURNED_WEIGHT, 1.0)

    def distances(self, nearest: NDArray[np.int64], weights: _Points) -> _Points:
        """Return how far each point is from its vertex, root mean square: ``(N,)``."""
        squares = [
            ((points - vertices[nearest]) ** 2).sum(axis=1)
            for points, vertices in zip(self.found, self.projected, strict=True)
        ]
        return np.asarray(np.sqrt(np.average(squares, axis=0, weights=weights)))

    def errors(self, kept: NDArray[np.int64], nearest: NDArray[np.int64]) -> _Points:
        """Return where points are from their vertices, of heads not tipped: ``(pictures, n, 2)``.

        Args:
            kept: ``(n,)`` which points.
            nearest: ``(n,)`` their vertices.
        """
        errors = [
            (points[kept] - vertices[nearest]) @ tip_of(turn)
            for points, vertices, turn in zip(self.found, self.projected, self.turns, strict=True)
        ]
        return np.array(errors)


def _observe(
    views: Iterable[View], landmarker: Landmarker, candidates: NDArray[np.int64]
) -> _Observed:
    """Show pictures to a network.

    Args:
        views: Of several people.
        landmarker: The network.
        candidates: ``(V,)`` render vertices that a point may mean.
    """
    found, projected, turns = [], [], []
    for view in views:
        points = landmarker(np.ascontiguousarray(view.image.transpose(1, 2, 0)), view.landmarks_px)
        vertices = view.head.parts[0].vertices[candidates].astype(np.float64)
        up = np.array([1.0, -1.0]) / view.px_per_mm
        found.append(points.points_px * up)
        projected.append(view.project(vertices) * up)
        turns.append(view.scene.pose.rotation())
    return _Observed(np.array(found), np.array(projected), np.array(turns))


def _measure(
    views: Iterable[View], landmarker: Landmarker, most_error_mm: float, most_points: int
) -> tuple[Correspondence, dict[str, Any]]:
    """Find a network's points on our mesh, and its noise.

    Args:
        views: Of several people.
        landmarker: The network.
        most_error_mm: See :class:`Calibrating`.
        most_points: See :class:`Calibrating`.

    Returns:
        What is to be known of the network, and figures: how many points it has, how many are kept,
        and the median over these of their distance from their vertices, root mean square.

    Raises:
        InputError: Fewer than 20 points are within that error of a vertex.
    """
    chosen = _candidates()
    seen = _observe(views, landmarker, chosen)
    pictures, mirror = len(seen.found), landmarker.contract.mirrored()
    if len(mirror):  # the network finds the same in a mirror, so half of what differs is chance
        seen = seen.with_mirror_images(mirror, _mirrored_vertices(template().skin[chosen]))
    weights = seen.weights()
    nearest = _nearest_vertices(seen.found, seen.projected, weights)
    off = seen.distances(nearest, weights)
    kept = _kept(off, template().skin[chosen[nearest]], most_error_mm, most_points)
    if len(kept) < _LEAST_POINTS:
        raise InputError(
            f"{landmarker.model}: {len(kept)} of {len(off)} points are within {most_error_mm:g} mm"
            f" of a vertex, at least {_LEAST_POINTS} are needed: mend crop and output of its"
            " contract, or raise most_error_mm"
        )
    nearest = nearest[kept]
    errors = seen.errors(kept, nearest)
    noise = _describe_noise(errors, min(_COMPONENTS, len(errors) - 1))
    network = landmarker.contract.sha256
    figures = {
        "points": len(off),
        "points_kept": len(kept),
        "error_mm": float(np.median(off[kept])),
        "pictures": pictures,
    }
    return Correspondence(kept, chosen[nearest], *noise, network=network), figures


def _mirrored_vertices(places: _Points) -> NDArray[np.int64]:
    """Return which vertex each one is in a mirror.

    Args:
        places: ``(V, 3)`` of a symmetric head.

    Example:
        >>> _mirrored_vertices(np.array([[-2.0, 1, 0], [0, 0, 0], [2, 1, 0]]))
        array([2, 1, 0])
    """
    return np.asarray(cKDTree(places).query(places * _MIRROR)[1])


def _kept(off: _Points, places: _Points, most_error_mm: float, most: int) -> NDArray[np.int64]:
    """Return which points are used: near enough to their vertices, and spread over the face."""
    best = np.argsort(off, kind="stable")
    best = best[off[best] <= most_error_mm]
    return np.sort(best[_spread_out(places[best], most)])
