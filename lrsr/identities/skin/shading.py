"""Where is a face darker or lighter than its pigments and its mesh say? Folds, sockets, nostrils.

Lids, nostrils, lashes and folds of a real face are finer and deeper than a mesh, and light that
enters them comes out darker and redder. Photographs of people therefore carry smooth shading of 2
to 16 mm around eyes, nose and mouth, in any light, that bare pigments lack; networks trained on
faces look for it. Places, strengths and their spread between people are those that albedos of
photographs show beside ours (docs/people.md): logarithms of luminance against the cheeks, from
which what our own geometry shades in frontal light has been taken away.
"""

from itertools import pairwise
from typing import NamedTuple, TypedDict

import cv2
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from lrsr.identities.ramp import smoothstep
from lrsr.identities.skin.canvas import FloatMap
from lrsr.identities.skin.layout import Layout
from lrsr.identities.skin.regions import blob

_PERCENT = {
    53: (-10, -9, -8, -3, 0, 0, 0, 0),
    41: (-6, -9, -9, -9, -8, -6, 0, -2),
    29: (-11, -15, -9, 2, 5, -5, -7, -11),
    23: (-8, 1, 10, 28, 5, -7, -15, -12),
    17: (0, 20, 35, 30, 8, 3, -20, -14),
    11: (12, 4, -20, -34, -12, -29, -21, -15),
    5: (0, -18, -26, -41, -53, -57, -30, -11),
    -1: (4, -18, -36, -74, -70, -78, -54, -10),
    -7: (10, -25, -31, -12, -8, -15, -28, -5),
    -13: (9, -28, -14, -9, -17, -18, 4, -3),
    -25: (12, -6, 7, -3, -2, 5, 0, -6),
    -37: (20, -1, -3, 0, 19, 14, 4, 1),
    -43: (8, -15, -1, -31, 6, 9, 1, 6),
    -46: (-5, -20, -10, -36, -8, 4, -3, 8),
    -49: (-35, -50, -30, -39, -19, 0, -6, 9),
    -55: (-41, -29, -17, -27, -44, -12, -5, 12),
    -61: (-21, -13, -15, -15, -52, -15, 5, 9),
    -79: (14, -7, -8, 13, 1, -4, 5, 19),
    -91: (12, 19, 20, 14, -22, -25, 10, 10),
    -103: (0, 0, 0, 0, 0, 0, 0, 0),
}  # fmt: skip
"""Everybody's shading. Key: y on the template, mm. Values: every 8 mm from the midline outwards,
the logarithm of what luminance is multiplied by, times 100: mean of the albedos of 26 photographs
of 13 people minus that of ours, both sides averaged, less what brows and, at -46 and -49, nostrils
do; forehead and root of the nose by pictures of eight photographs beside ours (docs/people.md)."""
_STEP_MM = 8.0


class _Shade(NamedTuple):
    """A soft patch or line on both sides of the face, stronger in some people than in others.

    Attributes:
        path: |x|, y on the template, mm; a single point for a patch.
        size: Standard deviation across, mm.
        sd: Between people, of the logarithm of luminance where it is strongest.
        mean: Of what is too fine for :data:`_PERCENT`.
        foremost: Greatest z on the template, mm: what lies before it is no part of the place.
    """

    path: tuple[tuple[float, float], ...]
    size: float
    sd: float
    mean: float = 0.0
    foremost: float = np.inf


_SHADES = {
    "temple": _Shade(((53.0, 18.0), (54.0, 30.0)), 8.0, 0.10),
    "socket": _Shade(((23.0, 7.0), (38.0, 7.0)), 5.5, 0.28),
    "lid": _Shade(((27.0, 4.5), (34.0, 5.0), (38.0, 4.2)), 2.4, 0.24, -0.25),
    "lid_fold": _Shade(
        ((20.0, 1.5), (24.0, 5.6), (31.0, 7.8), (38.0, 6.8), (44.0, 2.5)), 1.0, 0.28, -0.25
    ),
    "lashes": _Shade(
        ((21.1, -2.3), (23.8, 1.1), (31.7, 2.9), (38.9, 2.3), (43.0, 0.9), (46.0, -1.5)),
        0.9,
        0.25,
        -0.20,
    ),
    "inner_corner": _Shade(((19.0, -1.0), (23.0, 0.0)), 4.0, 0.35),
    "outer_corner": _Shade(((44.0, -1.5),), 4.5, 0.27),
    "under_eye": _Shade(((20.0, -9.0), (26.0, -13.0), (38.0, -12.0)), 3.5, 0.14),
    "flank": _Shade(((9.0, 4.0), (8.5, -18.0)), 3.5, 0.14),
    "ridge": _Shade(((0.0, -8.0), (0.0, -30.0)), 3.0, 0.14),
    "tip": _Shade(((0.0, -37.5),), 4.5, 0.08),
    "nostril": _Shade(((7.5, -45.5), (11.5, -45.0)), 1.7, 0.30, -1.2, 20.5),
    "below_nose": _Shade(((0.0, -52.0), (9.0, -51.5)), 3.0, 0.18),
    "wing": _Shade(((17.5, -38.0), (21.0, -40.0), (23.2, -44.0), (22.0, -49.0)), 1.3, 0.25, -0.25),
    "nasolabial": _Shade(((24.0, -48.0), (30.0, -57.0), (33.5, -66.0)), 3.2, 0.22),
    "apple": _Shade(((34.0, -37.0),), 7.5, 0.13),
    "philtrum": _Shade(((0.0, -59.0), (10.0, -59.0)), 4.0, 0.10),
    "mouth_corner": _Shade(((26.8, -74.2),), 2.5, 0.32, -0.35),
    "mouth_line": _Shade(((0.0, -73.4), (13.0, -73.8), (25.0, -74.3)), 0.9, 0.25, -0.30),
    "marionette": _Shade(((34.0, -84.0), (37.0, -93.0)), 4.0, 0.18),
    "chin": _Shade(((0.0, -91.0), (20.0, -91.0)), 6.5, 0.13),
}

