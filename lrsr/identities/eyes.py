"""Where do the eyes look, and what closes around them? Eyeballs, lids that clear them, lashes."""

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lrsr.identities.basis import BaseHead, Basis

Points = NDArray[np.float64]

GAZE_SHARE = np.array([0.35, 0.8, 0.0])
"""How far an eye turns from straight ahead to the centre of its lids, across and up: without it
many look up; sideways the lids open farther out than eyes look."""
LID_CLEARANCE = 1.03
"""Skin of the lids stays outside this many radii of the eyeball."""
LID_REACH = 1.5
"""Skin farther than this many radii from the eye is no lid."""
RINGS, SEGMENTS = 24, 48
LASHES_PER_QUAD = 5
_LASH_WIDTH = 0.5
_LASH_LENGTH = 1.5


class Eyes(NamedTuple):
    """Both eyes of a head, left in the image first.

    Attributes:
        centres: ``(2, 3)``, mm.
        radii: ``(2,)``, mm.
        gazes: ``(2, 3)`` unit vectors from the centre to the pupil.
    """

    centres: Points
    radii: Points
    gazes: Points

    @property
    def pupils(self) -> Points:
        """Centre of each iris on the surface of the eye: ``(2, 3)``, mm."""
        return self.centres + self.radii[:, None] * self.gazes

    def moved(self, rotation: ArrayLike, origin: ArrayLike) -> "Eyes":
        """Return the eyes in another frame: ``rotation @ (point - origin)``."""
        turn = np.asarray(rotation).T
        return Eyes((self.centres - np.asarray(origin)) @ turn, self.radii, self.gazes @ turn)


def find_eyes(basis: Basis, head: BaseHead) -> Eyes:
    """Fit a sphere into each eyeball of the helper mesh and turn it to the middle of its lids.

    Args:
        basis: The shape space, for the rims of the lids.
        head: A coarse head of that space.

    Returns:
        Eyes in the axes of ``head``.
    """
    centres = head.eyes.mean(axis=1)
    radii = np.linalg.norm(head.eyes - centres[:, None], axis=2).mean(axis=1)
    middle = np.stack([head.skin[rim].mean(axis=0) for rim in basis.lid_rims])
    gazes = GAZE_SHARE * (middle - centres)
    gazes[:, 1] = gazes[:, 1].mean()
    gazes[:, 2] = np.sqrt(np.maximum(radii**2 - (gazes[:, :2] ** 2).sum(axis=1), 0.0))
    return Eyes(centres, radii, gazes / np.linalg.norm(gazes, axis=1, keepdims=True))


class Ball(NamedTuple):
    """The front half of a unit sphere around +z.

    Attributes:
        vertices: ``(V, 3)``.
        faces: ``(F, 3)`` int32, counter-clockwise from outside.
        uv: ``(V, 2)`` float32: azimuthal equidistant, the pole at (0.5, 0.5), the rim (90 degrees)
            on the inscribed circle, v downwards.
    """

    vertices: Points
    faces: NDArray[np.int32]
    uv: NDArray[np.float32]


@lru_cache(maxsize=1)
def unit_ball() -> Ball:
    """Return the mesh that every eyeball is a copy of."""
    polar, azimuth = np.meshgrid(
        np.linspace(0.0, np.pi / 2, RINGS + 1)[1:],
        np.linspace(0.0, 2 * np.pi, SEGMENTS, endpoint=False),
        indexing="ij",
    )
    across = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1)
    points = np.concatenate([np.sin(polar)[..., None] * across, np.cos(polar)[..., None]], axis=-1)
    uv = 0.5 + (polar / np.pi)[..., None] * across * [1.0, -1.0]
    index = 1 + np.arange(RINGS * SEGMENTS).reshape(RINGS, SEGMENTS)
    after = np.roll(index, -1, axis=1)
    cap = np.stack([np.zeros(SEGMENTS, int), index[0], after[0]], axis=-1)
    inner, outer = index[:-1].ravel(), index[1:].ravel()
    inner_after, outer_after = after[:-1].ravel(), after[1:].ravel()
    faces = np.concatenate(
        [
            cap,
            np.stack([inner, outer, outer_after], axis=-1),
            np.stack([inner, outer_after, inner_after], axis=-1),
        ]
    )
    return Ball(
        np.concatenate([[[0.0, 0.0, 1.0]], points.reshape(-1, 3)]),
        faces.astype(np.int32),
        np.concatenate([[[0.5, 0.5]], uv.reshape(-1, 2)]).astype(np.float32),
    )


def rotation_to(direction: ArrayLike) -> Points:
    """Return the smallest rotation that carries +z to a direction: ``(3, 3)``.

    Args:
        direction: ``(3,)`` unit vector, not -z.

    Example:
        >>> (rotation_to([1.0, 0.0, 0.0]) @ [0.0, 0.0, 1.0]).round(12).tolist()
        [1.0, 0.0, 0.0]
    """
    x, y, z = np.asarray(direction, dtype=np.float64)
    cross = np.array([[0.0, 0.0, x], [0.0, 0.0, y], [-x, -y, 0.0]])
    return np.asarray(np.eye(3) + cross + cross @ cross / (1.0 + z))


