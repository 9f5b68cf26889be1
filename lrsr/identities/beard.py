"""What grows on a man's jaw? Nothing, stubble, moustache, goatee, chin beard or a full beard.

The region is a soft mask over the template; the hairs are strands on a sheet wrapped around the
jaw (azimuth by elevation about a point inside the head), which stretches little below the chin.
"""

from typing import Any, Literal, TypedDict, get_args

import cv2
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from lrsr.identities.canvas import Canvas, FloatMap, smoothstep

BeardKind = Literal["none", "stubble", "moustache", "goatee", "chin", "full"]
BEARD_KINDS: tuple[BeardKind, ...] = get_args(BeardKind)

JAW = Canvas(left_mm=-135.0, top_mm=20.0, width_mm=270.0, height_mm=140.0, pixel_mm=0.3)
"""The unrolled jaw: arc lengths at ``_RADIUS_MM`` along azimuth and elevation."""

_CENTRE = np.array([0.0, -35.0, -75.0])
_RADIUS_MM = 85.0
_STRANDS = 5200
_STRAND_POINTS = 4
_GROUND_LEVEL = 205  # the blur between hairs is never so dark that they drown in it


class Beard(TypedDict):
    """One person's beard.

    ``shadow`` is the blue-grey of shaven hair below the skin, [0, 1]; ``grey`` multiplies the share
    of white hairs on the head.
    """

    kind: BeardKind
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
    kinds = np.array([0.36, 0.20, 0.09, 0.12, 0.06, 0.17 - 0.10 * asian])
    kind = str(rng.choice(BEARD_KINDS, p=kinds / kinds.sum())) if masculinity >= 0.6 else "none"
    long = float(np.exp(rng.normal(np.log(2.2), 0.5)))
    return {
        "kind": kind,  # type: ignore[typeddict-item] # choice() forgets which strings it was given
        "density": float(np.clip(np.exp(rng.normal(0.0, 0.3)) * (0.55 + 0.45 * growth), 0.3, 1.6)),
        "length_mm": float(np.clip(long, 1.0, 6.0)),
        "cheek_line_mm": float(rng.uniform(-14.0, 9.0)),
        "shadow": growth * float(rng.uniform(0.15, 0.9)),
        "patchiness": float(rng.uniform(0.0, 0.8)),
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
    bare = (1 - lips) * smoothstep(-104.0, -92.0, z)
    # Over the lip: between nose and vermilion, drooping a little beyond the corners.
    top = -50.5 - 0.010 * x**2
    moustache = smoothstep(1.5, -3.0, y - top) * smoothstep(-79.0, -74.0, y)
    moustache = moustache * smoothstep(33.0, 27.0, x) * smoothstep(-20.0, -10.0, z)
    narrowing = x + 0.22 * np.clip(-80.0 - y, 0.0, 45.0)
    goatee = smoothstep(-79.0, -87.0, y) * smoothstep(33.0, 20.0, narrowing)
    goatee = goatee * (1 - 0.45 * smoothstep(9.0, 15.0, x) * smoothstep(-93.0, -86.0, y))
    corner = smoothstep(21.0, 26.0, x) * smoothstep(33.0, 27.0, x) * smoothstep(-68.0, -75.0, y)
    chin = np.maximum(goatee, corner * smoothstep(-106.0, -92.0, y))
    # The jaw: below a line from the sideburn to the corner of the mouth.
    line = -66.0 + 48.0 * smoothstep(38.0, 72.0, x)
    jaw = smoothstep(3.0, -6.0, y - line) * smoothstep(
        12.0, 26.0, x - 0.5 * np.clip(y + 84.0, 0.0, 20.0)
    )
    cheeks = smoothstep(16.0, -8.0, y - line) * smoothstep(26.0, 40.0, x)
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


_WEIGHTS: dict[BeardKind, dict[str, float]] = {
    "none": {},
    "stubble": {"moustache": 0.9, "chin": 1.0, "jaw": 0.9, "cheeks": 0.35, "neck": 0.5},
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
    mask = np.zeros_like(zones["chin"])
    reach = 0.5 + beard["cheek_line_mm"] / 25.0
    for name, weight in _WEIGHTS[beard["kind"]].items():
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
    stubble: Beard = {
        "kind": "stubble",
        "density": 1.0,
        "length_mm": 1.0,
        "cheek_line_mm": 0.0,
        "shadow": 1.0,
        "patchiness": 0.0,
        "grey": 1.0,
    }
    return beard_mask(stubble, zones)


def beard_strands(beard: Beard, rng: Generator) -> NDArray[np.float64]:
    """Lay hairs over the whole unrolled jaw; the mask decides later which of them show.

    They point down, at the sides a little forward, on the upper lip outwards.

    Args:
        beard: As :func:`sample_beard` draws it.
        rng: Source of randomness.

    Returns:
        ``(N, 4, 2)``, mm on ``JAW``.
    """
    count = round(_STRANDS * min(1.4, beard["density"]))
    root = np.stack([rng.uniform(-125.0, 125.0, count), rng.uniform(-115.0, 15.0, count)], axis=-1)
    # Most hairs where most beards grow: around the mouth and the chin.
    middle = count // 3
    root[:middle, 0] = rng.uniform(-38.0, 38.0, middle)
    root[:middle, 1] = rng.uniform(-70.0, -8.0, middle)
    x, y = root[:, 0], root[:, 1]
    lip = smoothstep(-42.0, -34.0, y) * smoothstep(36.0, 24.0, np.abs(x))
    angle = -0.5 * np.pi + lip * np.sign(x) * np.clip(0.35 + np.abs(x) / 22.0, 0, 1.1)
    angle -= (1 - lip) * 0.25 * np.clip(x / 90.0, -1, 1)
    angle += rng.normal(0.0, 0.28, count)
    bend = rng.normal(0.0, 0.25, count)
    length = np.clip(beard["length_mm"], 1.0, 4.5) * rng.uniform(1.0, 2.2, count)
    steps = (np.arange(_STRAND_POINTS - 1) + 0.5) / (_STRAND_POINTS - 1)
    turn = angle[:, None] + bend[:, None] * steps
    step = (length / (_STRAND_POINTS - 1))[:, None]
    moves = np.stack([step * np.cos(turn), step * np.sin(turn)], axis=-1)
    path = np.concatenate([np.zeros((count, 1, 2)), np.cumsum(moves, axis=1)], axis=1)
    return np.asarray(root[:, None] + path)


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
        return _draw_stubble(beard, rng, sheet)
    JAW.draw_strands(sheet, beard_strands(beard, rng), (150, 190, 225, 250))
    ground = cv2.GaussianBlur(sheet, (0, 0), 1.6 / JAW.pixel_mm)
    body = min(2.0, 0.75 + 0.35 * beard["length_mm"] * beard["density"])
    ground = cv2.min(cv2.convertScaleAbs(ground, alpha=body), _GROUND_LEVEL)
    return np.asarray(cv2.max(sheet, ground), dtype=np.uint8)


def _draw_stubble(beard: Beard, rng: Generator, sheet: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Short bristles: noise of their size, which costs less than thousands of strokes."""
    noise = rng.integers(0, 256, sheet.shape, dtype=np.uint8)
    noise = cv2.GaussianBlur(noise, (3, 5), 0.7)
    low = 128 - 30 * beard["density"]
    return np.asarray(cv2.convertScaleAbs(cv2.subtract(noise, low), alpha=2.6), dtype=np.uint8)


def feather(opacity: FloatMap, mask: FloatMap) -> FloatMap:
    """Let the mask's edge run along the hairs: where it is soft, only the strongest reach.

    Args:
        opacity: Of the hairs, [0, 1].
        mask: Same shape, [0, 1].

    Returns:
        Same shape, the opacity of the hairs that grow.
    """
    return np.asarray(opacity * np.clip(2.2 * mask - 1.2 * (1 - opacity), 0, 1), dtype=np.float32)


def thin_out(beard: Beard, rng: Generator, shape: tuple[int, int]) -> FloatMap:
    """Patches in which a beard grows thinner.

    Args:
        beard: As :func:`sample_beard` draws it.
        rng: Source of randomness.
        shape: Rows and columns of the sheet.

    Returns:
        ``shape`` float32, a factor, [0, 1].
    """
    grid = rng.standard_normal((20, 38), dtype=np.float32)
    noise = cv2.resize(grid, shape[::-1], interpolation=cv2.INTER_CUBIC)
    thinner = np.float32(0.35 * beard["patchiness"]) * (noise + np.float32(0.3))
    return np.asarray(np.clip(1 - thinner, 0, 1), dtype=np.float32)
