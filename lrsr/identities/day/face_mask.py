"""How does a surgical mask sit on this face? Taut over nose and chin, edged to nose and cheeks.

The cloth is a sheet around a vertical axis within the head. Where the face is hollow it spans what
stands out, as the convex hull of the skin does; at its upper edge a wire bends it to the nose.
"""

from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, gaussian_filter1d

from lrsr.identities.day.fit import Fit, relief
from lrsr.identities.day.mesh import Mesh, Points, join, sheet, tube
from lrsr.identities.head import Part
from lrsr.identities.ramp import smoothstep

_COLOURS = {
    "blue": (0.30, 0.52, 0.66),
    "white": (0.72, 0.73, 0.73),
    "black": (0.017, 0.017, 0.018),
    "green": (0.33, 0.55, 0.47),
}
_AXIS_Z_MM = -72.0
_HALF_DEG = 66.0
_COLUMNS, _ROWS = 61, 49
_OFF_MM = 2.2
_CLEAR_MM = 1.0
_PLEATS = 3


def sample_face_mask(rng: Generator) -> dict[str, Any]:
    """Draw a mask: its colour by name, and where it begins between pupils (0) and nose tip (1)."""
    return {
        "colour": str(rng.choice(list(_COLOURS), p=[0.5, 0.2, 0.22, 0.08])),
        "top": float(rng.uniform(0.34, 0.52)),
    }


def build_face_mask(mask: dict[str, Any], fit: Fit, landmarks: Points) -> Part:
    """Make the part "face_mask", of the same faces for everybody.

    Args:
        mask: As :func:`sample_face_mask` draws it.
        fit: Of the head, as it acts.
        landmarks: ``(5, 3)`` of the head, mm.
    """
    azimuth = np.linspace(-_HALF_DEG, _HALF_DEG, _COLUMNS)
    top, bottom = _edges(mask, fit, landmarks, azimuth)
    share = np.linspace(0.0, 1.0, _ROWS)[:, None]
    height = top + share * (bottom - top)
    skin = _skin_radius(fit, azimuth, height)
    radius = _taut(skin, height, azimuth)
    pleats = 0.9 * np.sin(np.pi * np.clip((share - 0.2) / 0.6, 0, 1)) * _sawtooth(share)
    inner = smoothstep(_HALF_DEG, _HALF_DEG - 12.0, np.abs(azimuth))
    radius = np.maximum(radius + _OFF_MM + pleats * inner, skin + _CLEAR_MM)
    cloth = _place(azimuth, height, radius)
    mesh = join([sheet(cloth), *_loops(cloth, fit)])
    albedo = np.broadcast_to(np.asarray(_COLOURS[mask["colour"]], np.float32), (4, 4, 3)).copy()
    return Part(
        "face_mask",
        "cloth",
        mesh.vertices.astype(np.float32),
        mesh.faces.astype(np.int32),
        mesh.uv.astype(np.float32),
        albedo,
    )


def _edges(
    mask: dict[str, Any], fit: Fit, landmarks: Points, azimuth: Points
) -> tuple[Points, Points]:
    """Return heights of the upper and the lower edge, mm, at each azimuth."""
    mouth = float(landmarks[3:, 1].mean())
    nose = float(landmarks[2, 1])
    chin = _chin_height(fit, mouth)
    away = np.abs(azimuth)
    bridge = mask["top"] * nose
    top = np.interp(away, [0, 8, 22, 45, _HALF_DEG], [0, -1.5, -10.0, -14.0, -20.0]) + bridge
    middle = 0.55 * mouth + 0.45 * chin
    bottom = np.interp(
        away, [0, 18, 40, _HALF_DEG], [chin - 7, chin - 5, 0.5 * (chin + middle), middle]
    )
    return gaussian_filter1d(top, 1.5), gaussian_filter1d(bottom, 3.0)


def _chin_height(fit: Fit, mouth: float) -> float:
    """Return the height of the chin's lowest point: below it the face falls back to the neck."""
    y = np.arange(mouth - 25.0, mouth - 75.0, -1.0)
    reach = fit.front.at(np.zeros_like(y), y)
    far = reach.max()
    fallen = np.flatnonzero(reach < far - 14.0)
    return float(y[fallen[0]] if len(fallen) else y[-1])


