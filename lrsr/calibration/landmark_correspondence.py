"""How is ``landmark_correspondence.npz`` made? By ``python -m`` and the name of this module.

A landmark network is shown rendered people whose vertices are known. A point of the network is the
vertex whose projection lies nearest to it over all pictures; what remains is the network's noise.
Nobody's word is taken for what a point means, so any network with points can be calibrated so.
Renderings are kept in the cache: an interrupted call goes on.
"""

import argparse
import sys
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lrsr.calibration.landmark_views import View, plan_views, take_views
from lrsr.identities.face.template import template
from lrsr.identities.person import Person
from lrsr.identities.photographs.correspondence import ASSET_NAME, Correspondence, tip_of
from lrsr.identities.photographs.landmarker import Landmarker
from lrsr.identities.shape.basis import load_basis
from lrsr.identities.shape.build_basis import write
from lrsr.paths import PACKAGE, cache_folder
from lrsr.pictures.cache import RenderCache

_Points = NDArray[np.float64]

_FIRST, _PEOPLE = 5000, 24
"""Of the split "train"."""
_ROUNDS = 3
_OUTLIER = 3.0
"""_Points farther off than this many times their usual error do not count in the next round."""
_COMPONENTS = 50
_TURNED_DEG, _TURNED_WEIGHT = 20.0, 0.5
"""Views of more yaw count for less: half of their points are on the far side."""


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


def _measure(views: Iterable[View], landmarker: Landmarker) -> Correspondence:
    """Find a network's points on our mesh, and its noise.

    Args:
        views: Of many people.
        landmarker: The network.
    """
    chosen = _candidates()
    found, projected, poses = [], [], []
    for view in views:
        points = landmarker(np.ascontiguousarray(view.image.transpose(1, 2, 0)), view.landmarks_px)
        vertices = view.head.parts[0].vertices[chosen].astype(np.float64)
        up = np.array([1.0, -1.0]) / view.px_per_mm
        found.append(points.points_px * up)
        projected.append(view.project(vertices) * up)
        poses.append(view.pose)
    turned = np.array([abs(pose.yaw_deg) > _TURNED_DEG for pose in poses])
    weights = np.where(turned, _TURNED_WEIGHT, 1.0)
    nearest = _nearest_vertices(np.array(found), np.array(projected), weights)
    errors = [
        (points - vertices[nearest]) @ tip_of(pose.rotation())
        for points, vertices, pose in zip(found, projected, poses, strict=True)
    ]
    noise = _describe_noise(np.array(errors), _COMPONENTS)
    return Correspondence(chosen[nearest], *noise, network=landmarker.contract.sha256)


def main(argv: list[str] | None = None) -> int:
    """Write the asset; see the module."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cache", type=Path, default=None, help="folder of renderings")
    parser.add_argument("--out", type=Path, default=Path(PACKAGE) / "assets" / ASSET_NAME)
    arguments = parser.parse_args(argv)
    cache = RenderCache(arguments.cache or cache_folder())
    people = [Person("train", index) for index in range(_FIRST, _FIRST + _PEOPLE)]
    found = _measure(take_views(plan_views(people), cache), Landmarker())
    module = "python -m lrsr.calibration.landmark_correspondence"
    made_by = f"{module}, train {_FIRST} to {_FIRST + _PEOPLE - 1}"
    write(found.arrays(made_by), arguments.out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