_BEARDLESS = -1.15
"""Of everybody's shading around the mouth, what a young woman has less: all of it, as women are a
little lighter there than the mesh says."""
_ASYMMETRY = 0.35
"""Of the spread between people, what a person's two sides differ by."""
_MIDLINE_MM = 6.0
_RED = np.array([0.86, 1.04, 1.14], dtype=np.float32)
"""Light that has met skin more than once is redder: the shares of the shading in each channel."""
_DEEPEST = np.float32(-1.6)
"""No skin is darker than a fifth of what lies open."""
_OCTAVES = ((34, 0.031), (70, 0.034), (140, 0.025))
"""Cells around the head, 14, 7 and 3.5 mm, and spread of the logarithm of luminance there."""

_FOLDED = (
    ((31.0, 2.0, 0.0), (13.0, 8.0, 25.0)),
    ((8.0, -44.0, 15.0), (13.0, 7.0, 20.0)),
    ((12.0, -75.0, 8.0), (17.0, 10.0, 25.0)),
)
"""Lids, nose and mouth, where albedos of photographs vary more than on plain skin, by _MORE."""
_MORE = 2.2


class Shading(TypedDict):
    """One person's shading.

    ``depth`` is the share of everybody's, ``left`` (the side of negative x) and ``right`` what is
    added to the logarithm of each place's luminance, ``unevenness`` the strength of what has no
    name. ``below_nose`` is how much more (below 0: less) of everybody's a person has around the
    mouth.
    """

    depth: float
    below_nose: float
    unevenness: float
    left: dict[str, float]
    right: dict[str, float]


def sample_shading(rng: Generator, *, masculinity: float, age: float) -> Shading:
    """Draw a person's shading.

    Args:
        rng: Source of randomness.
        masculinity: 0 (female) to 1 (male): most of those photographed were men, whose beards
            darken lips and chins even where they are shaven.
        age: 0 (25 years) to 1 (old): folds and sockets are deeper.

    Returns:
        Plain numbers.
    """
    depth, unevenness = (
        rng.normal(0.65 + 0.3 * masculinity + 0.3 * age, 0.15),
        np.exp(rng.normal(0.0, 0.25)),
    )
    left, right = dict[str, float](), dict[str, float]()
    for name, shade in _SHADES.items():
        strength, difference = shade.sd * rng.standard_normal(2)
        left[name] = float(shade.mean + strength - _ASYMMETRY * difference)
        right[name] = float(shade.mean + strength + _ASYMMETRY * difference)
    return {
        "depth": float(depth),
        "below_nose": _BEARDLESS * (1.0 - masculinity) * (1.0 - 0.5 * age),
        "unevenness": float(unevenness),
        "left": left,
        "right": right,
    }


