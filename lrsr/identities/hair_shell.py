"""What surface does combed hair make? Columns of strands from root to tip, laid over a skull.

Column 0 starts at the front end of the parting and the columns go round by the subject's left, the
back and the right to the front again. Each column is a path: first over the skull, from its root on
the parting (or whorl) to where the hair leaves the skull, then downwards, either close to the skin
(fringe, sideburn) or hanging from the widest place above. The path is lifted off the skin by the
thickness of the hair, which fades out at a hairline.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, maximum_filter

from lrsr.identities.hair_anchors import (
    AZIMUTHS,
    POLAR_STEP_DEG,
    SKULL_CENTRE_MM,
    Anchors,
)
from lrsr.identities.hair_scalp import MM_PER_DEG, bald_polar, hairline_polar, smoothstep
from lrsr.identities.hair_styles import AT_HAIRLINE_MM, LOWER_AZIMUTHS_DEG

Floats = NDArray[np.float64]

COLUMNS = 288
ROWS = 40
BEYOND_MM = (4.0, 9.0, 15.0)
"""Extra rows past a free edge, for strands that reach over it; not part of the shell's mesh. At a
hairline they are a third as long."""

_LEVELS_MM = np.arange(100.0, -284.0, -4.0)
_HANG_POLAR_DEG = 80.0
_MOST_HANG_MM = 32.0


@dataclass(frozen=True)
class Shell:
    """The surface of the hair, with room beyond its edge.

    Attributes:
        points: ``(COLUMNS, ROWS + 3, 3)``, mm; the last three rows lie beyond the edge.
        outward: ``(COLUMNS, ROWS + 3, 3)`` unit vectors off the skin.
        height: ``(COLUMNS, ROWS + 3)`` distance off the skin, mm.
    """

    points: Floats
    outward: Floats
    height: Floats


@dataclass(frozen=True)
class _Paths:
    """Columns before they are laid on a head: degrees in the flattened chart, and lengths in mm."""

    root: Floats
    leave: Floats
    leave_azimuth: Floats
    length_mm: Floats
    over_skull_mm: Floats
    on_parting: Floats
    leading: Floats
    free: Floats
    tuft: Floats


def shell_rows() -> Floats:
    """Return the share of its length at which each row of a column lies, ``(ROWS,)`` in 0..1."""
    return 1.0 - (1.0 - np.linspace(0.0, 1.0, ROWS)) ** 1.2


def lay_shell(
    parameters: Mapping[str, Any],
    anchors: Anchors,
    skin_vertices: NDArray[np.float32],
    rng: np.random.Generator,
) -> Shell:
    """Lay the hair on one head.

    Args:
        parameters: Of one head of hair, see :mod:`lrsr.identities.hair_styles`.
        anchors: The chart of the skull.
        skin_vertices: ``(V, 3)``, mm.
        rng: Of clumps and ragged edges.
    """
    chart = anchors.locate(skin_vertices)
    upper = slice(0, 30)
    shift = (chart[:, upper] - anchors.template[:, upper]).mean(axis=(0, 1))
    centre = np.asarray(SKULL_CENTRE_MM) + shift * np.array([1.0, 1.0, 1.0])
    skin_radius = _cylinder(chart, centre)
    ears_radius = _ears(skin_vertices[anchors.ears], centre)
    paths = _paths(parameters, chart, centre, rng)
    return _lift(parameters, chart, centre, skin_radius, ears_radius, paths, rng)


def _paths(
    parameters: Mapping[str, Any], chart: Floats, centre: Floats, rng: np.random.Generator
) -> _Paths:
    """Decide for each column where it starts, where it leaves the skull and how long it is."""
    u = np.linspace(0.0, 1.0, COLUMNS)
    side = np.where(u < 0.5, 1.0, -1.0)
    q = np.abs(1.0 - 2.0 * u)
    parting_azimuth = float(np.rad2deg(np.arctan2(parameters["parting_deg"], 56.0)))
    left, right = parameters["front_left_deg"], parameters["front_right_deg"]
    first = np.where(
        side > 0, left if left > 0 else parting_azimuth, right if right > 0 else -parting_azimuth
    )
    azimuth = side * (first + (180.0 - first) * (1.0 - q))
    hairline = _trimmed_hairline(parameters, azimuth)
    low = _lower_edge(parameters, azimuth)
    hairline_y = _sample(chart, azimuth, hairline)[:, 1]
    hangs = low < hairline_y
    leave_polar = np.where(hangs, np.minimum(hairline, _HANG_POLAR_DEG), hairline)
    leave_y = _sample(chart, azimuth, leave_polar)[:, 1]
    fringe = parameters["fringe_mm"] + parameters["fringe_tilt_mm"] * np.sin(np.deg2rad(azimuth))
    fringe = fringe * smoothstep((54.0 - np.abs(azimuth)) / 14.0)
    drop = np.where(hangs, leave_y - low, np.maximum(fringe, 0.0))
    crown = np.array(
        [parameters["crown_x_deg"] + 0.8 * parameters["parting_deg"], parameters["crown_z_deg"]]
    )
    front_polar = hairline_polar(np.array([parting_azimuth]), parameters)[0] - 1.0
    front = _flatten(np.array([parting_azimuth]), np.array([front_polar]))[0]
    on_parting = smoothstep((q - 0.1) / 0.9)
    if parameters["parting_length"] > 0:
        crown = front + parameters["parting_length"] * (crown - front)
    else:
        on_parting = np.zeros_like(on_parting)
    root = crown + on_parting[:, None] * (front - crown)
    leave = _flatten(azimuth, leave_polar)
    if parameters["bald_deg"] > 0:
        rim = bald_polar(azimuth, parameters["bald_deg"])
        root = _flatten(azimuth, np.minimum(rim, leave_polar - 1.0))
    over_skull = np.maximum(np.linalg.norm(leave - root, axis=1) * MM_PER_DEG, 1.0)
    free = drop > 8.0
    tuft = _tufts(parameters, rng)
    jitter = 0.25 * rng.random(COLUMNS) + _noise(rng, (COLUMNS,), (6.0,), spread=0.35)
    jitter = jitter + np.where(free, np.abs(tuft), 0.3 * np.abs(tuft))
    length = over_skull + drop + np.minimum(fringe, 0.0) - parameters["ragged_mm"] * jitter
    frame = np.clip(1.0 - np.abs(np.abs(azimuth) - first) / 40.0, 0.0, 1.0) * (drop > 60.0)
    length = length - parameters["layer_mm"] * frame**1.5
    leading = smoothstep((1.0 - q) / 0.06)
    if left == 0.0:
        leading = np.ones_like(leading)
    return _Paths(
        root=root,
        leave=leave,
        leave_azimuth=azimuth,
        length_mm=np.maximum(length, 1.0),
        over_skull_mm=over_skull,
        on_parting=on_parting,
        leading=leading,
        free=smoothstep((drop - 6.0) / 8.0),
        tuft=tuft,
    )


def _lift(
    parameters: Mapping[str, Any],
    chart: Floats,
    centre: Floats,
    skin_radius: Floats,
    ears_radius: Floats,
    paths: _Paths,
    rng: np.random.Generator,
) -> Shell:
    """Lay the paths on the head and lift them off the skin by the thickness of the hair."""
    along = np.concatenate(
        [
            shell_rows()[None, :] * paths.length_mm[:, None],
            paths.length_mm[:, None]
            + (0.33 + 0.67 * paths.free[:, None]) * np.asarray(BEYOND_MM)[None, :],
        ],
        axis=1,
    )
    flat = _bezier(paths, along / paths.over_skull_mm[:, None], parameters["bow"])
    azimuth = np.rad2deg(np.arctan2(flat[..., 0], flat[..., 1]))
    polar = np.hypot(flat[..., 0], flat[..., 1])
    points = _sample(chart, azimuth, polar)
    down = np.maximum(along - paths.over_skull_mm[:, None], 0.0)
    points = _hang(parameters, points, centre, skin_radius, ears_radius, paths, down)
    outward = points - centre
    outward[..., 1] *= 1.0 - np.clip(down / 40.0, 0.0, 1.0)
    outward /= np.linalg.norm(outward, axis=-1, keepdims=True)
    height, fade = _thickness(parameters, azimuth, polar, along, down, paths)
    clump = _noise(rng, along.shape, _clump_widths(parameters), spread=1.0)
    height = height + parameters["clump_mm"] * clump * fade
    lateral = np.stack([outward[..., 2], np.zeros_like(height), -outward[..., 0]], axis=-1)
    phase = (
        2.0
        * np.pi
        * (
            along / parameters["wave_period_mm"]
            + 0.35 * _noise(rng, (COLUMNS,), (9.0,), 1.0)[:, None]
        )
    )
    swing = parameters["wave_mm"] * smoothstep((along - 25.0) / 60.0) * fade
    height = height + 0.5 * swing * np.cos(phase)
    if parameters["sunk_mm"] > 0:
        height = np.full_like(height, -parameters["sunk_mm"])
    share = np.clip(along / paths.length_mm[:, None], 0.0, 1.0)
    loose = paths.free[:, None] * smoothstep((share - 0.35) / 0.65)
    gather = -0.35 * parameters["clump_scale_mm"] * paths.tuft[:, None] * loose
    bend = _noise(rng, (COLUMNS,), (12.0,), 1.0)[:, None] * np.sin(np.pi * (share - 0.3) / 0.7)
    gather = gather + parameters["sway_mm"] * bend * paths.free[:, None] * (share > 0.3)
    front = smoothstep((58.0 - np.abs(paths.leave_azimuth)) / 20.0)
    gather = gather + parameters["sweep_mm"] * front[:, None] * share**2
    aside = swing * np.sin(phase) + gather
    height = height + parameters["flare_mm"] * loose**3
    points = points + outward * height[..., None] + lateral * aside[..., None]
    return Shell(points, outward, height)


def _thickness(
    parameters: Mapping[str, Any],
    azimuth: Floats,
    polar: Floats,
    along: Floats,
    down: Floats,
    paths: _Paths,
) -> tuple[Floats, Floats]:
    """Return the thickness of the hair, mm, and how far it has faded at an edge (1 = not)."""
    top = smoothstep((78.0 - polar) / 38.0)
    back = smoothstep((np.abs(azimuth) - 95.0) / 35.0)
    sides = (1.0 - back) * parameters["side_mm"] + back * parameters["back_mm"]
    full = top * parameters["top_mm"] + (1.0 - top) * sides
    lift = np.exp(-(((polar - 50.0) / 15.0) ** 2) - (azimuth / 40.0) ** 2)
    full = full + parameters["front_lift_mm"] * lift
    dip = parameters["parting_dip"] * np.exp(-((along / 9.0) ** 2))
    full = full * (1.0 - dip * np.minimum(1.0, 4.0 * paths.on_parting[:, None]))
    left = paths.length_mm[:, None] - along
    free = paths.free[:, None]
    inner = np.clip(left / parameters["taper_mm"], 0.0, 1.0)
    fade = smoothstep(inner)
    fade = fade + parameters["roundness"] * (np.sqrt(inner * (2.0 - inner)) - fade)
    close = full * fade - 1.6 * (1.0 - smoothstep(left / 5.0))
    share = smoothstep(down / np.maximum(down.max(axis=1, keepdims=True), 1.0))
    tip = np.minimum(parameters["tip_mm"], full)
    hanging = full + share * (tip - full)
    height = close + free * (hanging - close)
    fade = fade + free * (1.0 - fade)
    leading = paths.leading[:, None]
    bare = np.where(down > 0.0, 0.4 * height, -1.2)
    height = bare + leading * (height - bare)
    if parameters["bald_deg"] > 0:
        rim = smoothstep(along / (0.8 * parameters["taper_mm"]))
        height = height * rim - 1.6 * (1.0 - smoothstep(along / 6.0))
        grows = smoothstep((paths.over_skull_mm - 8.0) / 16.0)[:, None]
        height = grows * height - 5.0 * (1.0 - grows)
        fade = fade * rim
    return height, fade * leading


def _hang(
    parameters: Mapping[str, Any],
    points: Floats,
    centre: Floats,
    skin_radius: Floats,
    ears_radius: Floats,
    paths: _Paths,
    down: Floats,
) -> Floats:
    """Let the part of each path that has left the skull go down, off the skin and the ears."""
    flat = points[..., [0, 2]] - centre[[0, 2]]
    radius = np.linalg.norm(flat, axis=-1)
    leaves = down > 0.0
    start = np.maximum(leaves.argmax(axis=1) - 1, 0)
    row = np.arange(COLUMNS)
    heading = np.where(leaves[..., None], 0.0, flat / np.maximum(radius, 1e-6)[..., None])
    last = _at_end(heading, start, row)
    heading = np.where(leaves[..., None], last[:, None, :], heading)
    y = np.where(leaves, points[row, start, 1][:, None] - down, points[..., 1])
    columns = np.broadcast_to(paths.leave_azimuth[:, None], y.shape)
    surface = _sample_levels(skin_radius, columns, y)
    offset = (points[row, start] - centre)[:, [0, 2]]
    step = np.linalg.norm(offset, axis=-1) - surface[row, start]
    surface = surface + step[:, None] * np.exp(-down / 30.0)
    if parameters["low_side_mm"] < AT_HAIRLINE_MM:
        surface = np.maximum(surface, _sample_levels(ears_radius, columns, y))
    radius = np.where(leaves, surface, radius)
    widest = np.maximum.accumulate(radius, axis=1)
    excess = np.minimum(widest - radius, _MOST_HANG_MM)
    radius = np.where(leaves, radius + parameters["hang"] * excess, radius)
    result = np.empty_like(points)
    result[..., 0] = centre[0] + heading[..., 0] * radius
    result[..., 1] = y
    result[..., 2] = centre[2] + heading[..., 1] * radius
    return np.where(leaves[..., None], result, points)


def _at_end(heading: Floats, start: NDArray[np.intp], row: NDArray[np.intp]) -> Floats:
    last = heading[row, start]
    norm = np.linalg.norm(last, axis=-1, keepdims=True)
    return last / np.maximum(norm, 1e-9)


def _trimmed_hairline(parameters: Mapping[str, Any], azimuth: Floats) -> Floats:
    """The natural hairline, cut higher above the ears and at the nape."""
    away = np.abs(azimuth)
    side = smoothstep((away - 60.0) / 15.0) * smoothstep((122.0 - away) / 15.0)
    back = smoothstep((away - 115.0) / 25.0)
    trim = parameters["trim_side_deg"] * side + parameters["trim_back_deg"] * back
    return hairline_polar(azimuth, parameters) - trim


def _lower_edge(parameters: Mapping[str, Any], azimuth: Floats) -> Floats:
    return np.interp(np.abs(azimuth), LOWER_AZIMUTHS_DEG, parameters["lower_mm"])


def _flatten(azimuth: Floats, polar: Floats) -> Floats:
    """Azimuth and polar angle to the flattened chart: ``(..., 2)`` degrees, left and front."""
    angle = np.deg2rad(azimuth)
    return np.stack([polar * np.sin(angle), polar * np.cos(angle)], axis=-1)


def _bezier(paths: _Paths, share: Floats, bow: float) -> Floats:
    """Points of each column in the flattened chart: ``(COLUMNS, rows, 2)``."""
    t = np.clip(share, 0.0, 1.0)[..., None]
    root, leave = paths.root[:, None, :], paths.leave[:, None, :]
    reach = np.linalg.norm(leave - root, axis=-1, keepdims=True)
    middle = (
        0.5 * (root + leave) + bow * reach * np.array([0.0, 1.0]) * paths.on_parting[:, None, None]
    )
    return (1 - t) ** 2 * root + 2 * t * (1 - t) * middle + t**2 * leave


def _sample(chart: Floats, azimuth: Floats, polar: Floats) -> Floats:
    """Points of the chart at any angles, bilinear: ``(..., 3)``."""
    return _bilinear(chart, azimuth * (AZIMUTHS / 360.0), polar / POLAR_STEP_DEG)


def _sample_levels(table: Floats, azimuth: Floats, y: Floats) -> Floats:
    level = (_LEVELS_MM[0] - y) / (_LEVELS_MM[0] - _LEVELS_MM[1])
    return _bilinear(table[..., None], azimuth * (AZIMUTHS / 360.0), level)[..., 0]


def _bilinear(table: Floats, row: Floats, column: Floats) -> Floats:
    """Sample ``(R, C, n)``: rows wrap around, columns stop at the ends."""
    column = np.clip(column, 0.0, table.shape[1] - 1.001)
    r0, c0 = np.floor(row).astype(np.intp), np.floor(column).astype(np.intp)
    fr, fc = (row - r0)[..., None], (column - c0)[..., None]
    r0, r1 = r0 % table.shape[0], (r0 + 1) % table.shape[0]
    near = table[r0, c0] * (1 - fc) + table[r0, c0 + 1] * fc
    far = table[r1, c0] * (1 - fc) + table[r1, c0 + 1] * fc
    return near * (1 - fr) + far * fr


def _cylinder(chart: Floats, centre: Floats) -> Floats:
    """Distance of the skin from the skull's vertical axis: ``(AZIMUTHS, levels)``, mm."""
    first = 14
    radius = np.hypot(chart[:, first:, 0] - centre[0], chart[:, first:, 2] - centre[2])
    height = np.minimum.accumulate(chart[:, first:, 1], axis=1)
    ramp = np.arange(height.shape[1]) * 1e-6
    return np.stack(
        [np.interp(_LEVELS_MM, (height[a] - ramp)[::-1], radius[a][::-1]) for a in range(AZIMUTHS)]
    )