def _skin_radius(fit: Fit, azimuth: Points, height: Points) -> Points:
    """Return how far skin is from the axis at each azimuth and height, mm."""
    offset = fit.skin[~fit.is_ear & (fit.skin[:, 2] > _AXIS_Z_MM - 30.0)]
    angle = np.rad2deg(np.arctan2(offset[:, 0], offset[:, 2] - _AXIS_Z_MM))
    reach = np.hypot(offset[:, 0], offset[:, 2] - _AXIS_Z_MM)
    return relief(np.stack([angle, offset[:, 1]], axis=1), reach, (-90, -190), (90, 60)).at(
        np.broadcast_to(azimuth, height.shape), height
    )


def _taut(skin: Points, height: Points, azimuth: Points) -> Points:
    """Span what stands out, along and across; near the upper edge only half as much."""
    angle = np.deg2rad(azimuth)
    across = np.stack([_convex_radius(row, angle) for row in skin])
    along = np.stack(
        [_hull(-h, r) for h, r in zip(height.T, np.maximum(across, skin).T, strict=True)], axis=1
    )
    rows = np.linspace(0.0, 1.0, len(skin))[:, None]
    spanned = smoothstep(0.0, 0.22, rows)
    spanning = skin + spanned * (along - skin)
    return np.asarray(gaussian_filter(spanning, (1.2, 1.2), mode="nearest"))


def _convex_radius(radius: Points, angle: Points) -> Points:
    """Return the radius of the convex hull of a curve about the axis."""
    points = np.stack([radius * np.sin(angle), radius * np.cos(angle)], axis=1)
    kept = _upper(points)
    x, z = points[kept].T
    along = np.interp(np.arange(len(angle)), kept, np.arange(len(kept)))
    first = np.minimum(along.astype(int), len(kept) - 2)
    ax, az, bx, bz = x[first], z[first], x[first + 1], z[first + 1]
    sine, cosine = np.sin(angle), np.cos(angle)  # the ray meets the chord
    return np.asarray((ax * bz - az * bx) / (sine * (bz - az) - cosine * (bx - ax)))


def _hull(place: Points, value: Points) -> Points:
    """Return the least concave function above values at increasing places."""
    kept = _upper(np.stack([place, value], axis=1))
    return np.asarray(np.interp(place, place[kept], value[kept]))


def _upper(points: Points) -> NDArray[np.int64]:
    """Return which points, from left to right, are corners of the upper convex hull."""
    kept: list[int] = []
    for k, (x, y) in enumerate(points):
        while len(kept) > 1:
            (ax, ay), (bx, by) = points[kept[-2]], points[kept[-1]]
            if (bx - ax) * (y - ay) - (by - ay) * (x - ax) < 0:
                break
            kept.pop()
        kept.append(k)
    return np.array(kept)


def _sawtooth(share: Points) -> Points:
    """Folds that open downwards."""
    return np.asarray(1.0 - 2.0 * ((share * (_PLEATS + 2)) % 1.0))


def _place(azimuth: Points, height: Points, radius: Points) -> Points:
    a = np.deg2rad(azimuth)
    return np.stack([radius * np.sin(a), height, _AXIS_Z_MM + radius * np.cos(a)], axis=-1)


def _loops(cloth: Points, fit: Fit) -> list[Mesh]:
    """Elastic strings from the corners of the cloth to above and below the ears."""
    strings = []
    for sign, column in ((-1, 0), (1, -1)):
        top, _, lobe = fit.ear(sign)
        side = fit.side(sign)
        above = np.array([sign * (side.at(top[2], top[1])[0] + 0.5), top[1] - 2.0, top[2] - 4.0])
        under = lobe - [sign * 4.0, -3.0, 6.0]
        for corner, end in ((cloth[2, column], above), (cloth[-3, column], under)):
            share = np.linspace(0.0, 1.0, 20)
            path = corner + share[:, None] * (end - corner)
            beside = side.at(path[:, 2], path[:, 1]) + 0.9
            clear = np.minimum(beside, np.abs(corner[0]) + 12.0) * smoothstep(1.0, 0.75, share)
            path[:, 0] = sign * np.maximum(np.abs(path[:, 0]), clear)
            strings.append(tube(path, (0.0, 1.0, 0.0), (0.7, 1.3), sides=6))
    return strings
