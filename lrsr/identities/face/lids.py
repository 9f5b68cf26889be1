"""What closes around the eyes? Lids that clear the eyeballs, their margins, how far they open."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lrsr.identities.face.eyes import Eyes, find_eyes
from lrsr.identities.shape.basis import Basis

Points = NDArray[np.float64]

_CLEARANCE = 1.03
"""Skin of the lids stays outside this many radii of the eyeball."""
_REACH = 1.5
"""Skin farther than this many radii from the eye is no lid."""
_MARGIN_POINTS = 32
"""Points along the margin of each lid."""

BLINKS = ("eyeBlinkRight", "eyeBlinkLeft")
"""Units that close the eyes, left in the image first."""

_MARGIN = 0.995  # where lid and eye meet on the template, in radii
_FRONT = 0.4  # the margin lies before this, in radii: behind it skin and sphere meet again
_RANGE_MM = (2.7, 4.6)
"""How high the upper lid of a resting eye stands over the pupil, mm: in photographs it covers 18 %
of the iris, which leaves 3.6 mm; below 2.5 mm a lid droops, above 5.5 mm it is retracted."""
_SOFTNESS_MM = 0.6
_OVERLAP_MM = 0.8  # of the lids of a closed eye, above and below the pupil
_PUPIL_MM = 4.0  # the lid is measured above the pupil and this far to its sides


@dataclass(frozen=True)
class Lids:
    """The skin around the eyes of the template.

    Attributes:
        vertices: Per eye, ``(n,)`` skin vertices within :data:`_REACH`.
        distances: Per eye, ``(n,)`` their distance from the eye's centre in radii.
        margins: Per eye, the upper and the lower lid: ``(k, 2)`` edges of the mesh that cross the
            eyeball, the outer vertex last, from the inner corner to the outer.
    """

    vertices: tuple[NDArray[np.int64], NDArray[np.int64]]
    distances: tuple[Points, Points]
    margins: tuple[tuple[NDArray[np.int64], NDArray[np.int64]], ...]


def find_lids(points: Points, eyes: Eyes, faces: NDArray[np.int32]) -> Lids:
    """Find the skin around the eyes of the template.

    Args:
        points: ``(V, 3)`` skin of the template, mm.
        eyes: Its eyes, in the same axes.
        faces: ``(F, 3)``, its triangles.

    Returns:
        Vertices and how far they are.
    """
    distances = [
        np.linalg.norm(points - centre, axis=1) / radius
        for centre, radius in zip(eyes.centres, eyes.radii, strict=True)
    ]
    near = [np.flatnonzero(d < _REACH) for d in distances]
    margins = tuple(_find_margins(points, faces, distances[which], eyes, which) for which in (0, 1))
    return Lids((near[0], near[1]), (distances[0][near[0]], distances[1][near[1]]), margins)


def _find_margins(
    points: Points, faces: NDArray[np.int32], distance: Points, eyes: Eyes, which: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Order the edges that cross the eyeball along the upper and the lower lid."""
    sides = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    inside = distance < _MARGIN
    sides = np.unique(sides[inside[sides[:, 0]] != inside[sides[:, 1]]], axis=0).astype(np.int64)
    middle = points[sides].mean(axis=1) - eyes.centres[which]
    before = (middle[:, 2] > _FRONT * eyes.radii[which]) & (distance[sides] < _REACH).all(axis=1)
    sides, middle = sides[before], middle[before]
    sides = np.where(inside[sides[:, :1]], sides, sides[:, ::-1])
    across = middle[:, 0] * (1 if eyes.centres[which, 0] > 0 else -1)
    inner, outer = across.argmin(), across.argmax()
    line = middle[inner, 1] + (middle[outer, 1] - middle[inner, 1]) * (across - across[inner]) / (
        across[outer] - across[inner]
    )
    order = np.argsort(across)
    sides, above, below = sides[order], (middle[:, 1] >= line)[order], (middle[:, 1] <= line)[order]
    return sides[above], sides[below]


def lid_margins(points: Points, eyes: Eyes, lids: Lids) -> Points:
    """Follow the lines along which lids and eyes meet.

    Args:
        points: ``(V, 3)`` skin, mm.
        eyes: The eyes, in the same axes.
        lids: As :func:`find_lids` found them on the template, with margins.

    Returns:
        ``(2, 2, MARGIN_POINTS, 3)``, mm: per eye the upper and the lower lid, from the inner
        corner to the outer, evenly spaced.
    """
    margins = np.zeros((2, 2, _MARGIN_POINTS, 3))
    for which in (0, 1):
        for lid in (0, 1):
            margins[which, lid] = _even(_margin(points, eyes, lids, which, lid))
    return margins


def _margin(points: Points, eyes: Eyes, lids: Lids, which: int, lid: int) -> Points:
    """Find where each edge of a margin crosses the eyeball: ``(k, 3)``."""
    edges = lids.margins[which][lid]
    offset = points[edges] - eyes.centres[which]
    distance = np.linalg.norm(offset, axis=2) / eyes.radii[which]
    rise = np.maximum(distance[:, 1] - distance[:, 0], 1e-6)
    share = np.clip((1.0 - distance[:, 0]) / rise, 0.0, 1.0)
    return np.asarray(points[edges[:, 0]] + share[:, None] * (offset[:, 1] - offset[:, 0]))


