"""How is ``face_space.npz`` made? ``python -m lrsr.identities.photographs.build_space``.

People are drawn as everybody is, their resting expressions left out. The principal components of
what the front of their faces does, rigid motion aside, become directions of the shape space. Run it
again when shapes change, and after it ``lrsr calibrate-reconstructor`` of the network that ships.
"""

import json
import sys
from pathlib import Path
from typing import cast

import numpy as np
from numpy.typing import NDArray

from lrsr.identities.face.lids import rest_lids
from lrsr.identities.face.template import template
from lrsr.identities.morphable import RECIPE_VERSION, sample_parameters
from lrsr.identities.photographs.space import ASSET_NAME, UNIT
from lrsr.identities.shape.anatomy import Anatomy, coefficients
from lrsr.identities.shape.basis import load_basis
from lrsr.identities.shape.build_basis import write
from lrsr.identities.splits import identity_seed
from lrsr.paths import PACKAGE

_Points = NDArray[np.float64]

_PEOPLE = 500
_FIRST = 500_000
"""Number of the first of them in the split "train"."""
_COMPONENTS = 100


def _draw_people(count: int, first: int = _FIRST) -> _Points:
    """Draw people's coefficients ``(count, K)``, faces at rest.

    Args:
        count: How many.
        first: Number of the first one in the split "train".
    """
    basis, rows = load_basis(), []
    for index in range(first, first + count):
        drawn = sample_parameters(identity_seed("train", index))
        traits = {trait: drawn[trait] for trait in ("masculinity", "age", "ancestry")}
        anatomy = cast("Anatomy", {**dict(drawn["anatomy"]), "expression": {}})
        weights = coefficients(basis.names, anatomy, **traits)
        rows.append(rest_lids(basis, weights, template().lids))
    return np.array(rows)


def _find_space(people: _Points, components: int) -> tuple[_Points, _Points]:
    """Return mean ``(K,)`` and components ``(K, components)`` of people's coefficients.

    Args:
        people: ``(n, K)``.
        components: How many, at most n - 1.
    """
    basis, mean = load_basis(), people.mean(axis=0)
    apart = (people - mean).T
    shaped = basis.shape(mean)
    points = shaped.skin - shaped.eyes.mean(axis=(0, 1))
    front = (points[:, 2] > -45) & (np.abs(points[:, 1] + 25) < 95)
    moved = (basis.fields @ apart).reshape(-1, 3, len(people))[: basis.n_skin][front]
    flat = moved.reshape(-1, len(people))
    axes = np.eye(3)
    shifts = [np.tile(axis, (front.sum(), 1)).ravel() for axis in axes]
    turns = [np.cross(axis, points[front]).ravel() for axis in axes]
    rigid, _ = np.linalg.qr(np.array([*shifts, *turns]).T)
    flat = flat - rigid @ (rigid.T @ flat)
    _, _, people_modes = np.linalg.svd(flat, full_matrices=False)
    return mean, apart @ people_modes[:components].T / np.sqrt(len(people) - 1)


def main() -> int:
    """Write the asset."""
    mean, components = _find_space(_draw_people(_PEOPLE), _COMPONENTS)
    provenance = {
        "people": f"{_PEOPLE} of train from {_FIRST}",
        "recipe": RECIPE_VERSION,
        "licence": "CC0-1.0",
        "made_by": "python -m lrsr.identities.photographs.build_space",
    }
    arrays = {
        "provenance": np.array(json.dumps(provenance)),
        "mean": mean.astype(np.float32),
        "components": np.rint(components / UNIT).astype(np.int16),
    }
    write(arrays, Path(PACKAGE) / "assets" / ASSET_NAME)
    return 0


if __name__ == "__main__":
    sys.exit(main())