def eyeball_vertices(eyes: Eyes, which: int) -> NDArray[np.float32]:
    """Return one eyeball, turned to its gaze.

    Args:
        eyes: Both eyes, in head frame.
        which: 0 is the left one in the image, 1 the right one.

    Returns:
        ``(V, 3)`` float32, mm, in the order of :func:`unit_ball`.
    """
    turned = unit_ball().vertices @ rotation_to(eyes.gazes[which]).T
    return np.asarray(eyes.centres[which] + eyes.radii[which] * turned, dtype=np.float32)


@dataclass(frozen=True)
class Lids:
    """The skin around the eyes of the template.

    Attributes:
        vertices: Per eye, ``(n,)`` skin vertices within :data:`LID_REACH`.
        distances: Per eye, ``(n,)`` their distance from the eye's centre in radii.
    """

    vertices: tuple[NDArray[np.int64], NDArray[np.int64]]
    distances: tuple[Points, Points]


def find_lids(points: Points, eyes: Eyes) -> Lids:
    """Find the skin around the eyes of the template.

    Args:
        points: ``(V, 3)`` skin of the template, mm.
        eyes: Its eyes, in the same axes.

    Returns:
        Vertices and how far they are.
    """
    distances = [
        np.linalg.norm(points - centre, axis=1) / radius
        for centre, radius in zip(eyes.centres, eyes.radii, strict=True)
    ]
    near = [np.flatnonzero(d < LID_REACH) for d in distances]
    return Lids((near[0], near[1]), (distances[0][near[0]], distances[1][near[1]]))


def clear_lids(points: Points, eyes: Eyes, lids: Lids) -> Points:
    """Push the skin of the lids out of the eyeballs, and their rims into them.

    What is outside the eyeball of the template stays outside here, what dips into it there (the
    lids' rims and the sockets) dips in here, so the line where lid and eye meet is always the same
    row of the mesh.

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
        radius = eyes.radii[which]
        offset = points[index] - eyes.centres[which]
        distance = np.linalg.norm(offset, axis=1)
        least = radius * np.minimum(usual, LID_CLEARANCE)
        most = np.where(usual < 0.99, radius * np.maximum(usual, 0.985), np.inf)
        wanted = np.clip(distance, np.where(usual >= 1.0, least, 0.0), most)
        moved[index] = eyes.centres[which] + offset * (wanted / distance)[:, None]
    return moved


class LashMesh(NamedTuple):
    """Lashes as weighted sums of the lash strips' vertices.

    Attributes:
        indices: ``(3 n, 4)`` vertices of a strip.
        weights: ``(3 n, 4)``, may lie outside [0, 1]: lashes reach over the strip's first row.
        faces: ``(n, 3)`` int32.
    """

    indices: NDArray[np.int64]
    weights: Points
    faces: NDArray[np.int32]

    def place(self, strips: Points) -> NDArray[np.float32]:
        """Return the lashes of one head: ``(3 n, 3)`` float32."""
        corners = strips[self.indices]
        return np.asarray(np.einsum("nk,nkc->nc", self.weights, corners), dtype=np.float32)


def make_lashes(basis: Basis, template: BaseHead, eyes: Eyes) -> LashMesh:
    """Cut the lash strips into thin triangles: opaque hairs instead of a transparent sheet.

    Args:
        basis: The shape space, for the strips.
        template: Its neutral head.
        eyes: The template's eyes, in the same axes.

    Returns:
        Five lashes for every quad that stands on a lid, fixed for all heads.
    """
    quads = basis.lash_quads - basis.lash_quads.min()
    points = template.lashes
    side = (points[quads].mean(axis=1)[:, 0] > eyes.centres[:, 0].mean()).astype(int)
    distance = np.linalg.norm(points[quads] - eyes.centres[side][:, None], axis=2)
    root = np.argmin(distance + np.roll(distance, -1, axis=1), axis=1)
    turned = np.take_along_axis(quads, (root[:, None] + np.arange(4)) % 4, axis=1)
    standing = ~np.isin(turned[:, :2], turned[:, 2:]).any(axis=1)
    turned = turned[standing]
    along = (np.arange(LASHES_PER_QUAD) + 0.5) / LASHES_PER_QUAD
    half = 0.5 * _LASH_WIDTH / LASHES_PER_QUAD
    weights = []
    for middle in along:
        for a, b in ((middle - half, 0.0), (middle + half, 0.0), (middle, _LASH_LENGTH)):
            weights.append([(1 - a) * (1 - b), a * (1 - b), a * b, (1 - a) * b])
    n = len(turned) * LASHES_PER_QUAD
    return LashMesh(
        np.repeat(turned, 3 * LASHES_PER_QUAD, axis=0),
        np.tile(np.array(weights), (len(turned), 1)),
        np.arange(3 * n, dtype=np.int32).reshape(n, 3),
    )
