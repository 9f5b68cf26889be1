"""What grows on a man's jaw? Nothing, stubble, moustache, goatee, chin beard or a full beard.

The region is a soft mask over the template; the hairs are strands on a sheet wrapped around the
jaw (azimuth by elevation about a point inside the head), which stretches little below the chin.
"""

from typing import Any, Literal, TypedDict, get_args

import cv2
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from lrsr.identities.ramp import smoothstep
from lrsr.identities.skin.canvas import Canvas, FloatMap, bend_strands

_BeardKind = Literal["none", "stubble", "moustache", "goatee", "chin", "full"]
_BEARD_KINDS: tuple[_BeardKind, ...] = get_args(_BeardKind)

JAW = Canvas(left_mm=-135.0, top_mm=20.0, width_mm=270.0, height_mm=140.0, pixel_mm=0.3)
"""The unrolled jaw: arc lengths at ``_RADIUS_MM`` along azimuth and elevation."""

_CENTRE = np.array([0.0, -35.0, -75.0])
_RADIUS_MM = 85.0
_STRANDS = 9000
_GROUND_LEVEL = 185  # the shadow between hairs is never so dark that they drown in it
_HAIR_LEVELS = (110, 150, 185, 210, 230, 245, 252)  # thin ones let skin shine through


class Beard(TypedDict):
    """One person's beard.

    ``shadow`` is the blue-grey of shaven hair below the skin, [0, 1]; ``grey`` multiplies the share
    of white hairs on the head.
    """

    kind: _BeardKind
    density: float
    length_mm: float
    cheek_line_mm: float
    shadow: float
    patchiness: float
    grey: float


def sample_beard(rng: Generator, *, masculinity: float, asian: float, grey: float) -> Beard:
    """Draw a person's beard; below a masculinity of 0.6 none grows.

    Args:
        rng: Source of randomness.
        masculinity: 0 (female) to 1 (male).
        asian: Share of Asian ancestry, [0, 1]: beards grow thinner with it.
        grey: Share of white hairs on the head, [0, 1].

    Returns:
        Plain numbers and the kind's name.
    """
    growth = float(np.clip((masculinity - 0.55) / 0.3, 0.0, 1.0)) * (1 - 0.45 * asian)
    kinds = np.array([0.40, 0.14, 0.12, 0.10, 0.06, 0.18 - 0.10 * asian])
    kind = str(rng.choice(_BEARD_KINDS, p=kinds / kinds.sum())) if masculinity >= 0.6 else "none"
    long = float(np.exp(rng.normal(np.log(2.2), 0.5)))
    return {
        "kind": kind,  # type: ignore[typeddict-item] # choice() forgets which strings it was given
        "density": float(np.clip(np.exp(rng.normal(0.3, 0.5)) * (0.55 + 0.45 * growth), 0.35, 2.8)),
        "length_mm": float(np.clip(long, 1.0, 6.0)),
        "cheek_line_mm": float(rng.uniform(-14.0, 9.0)),
        "shadow": growth * float(rng.uniform(0.1, 1.0)),
        "patchiness": float(rng.uniform(0.1, 0.8)),
        "grey": float(rng.uniform(0.7, 1.5)) if grey > 0 else 1.0,
    }


def to_jaw(position: NDArray[Any]) -> FloatMap:
    """Unroll template points.

    Args:
        position: ``(..., 3)``, mm.

    Returns:
        ``(..., 2)`` float32, arc lengths on ``JAW``, mm; the chin's tip is near (0, -57).
    """
    offset = np.asarray(position, dtype=np.float32) - _CENTRE.astype(np.float32)
    flat = np.hypot(offset[..., 0], offset[..., 2])
    azimuth = np.arctan2(offset[..., 0], offset[..., 2])
    elevation = np.arctan2(offset[..., 1], flat)
    return np.stack([azimuth, elevation], axis=-1) * np.float32(_RADIUS_MM)


