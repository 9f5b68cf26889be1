"""What does an eye look like? Sclera with faint veins, iris with fibres and a dark rim, pupil.

The lids lie closer to the eye than the mesh can show, with lashes before them: what they hide from
the light is painted as occlusion of contact, and so are the caruncle and the wet margin.
"""

from functools import lru_cache
from typing import NamedTuple, TypedDict

import cv2
import numpy as np
from numpy.random import Generator
from numpy.typing import ArrayLike, NDArray

from lrsr.identities.ramp import smoothstep

_EDGE_ANGLE_RAD = 0.5 * np.pi
"""Angle from the optical axis at the edge of the texture's inscribed circle.

The texture is an azimuthal equidistant picture of the eyeball seen from in front: its centre is
the optical axis, and the distance from it grows in proportion to the angle.
"""

_IRIS_COLOURS: dict[str, tuple[float, float, float]] = {
    "black": (0.022, 0.012, 0.007),
    "dark brown": (0.045, 0.021, 0.010),
    "brown": (0.095, 0.046, 0.019),
    "hazel": (0.135, 0.085, 0.030),
    "green": (0.100, 0.120, 0.060),
    "grey": (0.145, 0.158, 0.162),
    "blue": (0.080, 0.118, 0.158),
}
"""Middle of the iris, linear sRGB."""

_LIGHT = ("hazel", "green", "grey", "blue")


class Iris(TypedDict):
    """One person's eyes; both are alike but for the pattern of their fibres."""

    colour: str
    half_angle_rad: float
    pupil_share: float
    brightness: float
    limbus: float
    ring: float
    redness: float
    yellowness: float
    warmth: float
    fibre: float
    lid_shadow: float


def sample_iris(rng: Generator, *, european: float, eumelanin: float, age: float) -> Iris:
    """Draw a person's eyes.

    Args:
        rng: Source of randomness.
        european: Share of European ancestry, [0, 1]; only with it are light eyes frequent.
        eumelanin: Of the hair, > 0 (1.3 is brown); fair hair goes with light eyes.
        age: 0 (25 years) to 1 (old).

    Returns:
        Plain numbers and the colour's name.
    """
    light = european**1.3 * np.clip(0.85 - 0.22 * np.log(eumelanin / 0.4), 0.15, 0.92)
    if rng.random() < light:
        colour = str(rng.choice(_LIGHT, p=(0.24, 0.18, 0.20, 0.38)))
    else:
        black = 0.6 * (0.15 + 0.5 * (1 - european))
        colour = str(rng.choice(("black", "dark brown", "brown"), p=(black, 0.5, 0.5 - black)))
    return {
        "colour": colour,
        "half_angle_rad": float(np.clip(rng.normal(0.357, 0.01), 0.33, 0.385)),
        "pupil_share": float(rng.uniform(0.30, 0.48)),
        "brightness": float(np.exp(rng.normal(0.0, 0.20 if colour in _LIGHT else 0.35))),
        "limbus": float(rng.uniform(0.35, 0.9)),
        "ring": float(rng.uniform(0.0, 0.8)),
        "redness": float(np.clip(rng.normal(0.35 + 0.25 * age, 0.18), 0.05, 1.0)),
        "yellowness": float(np.clip(rng.normal(0.3 + 0.4 * age, 0.15), 0.0, 1.0)),
        "warmth": float(rng.normal(0.0, 0.12)),
        "fibre": float(rng.uniform(0.25, 0.6)),
        "lid_shadow": float(rng.uniform(0.75, 1.15)),
    }


