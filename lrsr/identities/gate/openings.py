"""Do eyes, nose and mouth open as people's do? What skin covers of an iris, how noses gape."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lrsr.identities.face.eyes import Eyes, rotation_to
from lrsr.identities.face.lids import lid_margins
from lrsr.identities.face.mouth import STRIP_QUADS
from lrsr.identities.face.template import template
from lrsr.identities.gate.coarse import coarse_head, coarse_quads, normals
from lrsr.identities.shape.basis import load_basis
from lrsr.identities.shape.position_map import twice_area
from lrsr.identities.shape.subdivision import triangulate

Points = NDArray[np.float64]

_STEPS = 25
_ROOF = (9.5, -45.0, 16.5)
_ROOF_SIZE = (5.0, 2.2, 5.0)


class _EyeOpening(NamedTuple):
    """What shows of one eye.

    Attributes:
        iris_share: Visible share of the vertical diameter of the iris, from in front.
        pupil_free: Whether the middle of the pupil is seen.
        height_mm: Greatest distance of the two lids.
        crossed_mm: How far the margin of the upper lid passes below that of the lower.
    """

    iris_share: float
    pupil_free: bool
    height_mm: float
    crossed_mm: float


def _covered(points: Points, triangles: Points) -> NDArray[np.bool_]:
    """Tell which points are hidden from somebody far in front, at +z.

    Args:
        points: ``(n, 3)``.
        triangles: ``(m, 3, 3)`` corners.

    Returns:
        ``(n,)``: some triangle lies before the point.

    Example:
        >>> sheet = np.array([[[-1.0, -1.0, 1.0], [3.0, -1.0, 1.0], [-1.0, 3.0, 1.0]]])
        >>> _covered(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 2.0], [9.0, 0.0, 0.0]]), sheet).tolist()
        [True, False, False]
    """
    corners = triangles[..., :2].transpose(1, 2, 0)  # each (x and y, m)
    (left, bottom), (right, top) = np.minimum.reduce(corners), np.maximum.reduce(corners)
    x, y = points[:, :1], points[:, 1:2]
    near = (left <= x.max()) & (right >= x.min()) & (bottom <= y.max()) & (top >= y.min())
    near = np.flatnonzero(near)
    left, bottom, right, top = (edge[near] for edge in (left, bottom, right, top))
    over = (left <= x) & (x <= right)
    over &= (bottom <= y) & (y <= top)
    point, triangle = np.nonzero(over)
    p, (a, b, c) = points[point], np.take(triangles, near[triangle], axis=0).transpose(1, 0, 2)
    total = twice_area(a, b, c)
    total = np.where(np.abs(total) < 1e-12, np.inf, total)
    weights = [twice_area(b, c, p) / total, twice_area(c, a, p) / total]
    weights.append(1.0 - weights[0] - weights[1])
    inside = (np.minimum(np.minimum(*weights[:2]), weights[2]) >= 0.0) & np.isfinite(total)
    depth = sum(w * corner[:, 2] for w, corner in zip(weights, (a, b, c), strict=True))
    covered = np.zeros(len(points), bool)
    covered[point[inside & (depth > p[:, 2] + 1e-9)]] = True
    return covered


def measure_eyes(skin: Points, eyes: Eyes, iris_rad: float) -> tuple[_EyeOpening, _EyeOpening]:
    """Measure what the lids leave open, the left eye in the image first.

    Args:
        skin: ``(V, 3)`` render vertices, mm.
        eyes: In the same axes.
        iris_rad: Half angle of the iris, seen from the eyeball's centre.
    """
    both = []
    for which, (upper, lower) in enumerate(lid_margins(skin, eyes, template().lids)):
        hidden = _covered(
            _iris_line(eyes, which, iris_rad), np.take(skin, _lid_faces(which), axis=0)
        )
        both.append(
            _EyeOpening(
                iris_share=float(1.0 - hidden.mean()),
                pupil_free=not hidden[_STEPS // 2],
                height_mm=float(np.linalg.norm(upper - lower, axis=1).max()),
                crossed_mm=float(np.maximum(lower - upper, 0.0)[:, 1].max()),
            )
        )
    return both[0], both[1]


def _iris_line(eyes: Eyes, which: int, iris_rad: float) -> Points:
    """Points of the iris on the eyeball, from its lower edge through the pupil to the upper."""
    angle = np.linspace(-iris_rad, iris_rad, _STEPS)
    line = np.stack([np.zeros(_STEPS), np.sin(angle), np.cos(angle)], axis=1)
    turned = line @ rotation_to(eyes.gazes[which]).T
    return np.asarray(eyes.centres[which] + eyes.radii[which] * turned)


@lru_cache(maxsize=2)
def _lid_faces(which: int) -> NDArray[np.int64]:
    """Triangles that could hide the iris of an eye: near a vertical through the pupil."""
    average, faces = template(), coarse_head().faces
    x, z = average.skin[:, 0], average.skin[:, 2]
    near = (np.abs(x - average.eyes.pupils[which, 0]) < 4.0) & (z > -14.0)
    near &= np.isin(np.arange(len(x)), average.lids.vertices[which])
    return np.asarray(faces[near[faces].any(axis=1)])


def nostril_area_mm2(skin: Points) -> float:
    """Return how much of the roofs of both nostrils is seen from straight in front, mm^2.

    Args:
        skin: ``(V, 3)`` render vertices, mm.
    """
    roof, around = _nostril_faces()
    return _seen_area_mm2(np.take(skin, roof, axis=0), np.take(skin, around, axis=0))


@lru_cache(maxsize=1)
def _nostril_faces() -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Triangles of the roofs of the nostrils, and those of the nose that could hide them."""
    head = coarse_head()
    x, y, z = head.folded()
    downwards = head.across[:, 1] < -0.5 * np.linalg.norm(head.across, axis=1)
    offset = np.stack([x, y, z], axis=1) - _ROOF
    roof = ((offset / _ROOF_SIZE) ** 2).sum(axis=1) < 1.0
    around = (y < -38.0) & (y > -50.0) & (x < 16.0) & (z > 16.0) & (head.across[:, 2] > 0)
    return head.faces[roof & downwards], head.faces[around]