def beard_zones(position: NDArray[Any], lips: FloatMap) -> dict[str, FloatMap]:
    """Where each part of a beard grows.

    Args:
        position: ``(..., 3)``, template points, mm.
        lips: ``(...)``, the vermilion, [0, 1], where nothing grows.

    Returns:
        Name to ``(...)`` float32, [0, 1]: moustache, chin (with the soul patch), jaw, cheeks, neck.
    """
    x = np.abs(position[..., 0])
    y, z = position[..., 1], position[..., 2]
    bare = (1 - lips) ** 1.2 * smoothstep(-104.0, -92.0, z)  # sparse along the vermilion
    # Over the lip: between nose and vermilion, drooping a little beyond the corners.
    top = -50.5 - 0.010 * x**2
    moustache = smoothstep(2.0, -5.0, y - top) * smoothstep(-80.0, -72.0, y)
    moustache = moustache * smoothstep(36.0, 22.0, x) * smoothstep(-20.0, -10.0, z)
    moustache = moustache * (1 - 0.35 * smoothstep(4.0, 1.0, x))  # thinner in the philtrum
    narrowing = x + 0.22 * np.clip(-80.0 - y, 0.0, 45.0)
    goatee = smoothstep(-79.0, -90.0, y) * smoothstep(36.0, 17.0, narrowing)
    goatee = goatee * (1 - 0.6 * smoothstep(6.0, 14.0, x) * smoothstep(-97.0, -87.0, y))
    corner = smoothstep(19.0, 27.0, x) * smoothstep(36.0, 27.0, x) * smoothstep(-64.0, -76.0, y)
    chin = np.maximum(goatee, 0.8 * corner * smoothstep(-108.0, -92.0, y))
    # The jaw: below a line from the sideburn to the corner of the mouth.
    line = -66.0 + 48.0 * smoothstep(38.0, 72.0, x)
    jaw = smoothstep(6.0, -10.0, y - line) * smoothstep(
        8.0, 27.0, x - 0.5 * np.clip(y + 84.0, 0.0, 20.0)
    )
    cheeks = smoothstep(20.0, -10.0, y - line) * smoothstep(24.0, 42.0, x)
    sideburn = smoothstep(66.0, 70.0, x) * smoothstep(-20.0, -60.0, z) * smoothstep(6.0, -6.0, y)
    jaw = np.maximum(jaw, sideburn * smoothstep(-98.0, -88.0, z))
    above_neck = smoothstep(-139.0, -122.0, y + 0.28 * np.minimum(z, 0.0))
    neck = smoothstep(-108.0, -114.0, y) * above_neck * smoothstep(-70.0, -45.0, z)
    ears = smoothstep(79.0, 75.0, x)
    zones = {"moustache": moustache, "chin": chin, "jaw": jaw, "cheeks": cheeks, "neck": neck}
    return {
        name: np.asarray(np.clip(zone * bare * ears * above_neck, 0, 1), dtype=np.float32)
        for name, zone in zones.items()
    }


_WEIGHTS: dict[_BeardKind, dict[str, float]] = {
    "none": {},
    "stubble": {"moustache": 0.85, "chin": 0.95, "jaw": 0.8, "cheeks": 0.3, "neck": 0.45},
    "moustache": {"moustache": 1.0},
    "goatee": {"moustache": 1.0, "chin": 1.0},
    "chin": {"chin": 1.0},
    "full": {"moustache": 1.0, "chin": 1.0, "jaw": 1.0, "cheeks": 0.55, "neck": 0.35},
}


def beard_mask(beard: Beard, zones: dict[str, FloatMap]) -> FloatMap:
    """Where this person's beard grows.

    Args:
        beard: As :func:`sample_beard` draws it.
        zones: As :func:`beard_zones` makes them.

    Returns:
        The zones' shape, float32, [0, 1].
    """
    return _cover(beard["kind"], beard["cheek_line_mm"], zones)


def _cover(kind: _BeardKind, cheek_line_mm: float, zones: dict[str, FloatMap]) -> FloatMap:
    mask = np.zeros_like(zones["chin"])
    reach = 0.5 + cheek_line_mm / 25.0
    for name, weight in _WEIGHTS[kind].items():
        share = weight * (max(0.0, min(1.5, 1.6 * reach)) if name == "cheeks" else 1.0)
        np.maximum(mask, np.float32(min(1.0, share)) * zones[name], out=mask)
    return mask


def shadow_mask(zones: dict[str, FloatMap]) -> FloatMap:
    """Where shaven hair shows through the skin (the five o'clock shadow).

    Args:
        zones: As :func:`beard_zones` makes them.

    Returns:
        The zones' shape, float32, [0, 1].
    """
    shown = np.minimum(np.float32(1.2) * _cover("stubble", 0.0, zones), 1)
    return np.asarray(shown, dtype=np.float32)