def _even(line: Points) -> Points:
    """Space a line's points evenly; single edges stray, so groups of them are averaged."""
    count = max(4, len(line) // 4)
    size, larger = divmod(len(line), count)  # as numpy.array_split has it
    sizes = np.where(np.arange(count) < larger, size + 1, size)
    means = np.add.reduceat(line, np.cumsum(sizes) - sizes, axis=0) / sizes[:, None]
    knots = np.concatenate([line[:1], means, line[-1:]])
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(knots, axis=0), axis=1))])
    wanted = np.linspace(0.0, along[-1], _MARGIN_POINTS)
    return np.stack([np.interp(wanted, along, knots[:, k]) for k in range(3)], axis=-1)


def clear_lids(points: Points, eyes: Eyes, lids: Lids) -> Points:
    """Push the skin of the lids out of the eyeballs, and their rims into them.

    What is outside the eyeball of the template stays outside here, what dips into it there (the
    lids' rims and the sockets) dips in here, so the line where lid and eye meet is always the same
    row of the mesh. The cornea lifts the lid that lies on it.

    Args:
        points: ``(V, 3)`` skin, mm.
        eyes: The eyes, in the same axes.
        lids: As :func:`find_lids` found them on the template.

    Returns:
        A new array.
    """
    moved = points.copy()
    for which in (0, 1):
        index, usual = lids.vertices[which], lids.distances[which]
        offset = points[index] - eyes.centres[which]
        distance = np.linalg.norm(offset, axis=1)
        radius = eyes.surface_mm(which, offset)
        least = radius * np.minimum(usual, _CLEARANCE)
        most = np.where(usual < 0.99, radius * np.maximum(usual, 0.985), np.inf)
        wanted = np.clip(distance, np.where(usual >= 1.0, least, 0.0), most)
        moved[index] = eyes.centres[which] + offset * (wanted / distance)[:, None]
    return moved


def _lid_heights(basis: Basis, weights: Points, lids: Lids) -> Points:
    """Measure how high each upper lid stands over its pupil.

    Args:
        basis: The shape space.
        weights: ``(K,)`` coefficients.
        lids: As :func:`find_lids` found them on the template, with margins.

    Returns:
        ``(2,)``, mm, left in the image first.
    """
    points, eyes = _shaped(basis, weights, lids)
    heights = []
    for which, pupil in enumerate(eyes.pupils):
        offset = _margin(points, eyes, lids, which, 0) - pupil
        heights.append(offset[np.abs(offset[:, 0]) < _PUPIL_MM, 1].max(initial=-np.inf))
    return np.asarray(np.nan_to_num(heights, neginf=sum(_RANGE_MM) / 2))


def _shaped(basis: Basis, weights: Points, lids: Lids) -> tuple[Points, Eyes]:
    """Shape the eyes, and of the skin the margins of the lids alone; the rest is 0."""
    head, matrix = basis.shape(weights), basis.surface.matrix
    rows = np.unique(np.concatenate([lid.ravel() for both in lids.margins for lid in both]))
    points = np.zeros((matrix.shape[0], 3))
    points[rows] = matrix[rows] @ head.skin
    return points, find_eyes(basis, head)


def closing_strengths(basis: Basis, weights: Points, lids: Lids) -> Points:
    """Find how strong the units "eyeBlinkRight" and "eyeBlinkLeft" must be to close the eyes.

    Args:
        basis: The shape space, with both units.
        weights: ``(K,)`` coefficients of a face at rest.
        lids: As :func:`find_lids` found them on the template, with margins.

    Returns:
        ``(2,)``, left in the image first; 1, or more for eyes that are larger than MakeHuman's.
    """
    gaps = []
    for strength in (1.0, 1.2):
        closed = weights.copy()
        closed[blink_columns(basis)] = strength
        margins = lid_margins(*_shaped(basis, closed, lids), lids)
        apart = margins[:, 0, :, 1] - margins[:, 1, :, 1]
        gaps.append(apart[:, _MARGIN_POINTS // 3 : -(_MARGIN_POINTS // 3)].max(axis=1))
    travel = np.maximum(gaps[0] - gaps[1], 1.0) / 0.2
    return np.asarray(1.0 + np.clip((gaps[0] + _OVERLAP_MM) / travel, 0.0, 1.0))


def blink_columns(basis: Basis) -> list[int]:
    """Return the places of :data:`BLINKS` among the coefficients."""
    return [basis.column[f"unit/{unit}"] for unit in BLINKS]


def rest_lids(basis: Basis, weights: Points, lids: Lids) -> Points:
    """Lower startled lids and raise drooping ones to where those of a resting adult stand.

    Differences between people remain: heights beyond the usual range are drawn in softly.

    Args:
        basis: The shape space, with the units "eyeBlinkLeft" and "eyeBlinkRight".
        weights: ``(K,)`` coefficients of a face at rest.
        lids: As :func:`find_lids` found them on the template, with margins.

    Returns:
        Coefficients of the same face with other strengths of the two units.
    """
    units = blink_columns(basis)
    closed = weights.copy()
    closed[units] += 0.2
    heights = _lid_heights(basis, weights, lids)
    travel = (heights - _lid_heights(basis, closed, lids)) / 0.2
    low, high = _RANGE_MM
    middle, half = (low + high) / 2, (high - low) / 2
    offset = heights - middle
    beyond = np.maximum(np.abs(offset) - (half - _SOFTNESS_MM), 0.0)
    drawn = np.abs(offset) - beyond + _SOFTNESS_MM * np.tanh(beyond / _SOFTNESS_MM)
    lowered = offset - np.sign(offset) * drawn
    rested = weights.copy()
    rested[units] += np.clip(lowered / np.maximum(travel, 1.0), -0.45, 0.5)
    return rested
