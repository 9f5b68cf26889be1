"""Where in a generator's latent space does an attribute change? At a plane, told by a linear SVM.

The normal of the plane between faces with much and with little of an attribute is a direction that
changes it (Shen et al., "Interpreting the latent space of GANs for semantic face editing", CVPR
2020). Colbois, de Freitas Pereira and Marcel ("On the use of automatically generated synthetic
image datasets for benchmarking face recognition", IJCB 2021) bring each identity to neutral values
of all attributes along such directions, then vary one at a time. Here a move is the shortest one
that brings the distances from **all** planes to what is wanted: normals are not orthogonal, so one
after the other each would undo some of those before.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save

from lrsr.configuration import require
from lrsr.errors import InputError
from lrsr.files import check_file, write_bytes

_Floats = NDArray[np.float64]

_FORMAT = 1
_NOTE = "boundaries"
_ARRAYS = ("normals", "offsets", "neutral", "spread")
_LEAST = 10
"""Faces in either class."""
_PARTS = 5
"""One face of so many is left out to see how well the others tell."""
_COST = 1.0
"""Of the SVM, for latents of standard deviation 1."""


@dataclass(frozen=True, eq=False)
class Boundaries:
    """A plane for each attribute.

    Attributes:
        names: Of the attributes.
        normals: ``(n, D)``, unit length, towards more of it.
        offsets: ``(n,)``: a latent's distance from a plane is ``normal @ latent + offset``.
        neutral: ``(n,)`` the median distance of neutral faces.
        spread: ``(n,)`` standard deviation of the distances of drawn faces.
        record: What they were learned from, in plain values.
    """

    names: tuple[str, ...]
    normals: _Floats
    offsets: _Floats
    neutral: _Floats
    spread: _Floats
    record: Mapping[str, Any]

    def distances(self, latents: NDArray[np.floating]) -> _Floats:
        """Return signed distances ``(N, n)`` of latents ``(N, D)`` from the planes."""
        return np.asarray(latents @ self.normals.T + self.offsets, dtype=np.float64)

    def moved(
        self, latents: NDArray[np.floating], increments: Mapping[str, float] | None = None
    ) -> NDArray[np.float32]:
        """Make faces neutral, but for some attributes.

        Args:
            latents: ``(N, D)``.
            increments: How far from neutral each of those is to be, in standard deviations of
                drawn faces.

        Returns:
            ``(N, D)``.
        """
        wanted = self.neutral.copy()
        for name, increment in (increments or {}).items():
            which = self.names.index(name)
            wanted[which] += increment * self.spread[which]
        steps = (wanted - self.distances(latents)) @ np.linalg.pinv(self.normals).T
        return np.asarray(latents + steps, dtype=np.float32)


def learn_boundaries(
    latents: NDArray[np.float32],
    scores: Mapping[str, NDArray[np.float64]],
    neutral: Mapping[str, float | None],
    share: float,
    record: Mapping[str, Any],
) -> Boundaries:
    """Learn a plane for each attribute.

    Args:
        latents: ``(N, D)`` of drawn faces.
        scores: ``(N,)`` how much each face has of each attribute; NaN: not known.
        neutral: Which score is neutral; None: the median one.
        share: Of the faces with the most and of those with the least that the plane is to part,
            and of those nearest to neutral, (0, 0.5].
        record: What the result is to say of the faces.

    Raises:
        InputError: Too few faces have a score, or they differ too little in it.
    """
    points = latents.astype(np.float64)
    planes = [
        _learn(points, scores[name], value, share, f"attributes.{name}")
        for name, value in neutral.items()
    ]
    normals, offsets, middles, told = zip(*planes, strict=True)
    return Boundaries(
        names=tuple(neutral),
        normals=np.stack(normals),
        offsets=np.array(offsets),
        neutral=np.array(middles),
        spread=np.std(points @ np.transpose(normals), axis=0),
        record=dict(record) | {"attributes": dict(zip(neutral, told, strict=True))},
    )


def _learn(
    points: _Floats, scores: _Floats, neutral: float | None, share: float, name: str
) -> tuple[_Floats, float, float, dict[str, Any]]:
    """Return normal, offset, the distance of neutral faces, and what is to be told.

    Raises:
        InputError: See :func:`learn_boundaries`.
    """
    known = np.flatnonzero(np.isfinite(scores))
    count = int(share * len(known))
    if count < _LEAST:
        raise InputError(
            f"{name}: {count} faces with the most of it are too few, of {len(known)} that have a"
            f" score; wanted {_LEAST}: more samples or a larger share"
        )
    order = known[np.argsort(scores[known], kind="stable")]
    low, high = order[:count], order[-count:]
    if not scores[high[0]] > scores[low[-1]]:
        raise InputError(
            f"{name}: {scores[low[-1]]:g} among the least and among the most of {len(known)} faces;"
            " leave it out, or give more samples or a smaller share"
        )
    both = np.concatenate([low, high])
    more = np.repeat([False, True], count)
    held = np.tile(np.arange(count) % _PARTS == 0, 2)
    normal, offset = _plane(points[both][~held], more[~held])
    right = (points[both][held] @ normal + offset > 0) == more[held]
    normal, offset = _plane(points[both], more)
    middle = float(np.median(scores[known])) if neutral is None else neutral
    nearest = known[np.argsort(np.abs(scores[known] - middle), kind="stable")[:count]]
    distances = points @ normal + offset
    told = {
        "faces": len(known),
        "least": [float(scores[low].min()), float(scores[low].max())],
        "most": [float(scores[high].min()), float(scores[high].max())],
        "neutral": middle,
        "held_out_right": float(right.mean()),
        "correlation": float(np.corrcoef(distances[known], scores[known])[0, 1]),
    }
    return normal, offset, float(np.median(distances[nearest])), told


def _plane(points: _Floats, more: NDArray[np.bool_]) -> tuple[_Floats, float]:
    """Return the unit normal and the offset of the plane that parts two classes."""
    from sklearn.svm import SVC  # takes a second

    middle, scale = points.mean(axis=0), float(points.std())
    machine = SVC(kernel="linear", C=_COST).fit((points - middle) / scale, more)
    normal = machine.coef_[0]
    length = float(np.linalg.norm(normal))
    offset = float(machine.intercept_[0]) * scale / length
    return normal / length, offset - float(middle @ normal) / length


def write_boundaries(path: Path, boundaries: Boundaries) -> None:
    """Write them as safetensors, whole or not at all."""
    arrays = {name: np.ascontiguousarray(getattr(boundaries, name)) for name in _ARRAYS}
    told = {"format": _FORMAT, "names": boundaries.names, "record": boundaries.record}
    # One note, not several: safetensors writes these in random order, and equal means equal bytes.
    write_bytes(path, save(arrays, {_NOTE: json.dumps(told)}))


def read_boundaries(path: Path, size: int) -> Boundaries:
    """Read what :func:`write_boundaries` wrote.

    Args:
        path: The file.
        size: Numbers of a latent.

    Raises:
        InputError: It is missing, none of ours, or of latents of another size.
    """
    try:
        with safe_open(check_file(path), framework="np") as file:
            told = json.loads((file.metadata() or {})[_NOTE])
            arrays = {name: file.get_tensor(name) for name in _ARRAYS}
        require(told["format"] == _FORMAT, "format", told["format"], str(_FORMAT))
        found = Boundaries(names=tuple(told["names"]), record=told["record"], **arrays)
    except (OSError, SafetensorError, KeyError, InputError, ValueError) as error:
        raise InputError(
            f"boundaries={path}: cannot be read ({error}); give those of lrsr generate"
        ) from error
    if found.normals.shape[-1] != size:
        raise InputError(
            f"boundaries={path}: {found.normals.shape[-1]} numbers a latent, the generator has"
            f" {size}; give boundaries that were learned from it"
        )
    return found