def _beard_strands(beard: Beard, rng: Generator) -> NDArray[np.float64]:
    """Lay hairs over the whole unrolled jaw; the mask decides later which of them show.

    They point down, at the sides a little forward, on the upper lip outwards.

    Args:
        beard: As :func:`sample_beard` draws it.
        rng: Source of randomness.

    Returns:
        ``(N, 4, 2)``, mm on ``JAW``.
    """
    count = round(_STRANDS * min(1.5, beard["density"]))
    root = np.stack([rng.uniform(-110.0, 110.0, count), rng.uniform(-105.0, 5.0, count)], axis=-1)
    # Most hairs where most beards grow: around the mouth and the chin.
    middle = count // (8 if beard["kind"] == "full" else 3)
    root[:middle, 0] = rng.uniform(-38.0, 38.0, middle)
    root[:middle, 1] = rng.uniform(-70.0, -8.0, middle)
    x, y = root[:, 0], root[:, 1]
    lip = smoothstep(-42.0, -34.0, y) * smoothstep(36.0, 24.0, np.abs(x))
    angle = -0.5 * np.pi + lip * np.sign(x) * np.clip(0.35 + np.abs(x) / 22.0, 0, 1.1)
    angle -= (1 - lip) * 0.25 * np.clip(x / 90.0, -1, 1)
    angle += rng.normal(0.0, 0.34, count)
    bend = rng.normal(0.0, 0.3, count)
    length = np.clip(beard["length_mm"], 1.0, 4.5) * rng.uniform(0.7, 2.0, count)
    return np.asarray(root[:, None] + bend_strands(length, angle, bend))


def draw_beard(beard: Beard, rng: Generator) -> NDArray[np.uint8]:
    """Draw the hairs that the mask will be laid over.

    Args:
        beard: As :func:`sample_beard` draws it.
        rng: Source of randomness.

    Returns:
        Opacity of hair over skin on ``JAW``, ``(H, W)`` uint8, 0..255; empty for the kind "none".
    """
    sheet = JAW.blank()
    if beard["kind"] == "none":
        return sheet
    if beard["kind"] == "stubble":
        # Bristles seen end on: dots of their size, from noise, which costs less than thousands.
        noise = cv2.GaussianBlur(rng.integers(0, 256, sheet.shape, dtype=np.uint8), (3, 3), 0.75)
        dots = cv2.subtract(noise, 146 - 26 * beard["density"])
        return np.asarray(cv2.convertScaleAbs(dots, alpha=3.6), dtype=np.uint8)
    JAW.draw_strands(sheet, _beard_strands(beard, rng), _HAIR_LEVELS)
    # What lies between the hairs: their shadow and those below, patchy as locks are.
    ground = cv2.GaussianBlur(sheet, (0, 0), 0.8 / JAW.pixel_mm)
    body = min(1.7, 0.6 + 0.3 * beard["length_mm"] * beard["density"])
    ground = cv2.min(cv2.convertScaleAbs(ground, alpha=body), _GROUND_LEVEL)
    return np.asarray(cv2.max(sheet, ground), dtype=np.uint8)


def feather(opacity: FloatMap, mask: FloatMap) -> FloatMap:
    """Let a beard thin out hair by hair: where the mask is soft, only the strongest grow.

    Args:
        opacity: Of the hairs, [0, 1].
        mask: Same shape, [0, 1].

    Returns:
        Same shape, the opacity of the hairs that grow.
    """
    grown = np.clip(1.7 * mask - 0.7 * (1 - opacity), 0, 1)
    return np.asarray(opacity * grown * np.sqrt(mask), dtype=np.float32)


def thin_out(beard: Beard, rng: Generator, shape: tuple[int, int]) -> FloatMap:
    """Patches in which a beard grows thinner.

    Args:
        beard: As :func:`sample_beard` draws it.
        rng: Source of randomness.
        shape: Rows and columns of the sheet.

    Returns:
        ``shape`` float32, a factor, [0, 1].
    """
    half = shape[1] // 2, shape[0] // 2  # finer than needed already, and cheaper
    noise = np.zeros(half[::-1], dtype=np.float32)
    for cells, amount in (((38, 20), 0.30), ((110, 58), 0.22)):
        grid = rng.standard_normal(cells[::-1], dtype=np.float32)
        noise += np.float32(amount) * cv2.resize(grid, half, interpolation=cv2.INTER_CUBIC)
    thinner = np.float32(beard["patchiness"]) * (noise + np.float32(0.12))
    thick = cv2.resize(np.clip(1 - thinner, 0, 1), shape[::-1], interpolation=cv2.INTER_LINEAR)
    return np.asarray(thick, dtype=np.float32)