def _ears(ears: NDArray[np.float32], centre: Floats) -> Floats:
    """How far the ears reach from the skull's axis: ``(AZIMUTHS, levels)``, mm; 0 elsewhere."""
    flat = ears[:, [0, 2]] - centre[[0, 2]]
    azimuth = np.rad2deg(np.arctan2(flat[:, 0], flat[:, 1])) % 360.0
    row = (azimuth * (AZIMUTHS / 360.0)).astype(np.intp) % AZIMUTHS
    level = (_LEVELS_MM[0] - ears[:, 1]) / (_LEVELS_MM[0] - _LEVELS_MM[1])
    column = np.clip(level.astype(np.intp), 0, len(_LEVELS_MM) - 1)
    reach = np.zeros((AZIMUTHS, len(_LEVELS_MM)))
    np.maximum.at(reach, (row, column), np.linalg.norm(flat, axis=1))
    grown = maximum_filter(reach, size=(5, 5), mode=("wrap", "nearest"))
    return np.asarray(gaussian_filter(grown, (1.2, 1.5), mode=("wrap", "nearest")))


def _tufts(parameters: Mapping[str, Any], rng: np.random.Generator) -> Floats:
    """Group neighbouring columns: ``(COLUMNS,)``, -1..1 from one side of a tuft to the other."""
    mean = max(parameters["clump_scale_mm"] / 2.1, 2.0)
    widths = mean * rng.uniform(0.5, 1.5, COLUMNS)
    ends = np.cumsum(widths)
    columns = np.arange(COLUMNS, dtype=np.float64)
    which = np.searchsorted(ends, columns, side="right")
    return np.asarray(1.0 - 2.0 * (ends[which] - columns) / widths[which])


def _clump_widths(parameters: Mapping[str, Any]) -> tuple[float, float]:
    """Blur of the clump noise in columns and rows: long along straight strands, round in curls."""
    across = parameters["clump_scale_mm"] / 4.0
    curly = float(np.clip(parameters["curl_mm"] / 3.0, 0.0, 1.0))
    return across, (1.0 - curly) * 9.0 + curly * 1.4


def _noise(
    rng: np.random.Generator, shape: tuple[int, ...], widths: tuple[float, ...], spread: float
) -> Floats:
    """Smooth noise of zero mean and the given standard deviation."""
    values = gaussian_filter(rng.normal(size=shape), widths, mode="wrap")
    return np.asarray(spread * (values - values.mean()) / max(float(values.std()), 1e-12))