class ShadingPainter:
    """Shades the skin of any number of people within one texture layout.

    Args:
        layout: The texture.
    """

    def __init__(self, layout: Layout) -> None:
        self._layout = layout
        position = layout.position[layout.face]
        self._maps = {name: _draw(shade, position) for name, shade in _SHADES.items()}
        self._right = np.asarray(
            smoothstep(-_MIDLINE_MM, _MIDLINE_MM, position[..., 0]), dtype=np.float32
        )
        self._cells = _cells(position)
        self._mean = _draw_mean(position) * layout.front
        bearded = smoothstep(-45.0, -54.0, position[..., 1])
        bearded *= 0.6 + 0.4 * smoothstep(30.0, 16.0, np.abs(position[..., 0]))
        self._below_nose = self._mean * bearded
        folded = sum(blob(position, centre, size) for centre, size in _FOLDED)
        self._uneven = layout.front * np.float32(1 + _MORE * np.minimum(folded, 1.0))

    def paint(self, albedo: FloatMap, shading: Shading, rng: Generator) -> None:
        """Shade one person's skin.

        Args:
            albedo: ``(H, W, 3)`` float32, linear sRGB reflectance, changed in place.
            shading: As :func:`sample_shading` draws it.
            rng: Source of randomness of the unevenness.
        """
        layout = self._layout
        total = np.float32(shading["unevenness"]) * self._unevenness(rng) * self._uneven
        total += np.float32(shading["depth"]) * self._mean
        total += np.float32(shading["depth"] * shading["below_nose"]) * self._below_nose
        for name, weight in self._maps.items():
            left, right = shading["left"][name], shading["right"][name]
            total[weight.box] += weight.values * (
                np.float32(left) + np.float32(right - left) * self._right[weight.box]
            )
        np.maximum(total, _DEEPEST, out=total)
        shade = cv2.merge([total * share for share in _RED])
        albedo[layout.face] *= np.exp(shade, out=shade)

    def _unevenness(self, rng: Generator) -> FloatMap:
        """Smooth noise of the logarithm of luminance."""
        height, width = _SHEET
        sheet = np.zeros(_SHEET, dtype=np.float32)
        for cells, sd in _OCTAVES:
            rows = cells * height // width
            grid = rng.standard_normal((rows, cells), dtype=np.float32) * np.float32(sd)
            sheet += cv2.resize(grid, (width, height), interpolation=cv2.INTER_CUBIC)
        return np.asarray(cv2.remap(sheet, self._cells, None, cv2.INTER_LINEAR))


class _Weight(NamedTuple):
    """A map that is zero outside a box."""

    box: tuple[slice, slice]
    values: FloatMap


_SHEET = (512, 640)


def _cells(position: FloatMap) -> FloatMap:
    """Azimuth around the head to columns, height to rows."""
    azimuth = np.arctan2(position[..., 0], position[..., 2] + np.float32(80.0))
    column = (azimuth / np.float32(2 * np.pi) + np.float32(0.5)) * (_SHEET[1] - 1)
    row = (np.float32(130.0) - position[..., 1]) / np.float32(340.0) * _SHEET[0]
    return np.stack([column, row], axis=-1).astype(np.float32)


def _draw_mean(position: FloatMap) -> FloatMap:
    """Interpolate :data:`_PERCENT`: above its first row that goes on, at its sides it fades out."""
    half = np.pad(np.array(list(_PERCENT.values()), dtype=np.float32) / 100, ((0, 0), (0, 1)))
    sheet = np.concatenate([half[:, :0:-1], half], axis=1)
    column = position[..., 0] / np.float32(_STEP_MM) + np.float32(half.shape[1] - 1)
    row = np.interp(-position[..., 1], [-y for y in _PERCENT], np.arange(len(_PERCENT)))
    mean = cv2.remap(sheet, column, row.astype(np.float32), cv2.INTER_CUBIC)
    return np.asarray(mean, dtype=np.float32)


def _draw(shade: _Shade, position: FloatMap) -> _Weight:
    """Draw a place: a Gaussian of the distance to its path."""
    path = np.array(shade.path, dtype=np.float32)
    x, y, z = np.abs(position[..., 0]), position[..., 1], position[..., 2]
    (left, bottom), (right, top) = path.min(axis=0), path.max(axis=0)
    reach = 3.1 * shade.size  # there a Gaussian is below 0.01
    near = (x > left - reach) & (x < right + reach) & (y > bottom - reach) & (y < top + reach)
    outer = _box(near & (z > -48.0))
    squares = _squared_distance(np.stack([x[outer], y[outer]], axis=-1), path)
    values = np.exp(-0.5 * squares / shade.size**2) * smoothstep(-48.0, -32.0, z[outer])
    if np.isfinite(shade.foremost):
        values = values * smoothstep(shade.foremost + 1.0, shade.foremost - 1.0, z[outer])
    inner = _box(values > 0.01)
    box = tuple(
        slice(around.start + own.start, around.start + own.stop)
        for around, own in zip(outer, inner, strict=True)
    )
    return _Weight((box[0], box[1]), np.ascontiguousarray(values[inner], dtype=np.float32))


def _box(mask: NDArray[np.bool_]) -> tuple[slice, slice]:
    """Return the rows and the columns between which a mask has anything."""
    rows, columns = (np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0))
    if not rows.size:
        return slice(0, 0), slice(0, 0)
    return slice(int(rows[0]), int(rows[-1]) + 1), slice(int(columns[0]), int(columns[-1]) + 1)


def _squared_distance(points: FloatMap, corners: NDArray[np.float32]) -> FloatMap:
    """Squared distance of every point to a polyline."""
    nearest = ((points - corners[0]) ** 2).sum(axis=-1)
    for begin, end in pairwise(corners):
        along = end - begin
        share = np.clip(((points - begin) @ along) / (along @ along), 0.0, 1.0)
        foot = begin + share[..., None] * along
        nearest = np.minimum(nearest, ((points - foot) ** 2).sum(axis=-1))
    return np.asarray(nearest, dtype=np.float32)
