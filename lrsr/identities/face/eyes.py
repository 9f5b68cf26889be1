"""Where do the eyes look, and how are they curved? Eyeballs with corneas."""

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lrsr.identities.shape.basis import BaseHead, Basis

Points = NDArray[np.float64]

_GAZE_SHARE = np.array([0.35, 0.8, 0.0])
"""How far an eye turns from straight ahead to the centre of its lids, across and up: without it
many look up; sideways the lids open farther out than eyes look."""
_DIVERGENCE_SHARE = 0.4
"""How much of that turn across remains where it drives the eyes apart: both look at one camera."""
_CORNEA_ANGLE_RAD = 0.42
"""Angle from the axis at which the cornea rises from the white."""
_CORNEA_RISE = 0.06
"""Height of the cornea's apex over the sphere, in radii: with the angle above its radius of
curvature is 0.47 of the eyeball's, 7.8 mm for 16.6 mm, the mean cornea (Gullstrand)."""
_RINGS, _SEGMENTS = 24, 48
_CORNEAL_RINGS = 12


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
        """Centre of each pupil, on the sphere behind the cornea: ``(2, 3)``, mm."""
        return self.centres + self.radii[:, None] * self.gazes

    def surface_mm(self, which: int, offset: Points) -> Points:
        """How far the surface of an eye, cornea included, is from its centre in some directions.

        Args:
            which: 0 is the left one in the image, 1 the right one.
            offset: ``(n, 3)`` from its centre, mm; only the direction counts.

        Returns:
            ``(n,)``, mm.
        """
        length = np.maximum(np.linalg.norm(offset, axis=1), 1e-9)
        angle = np.arccos(np.clip(offset @ self.gazes[which] / length, -1, 1))
        return np.asarray(self.radii[which] * (1 + _cornea_rise(angle)))

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
    gazes = _GAZE_SHARE * (middle - centres)
    both = gazes.mean(axis=0)
    gazes[:, 0] = both[0] + _DIVERGENCE_SHARE * (gazes[:, 0] - both[0])
    gazes[:, 1] = both[1]
    gazes[:, 2] = np.sqrt(np.maximum(radii**2 - (gazes[:, :2] ** 2).sum(axis=1), 0.0))
    return Eyes(centres, radii, gazes / np.linalg.norm(gazes, axis=1, keepdims=True))


def _cornea_rise(angle: NDArray[Any]) -> NDArray[Any]:
    """Height of the eye's surface over the sphere.

    Args:
        angle: Any shape, from the optical axis, radians, >= 0.

    Returns:
        Same shape, in radii of the sphere: :data:`_CORNEA_RISE` on the axis, 0 beyond the cornea.

    Example:
        >>> _cornea_rise(np.array([0.0, 0.42, 1.0]))
        array([0.06, 0.  , 0.  ])
    """
    inside = np.clip(1 - (angle / _CORNEA_ANGLE_RAD) ** 2, 0, 1)
    return np.asarray(_CORNEA_RISE * inside**2)


class _Ball(NamedTuple):
    """The front half of an eye around +z: a unit sphere and the cornea on it.

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
def unit_ball() -> _Ball:
    """Return the mesh that every eyeball is a copy of."""
    cornea = np.linspace(0.0, _CORNEA_ANGLE_RAD, _CORNEAL_RINGS + 1)[1:]
    white = np.linspace(_CORNEA_ANGLE_RAD, np.pi / 2, _RINGS - _CORNEAL_RINGS + 1)[1:]
    polar, azimuth = np.meshgrid(
        np.concatenate([cornea, white]),
        np.linspace(0.0, 2 * np.pi, _SEGMENTS, endpoint=False),
        indexing="ij",
    )
    across = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1)
    points = np.concatenate([np.sin(polar)[..., None] * across, np.cos(polar)[..., None]], axis=-1)
    points *= 1 + _cornea_rise(polar)[..., None]
    uv = 0.5 + (polar / np.pi)[..., None] * across * [1.0, -1.0]
    index = 1 + np.arange(_RINGS * _SEGMENTS).reshape(_RINGS, _SEGMENTS)
    after = np.roll(index, -1, axis=1)
    cap = np.stack([np.zeros(_SEGMENTS, int), index[0], after[0]], axis=-1)
    quads = np.stack([index[:-1], index[1:], after[1:], after[:-1]], axis=-1).reshape(-1, 4)
    faces = np.concatenate([cap, quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    return _Ball(
        np.concatenate([[[0.0, 0.0, 1.0 + _CORNEA_RISE]], points.reshape(-1, 3)]),
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


def eye_chart(eyes: Eyes, which: int, points: ArrayLike) -> Points:
    """Tell where a point before the eye appears on its texture.

    Args:
        eyes: Both eyes.
        which: 0 is the left one in the image, 1 the right one.
        points: ``(..., 3)``, mm, in the axes of the eyes.

    Returns:
        ``(..., 2)`` radians: the angle from the gaze, across (x) and up (y).
    """
    offset = (np.asarray(points, dtype=np.float64) - eyes.centres[which]) @ rotation_to(
        eyes.gazes[which]
    )
    across = np.hypot(offset[..., 0], offset[..., 1])
    angle = np.arctan2(across, offset[..., 2])
    share = angle / np.maximum(across, 1e-9)
    return np.asarray(offset[..., :2] * share[..., None])