def paint_eye(
    iris: Iris, rng: Generator, margins: NDArray[np.float64], texture_size: int = 256
) -> NDArray[np.float32]:
    """Paint one eyeball.

    Args:
        iris: As :func:`sample_iris` draws it.
        rng: Source of randomness: fibres and veins.
        margins: ``(2, n, 2)`` radians, the upper and the lower lid from the inner corner to the
            outer, as angles from the axis, across and up.
        texture_size: Rows and columns, >= 16.

    Returns:
        ``(S, S, 3)`` float32 linear reflectance, [0, 1], laid out as ``EDGE_ANGLE_RAD`` says.
    """
    chart = _chart(texture_size)
    pixel = 2 * _EDGE_ANGLE_RAD / texture_size
    soft = pixel / iris["half_angle_rad"]
    colour = _paint_sclera(iris, chart, rng)
    reach = int((1.1 + 0.6 * soft) * iris["half_angle_rad"] / pixel) + 1
    middle = slice(max(texture_size // 2 - reach, 0), texture_size // 2 + reach + 1)
    seen = colour[:, middle, middle]  # beyond the iris nothing of it is painted
    radius = chart.angle[middle, middle] / np.float32(iris["half_angle_rad"])
    inside = smoothstep(1.0 + 0.6 * soft + 0.03, 1.0 - 0.6 * soft - 0.05, radius)
    seen += (_paint_iris(iris, radius, chart.azimuth[middle, middle], rng) - seen) * inside
    share = iris["pupil_share"]
    pupil = smoothstep(share + 0.7 * soft + 0.01, share - 0.7 * soft - 0.01, radius)
    seen += (np.float32(0.004) - seen) * pupil
    colour = _close_lids(colour, margins, iris["lid_shadow"])
    return np.asarray(cv2.merge(list(np.clip(colour, 0.0, 1.0))))


class _Chart(NamedTuple):
    """The texture's own shape, each ``(S, S)`` float32.

    Attributes:
        angle: From the optical axis, radians.
        azimuth: Around it, radians.
        corner: Where blood and fat lie: towards the corners of the lids.
        rim: Close to the edge.
        veined: Away from the iris.
    """

    angle: NDArray[np.float32]
    azimuth: NDArray[np.float32]
    corner: NDArray[np.float32]
    rim: NDArray[np.float32]
    veined: NDArray[np.float32]


@lru_cache(maxsize=2)
def _chart(size: int) -> _Chart:
    centred = (np.arange(size, dtype=np.float32) + 0.5) / size * 2 - 1
    x, y = np.meshgrid(centred, -centred)
    angle, azimuth = np.hypot(x, y) * np.float32(_EDGE_ANGLE_RAD), np.arctan2(y, x)
    corner = smoothstep(0.42, 1.05, angle) * (0.35 + 0.65 * np.cos(azimuth) ** 2)
    rim, veined = smoothstep(0.95, 1.45, angle), smoothstep(0.45, 0.8, angle)
    return _Chart(angle, azimuth, np.asarray(corner, np.float32), rim, veined)


def _planes(colour: ArrayLike) -> NDArray[np.float32]:
    """Shape a colour to be mixed with planes ``(3, H, W)``."""
    return np.asarray(colour, dtype=np.float32)[:, None, None]


_WHITE = _planes([0.33, 0.302, 0.283])
_PINK = _planes([0.30, 0.16, 0.135])
_YELLOW = _planes([0.32, 0.265, 0.19])


def _paint_sclera(iris: Iris, chart: _Chart, rng: Generator) -> NDArray[np.float32]:
    """Paint the white of the eye: ``(3, S, S)``."""
    redness = np.clip(0.45 * iris["redness"] * chart.corner + 0.55 * chart.rim, 0, 0.85)
    sclera = _WHITE + (_YELLOW - _WHITE) * np.float32(0.35 * iris["yellowness"])
    veins = _draw_veins(len(redness), iris["redness"], rng).astype(np.float32) / 255.0
    redness = np.clip(redness + 0.5 * veins * chart.veined, 0, 0.9)
    return np.asarray(sclera + (_PINK - sclera) * redness)


def _draw_veins(size: int, redness: float, rng: Generator) -> NDArray[np.uint8]:
    sheet = np.zeros((size, size), dtype=np.uint8)
    count = round(6 + 16 * redness)
    start = np.where(rng.random(count) < 0.5, 0.0, np.pi) + rng.normal(0.0, 0.5, count)
    steps = np.linspace(1.25, rng.uniform(0.5, 0.8, count), 9).T
    wander = np.cumsum(rng.normal(0.0, 0.05, (count, 9)), axis=1)
    turn = start[:, None] + wander
    radius = steps / _EDGE_ANGLE_RAD * size / 2
    points = np.stack([size / 2 + radius * np.cos(turn), size / 2 - radius * np.sin(turn)], axis=-1)
    lines = list(np.round(points * 16).astype(np.int32))
    cv2.polylines(sheet, lines, False, 150, 1, cv2.LINE_AA, shift=4)
    return np.asarray(cv2.GaussianBlur(sheet, (0, 0), max(0.3, size / 512)), dtype=np.uint8)


def _paint_iris(
    iris: Iris, radius: NDArray[np.float32], azimuth: NDArray[np.float32], rng: Generator
) -> NDArray[np.float32]:
    """Paint the iris: ``(3, H, W)``."""
    middle = np.array(_IRIS_COLOURS[iris["colour"]], dtype=np.float32) * iris["brightness"]
    middle *= np.array([1 + iris["warmth"], 1.0, 1 - iris["warmth"]], dtype=np.float32)
    fibres = _fibres(radius, azimuth, rng)
    value = 1.0 + iris["fibre"] * fibres
    # A warmer collarette around the pupil, lighter in light eyes.
    collarette = np.exp(-(((radius - iris["pupil_share"] - 0.16) / 0.13) ** 2)) * iris["ring"]
    warm = middle * np.array([1.7, 1.25, 0.8], dtype=np.float32)
    colour = _planes(middle) + _planes(warm - middle) * collarette
    limbus = 1 - iris["limbus"] * smoothstep(0.74, 1.0, radius)
    return np.asarray(colour * (value * limbus), dtype=np.float32)


def _fibres(
    radius: NDArray[np.float32], azimuth: NDArray[np.float32], rng: Generator
) -> NDArray[np.float32]:
    """Radial streaks, about -1..1: noise in polar coordinates, long in radius, short in angle."""
    noise = rng.normal(0.0, 1.0, (6, 128)).astype(np.float32)
    noise += np.repeat(rng.normal(0.0, 0.9, (6, 32)).astype(np.float32), 4, axis=1)
    noise = np.concatenate([noise, noise[:, :1]], axis=1)
    column = (azimuth / np.float32(2 * np.pi) + np.float32(0.5)) * np.float32(128)
    row = np.clip(radius, 0, 1) * np.float32(5)
    streaks = cv2.remap(noise, column, row, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(np.clip(0.7 * streaks, -1.6, 1.8), dtype=np.float32)


_CARUNCLE = _planes([0.42, 0.20, 0.17])
_WET_MARGIN = _planes([0.46, 0.27, 0.23])


def _close_lids(
    colour: NDArray[np.float32], margins: NDArray[np.float64], strength: float
) -> NDArray[np.float32]:
    """Shade the eye ``(3, S, S)`` below its lids; distances in radians, 0.06 are a millimetre."""
    size = colour.shape[1]
    centred = (np.arange(size, dtype=np.float32) + 0.5) / size * 2 - 1
    x, y = centred * _EDGE_ANGLE_RAD, -centred[:, None] * np.float32(_EDGE_ANGLE_RAD)
    inner, outer = float(margins[:, 0, 0].mean()), float(margins[:, -1, 0].mean())
    upper, lower = (
        np.interp(x, *margin[np.argsort(margin[:, 0])].T).astype(np.float32) for margin in margins
    )
    below, above = np.maximum(upper - y, 0.0), np.maximum(y - lower, 0.0)
    inwards = (x - inner) * np.sign(outer - inner)
    corner = np.maximum(np.minimum(inwards, np.abs(outer - inner) - inwards), 0.0)
    # The caruncle fills the inner corner, the wet edge of the lower lid lies on the eye.
    flesh = smoothstep(0.20, 0.09, inwards + 0.5 * np.abs(y - 0.5 * (upper + lower)))
    colour = colour + (_CARUNCLE - colour) * flesh.astype(np.float32)
    wet = np.float32(0.75) * smoothstep(0.045, 0.012, above)
    colour = colour + (_WET_MARGIN - colour) * wet
    shade = 0.56 * np.exp(-below / 0.08) + 0.34 * np.exp(-below / 0.24)
    shade += 0.22 * np.exp(-above / 0.05) + 0.30 * np.exp(-corner / 0.12)
    light = 1 - np.clip(strength * shade, 0.0, 0.88)
    return np.asarray(colour * light, dtype=np.float32)