def mouth_area_mm2(skin: Points) -> float:
    """Return how much of what closes the mouth behind the lips is seen from straight in front.

    Closed lips hide all of it; lips that turn inside out bring it before them.

    Args:
        skin: ``(V, 3)`` render vertices of a face at rest, before its mouth is hollowed, mm.

    Returns:
        mm^2.
    """
    strip, around = _mouth_faces()
    return _seen_area_mm2(np.take(skin, strip, axis=0), np.take(skin, around, axis=0))


@lru_cache(maxsize=1)
def _mouth_faces() -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Triangles of the strip that closes the mouth, and those of the lips that should hide it."""
    quads = coarse_quads()
    n_strip = STRIP_QUADS * len(quads) // len(load_basis().quads)
    strip, lips = triangulate(quads[-n_strip:]), triangulate(quads[:-n_strip])
    centre = template().skin[lips].mean(axis=1)
    near = (np.abs(centre[:, 0]) < 34.0) & (np.abs(centre[:, 1] + 73.0) < 19.0)
    return strip, lips[near & (centre[:, 2] > -12.0)]


def _seen_area_mm2(corners: Points, before: Points) -> float:
    """Add up those triangles that face the camera and have nothing before their middle.

    Args:
        corners: ``(n, 3, 3)``, mm.
        before: ``(m, 3, 3)``, mm, of what may hide them.
    """
    across = normals(corners)
    facing = np.flatnonzero(across[:, 2] > 0.0)
    if not facing.size:
        return 0.0
    hidden = _covered(corners[facing].mean(axis=1), before)
    return float(0.5 * across[facing[~hidden], 2].sum())
