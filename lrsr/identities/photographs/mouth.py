"""What is between parted lips? The photograph, on a sheet from lip to lip.

The skin goes on behind the lips for three rings of quads. The second one meets that of the other
lip half-way; the third is drawn back, and between its halves lies, unseen, the strip that closes
MakeHuman's mouth: in the texture it lies over the rings.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lrsr.identities.face.mouth import STRIP_QUADS, mouth_rings
from lrsr.identities.face.resting import RestingFace, acting_skin
from lrsr.identities.photographs.outlines import LIP_GAP
from lrsr.identities.photographs.shot import Shot, Texels
from lrsr.identities.shape.basis import load_basis
from lrsr.identities.shape.position_map import cover, fill_outside
from lrsr.identities.shape.topology import REGIONS

Map = NDArray[np.float32]
Points = NDArray[np.float64]

_PARTED_IPDS = 0.03
"""Least gap of lips that are not closed."""
_SHARES = (0.5, 1.0, 1.0)
"""How much of the way to where the lips' halves meet each ring has gone."""
_SLOPE = 0.3
"""How much farther back than aside the sheet leads from the lips,"""
_BEHIND_MM = 2.0
"""at most so much: deeper, lips would throw on it the shade that the photograph has already;"""
_DRAWN_BACK_MM = (0.0, 0.0, 0.5)
"""and how much farther each ring is drawn back: hardly, or the halves would turn from the light."""
_LIGHTEST = 0.95


def lips_are_parted(shot: Shot) -> bool:
    """Return whether teeth or the dark of the mouth are seen on a photograph."""
    upper, lower = shot.points_px[list(LIP_GAP)]
    return bool(np.linalg.norm(lower - upper) > _PARTED_IPDS * shot.ipd_px)


def skin_with_sheet(face: RestingFace, acting: Points) -> Points:
    """Return the skin of a face that acts, a sheet between its lips: ``(V, 3)``, mm, head frame.

    Args:
        face: At rest.
        acting: ``(K,)`` coefficients of what it does.
    """
    columns, across = _columns()
    coarse = (load_basis().shape(acting).skin - face.origin) @ face.rotation.T
    rim = coarse[columns[:, 0]]
    middle = (rim + across @ rim) / 2
    moved = np.zeros_like(coarse)
    gap = np.linalg.norm(middle - rim, axis=1)
    for ring, (share, drawn) in enumerate(zip(_SHARES, _DRAWN_BACK_MM, strict=True), start=1):
        goal = rim + share * (middle - rim)
        goal[:, 2] -= np.minimum(_SLOPE * share * gap, _BEHIND_MM) + drawn
        moved[columns[:, ring]] = goal - coarse[columns[:, ring]]
    return np.asarray(acting_skin(face, acting) + load_basis().surface.matrix @ moved)


def painted_faces() -> NDArray[np.int32]:
    """Return the triangles of the skin that have texels to themselves: all but the strip's."""
    faces = load_basis().surface.faces
    return faces[: -STRIP_QUADS * len(faces) // len(load_basis().quads)]


def paint_sheet(albedo: Map, shot: Shot, seen: Texels, gain: Map) -> Map:
    """Return a skin's albedo ``(S, S, 3)`` with the photograph on the sheet.

    Args:
        albedo: Of the skin.
        shot: The photograph.
        seen: What the texels of :func:`painted_faces` see of it, sheet included.
        gain: ``(3,)`` from light to reflectance.
    """
    box, mask = _island(len(albedo))
    colour = seen.sample(shot.linear)[box] * gain
    painted = albedo.copy()
    painted[box] = np.clip(fill_outside(colour.astype(np.float64), mask), 0.003, _LIGHTEST)
    return painted


class _Columns(NamedTuple):
    """Base vertices behind the lips.

    Attributes:
        vertices: ``(n, 4)`` from where the lips meet inwards.
        across: ``(n, n)`` from the first vertices to the places on the other lip that each one
            meets; rows sum to 1, and corners meet themselves.
    """

    vertices: NDArray[np.int64]
    across: Points


@lru_cache(maxsize=1)
def _columns() -> _Columns:
    basis, ring = load_basis(), mouth_rings()
    mouth = basis.quads[basis.region == REGIONS.index("mouth")][:-STRIP_QUADS]
    sides = np.concatenate([np.roll(mouth, -k, axis=1)[:, :2] for k in range(4)])
    rim = dict(sides[(ring[sides] == 0).all(axis=1)].tolist())
    sides = np.concatenate([sides, sides[:, ::-1]])
    inwards = dict(sides[ring[sides[:, 1]] == ring[sides[:, 0]] + 1].tolist())
    aside = basis.shape(basis.neutral).skin[:, 0]
    walk = [min(rim, key=lambda vertex: float(aside[vertex]))]  # from the corner on the left
    while len(walk) < len(rim):
        walk.append(rim[walk[-1]])
    steps = [walk]
    for _ in _SHARES:
        steps.append([inwards[vertex] for vertex in steps[-1]])
    x, order = aside[walk], np.arange(len(walk))
    other = int(np.argmax(x))
    lips = order[: other + 1], np.append(order[other:], 0)[::-1]
    across = np.zeros((len(walk), len(walk)))
    for one, opposite in (lips, lips[::-1]):
        for k in opposite:
            across[one, k] = np.interp(x[one], x[opposite], (opposite == k).astype(float))
    return _Columns(np.array(steps).T, across)


@lru_cache(maxsize=2)
def _island(size: int) -> tuple[tuple[slice, slice], NDArray[np.bool_]]:
    """Return rows and columns of the mouth in a texture, and its texels within them."""
    surface, faces = load_basis().surface, painted_faces()
    inside = faces[surface.region[: len(faces)] == REGIONS.index("mouth")]
    raster = cover(surface.uv, inside, size)
    mask = np.zeros((size, size), dtype=bool)
    mask[raster.row, raster.column] = True
    box = tuple(
        slice(max(0, int(part.min()) - 1), int(part.max()) + 2)
        for part in (raster.row, raster.column)
    )
    return (box[0], box[1]), mask[box[0], box[1]]
