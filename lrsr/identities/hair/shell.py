"""What surface does combed hair make? Columns of strands from root to tip, laid over a skull.

Column 0 starts at the front end of the parting and the columns go round by the subject's left, the
back and the right to the front again. Each column is a path: first over the skull, from its root on
the parting (or whorl) to where the hair leaves the skull, then downwards, either close to the skin
(fringe, sideburn) or hanging from the widest place above. The path is lifted off the skin by the
thickness of the hair, which fades out at a hairline.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lrsr.identities.hair.anchors import SKULL_CENTRE_MM, load_anchors
from lrsr.identities.hair.chart import measure_ears, measure_skin, sample_chart, sample_level
from lrsr.identities.hair.paths import COLUMNS, Paths, follow_paths, plan_paths, smooth_noise
from lrsr.identities.hair.styles import AT_HAIRLINE_MM
from lrsr.identities.hair.thickness import Course, lay_thickness
from lrsr.identities.ramp import smoothstep

_Floats = NDArray[np.float64]

ROWS = 40
BEYOND_MM = (4.0, 8.0, 12.0)
"""Extra rows past a free edge, for strands that reach over it; not part of the shell's mesh. At a
hairline they are a tenth longer."""

_STUBBLE_DEPTH_MM = 2.0
"""How far below the skin the shell of a clipped head lies: only its ribbons show."""

_MOST_HANG_MM = 32.0
_HANG_AFTER_MM = 70.0
_CRANIUM = slice(0, 30)


@dataclass(frozen=True)
class Shell:
    """The surface of the hair, with room beyond its edge.

    Attributes:
        points: ``(COLUMNS, ROWS + 3, 3)``, mm, or of every so-many-th column; the last three rows
            lie beyond the edge.
        outward: ``(COLUMNS, ROWS + 3, 3)`` unit vectors off the skin.
        height: ``(COLUMNS, ROWS + 3)`` distance off the skin, mm.
    """

    points: _Floats
    outward: _Floats
    height: _Floats

    @property
    def vertices(self) -> _Floats:
        """What the mesh has of it, ``(COLUMNS * ROWS, 3)``, mm."""
        return self.points[:, :ROWS].reshape(-1, 3)


@dataclass(frozen=True)
class _Bed:
    """What hair lies on: the chart, the skull's centre, and how wide skin and ears are."""

    chart: _Floats
    centre: _Floats
    skin_radius: _Floats
    ears_radius: _Floats | None


def shell_rows() -> _Floats:
    """Return the share of its length at which each row of a column lies, ``(ROWS,)`` in 0..1."""
    return np.asarray(1.0 - (1.0 - np.linspace(0.0, 1.0, ROWS)) ** 1.2)


def strand_stream(seed: int) -> np.random.Generator:
    """Return what the shell and then the ribbons of one head of hair are drawn from."""
    return np.random.default_rng([seed, 3])


def lay_shell(
    parameters: Mapping[str, Any],
    skin_vertices: NDArray[np.float32],
    rng: np.random.Generator,
    every: int = 1,
) -> Shell:
    """Lay the hair on one head.

    Args:
        parameters: Of one head of hair, see :mod:`lrsr.identities.hair.styles`.
        skin_vertices: ``(V, 3)``, mm, in the template's topology.
        rng: Of clumps and ragged edges, see :func:`strand_stream`.
        every: Of so many columns one is laid.
    """
    bed = _make_bed(parameters, skin_vertices)
    paths = plan_paths(parameters, bed.chart, rng).every(every)
    course = _run(parameters, paths)
    points = _hang(parameters, bed, paths, course)
    outward = points - bed.centre
    outward[..., 1] *= 1.0 - np.clip(course.down / 40.0, 0.0, 1.0)
    outward /= np.linalg.norm(outward, axis=-1, keepdims=True)
    height, fade = lay_thickness(parameters, paths, course)
    noise = [values[::every] for values in _draw_noise(parameters, rng)]
    lift, aside = _style(parameters, paths, course, fade, noise)
    height = height + lift
    if parameters["sunk_mm"] > 0:
        height = np.full_like(height, -parameters["sunk_mm"])
    elif parameters["stubble_mm"] > 0:
        height = np.full_like(height, -_STUBBLE_DEPTH_MM)
    points += outward * height[..., None]
    points[..., 0] += outward[..., 2] * aside
    points[..., 2] -= outward[..., 0] * aside
    return Shell(points, outward, height)


def _make_bed(parameters: Mapping[str, Any], skin_vertices: NDArray[np.float32]) -> _Bed:
    anchors = load_anchors()
    chart = anchors.locate(skin_vertices)
    shift = (chart[:, _CRANIUM] - anchors.template[:, _CRANIUM]).mean(axis=(0, 1))
    centre = np.asarray(SKULL_CENTRE_MM) + shift
    covers_ears = parameters["low_side_mm"] < AT_HAIRLINE_MM
    ears = measure_ears(skin_vertices[anchors.ears], centre) if covers_ears else None
    return _Bed(chart, centre, measure_skin(chart, centre), ears)


def _run(parameters: Mapping[str, Any], paths: Paths) -> Course:
    """Place the rows on the columns."""
    length = paths.length_mm[:, None]
    beyond = (1.1 - 0.1 * paths.free[:, None]) * np.asarray(BEYOND_MM)
    along = np.concatenate([shell_rows() * length, length + beyond], axis=1)
    over_skull = paths.over_skull_mm[:, None]
    flat = follow_paths(paths, along / over_skull, parameters["bow"])
    azimuth = np.rad2deg(np.arctan2(flat[..., 0], flat[..., 1]))
    polar = np.hypot(flat[..., 0], flat[..., 1])
    return Course(along, np.maximum(along - over_skull, 0.0), azimuth, polar)


def _style(
    parameters: Mapping[str, Any],
    paths: Paths,
    course: Course,
    fade: _Floats,
    noise: Sequence[_Floats],
) -> tuple[_Floats, _Floats]:
    """Clump, wave and comb aside: return shifts off the skin and to the subject's left, mm."""
    clump, start, bend = noise
    phase = 2.0 * np.pi * (course.along / parameters["wave_period_mm"] + start)
    swing = parameters["wave_mm"] * smoothstep(25.0, 85.0, course.along) * fade
    share = np.clip(course.along / paths.length_mm[:, None], 0.0, 1.0)
    free = paths.free[:, None]
    loose = free * smoothstep(0.35, 1.0, share)
    smooth = 0.5 + 0.5 * min(parameters["curl_mm"] / 3.0, 1.0)
    lift = smooth * parameters["clump_mm"] * clump * fade + 0.5 * swing * np.cos(phase)
    lift = lift + parameters["flare_mm"] * loose**3
    bend = bend * np.sin(np.pi * np.clip(share - 0.3, 0.0, 0.7) / 0.7)
    front = smoothstep(58.0, 38.0, np.abs(paths.azimuth))[:, None]
    aside = swing * np.sin(phase) + parameters["sway_mm"] * bend * free
    aside = aside + parameters["sweep_mm"] * front * share**2
    aside = aside - 0.12 * parameters["clump_scale_mm"] * paths.tuft[:, None] * loose
    return lift, aside


def _draw_noise(
    parameters: Mapping[str, Any], rng: np.random.Generator
) -> tuple[_Floats, _Floats, _Floats]:
    """Draw clumps ``(COLUMNS, ROWS + 3)``, where waves start, how columns bend ``(COLUMNS, 1)``."""
    clump = smooth_noise(rng, (COLUMNS, ROWS + len(BEYOND_MM)), _clump_widths(parameters))
    start = 0.35 * smooth_noise(rng, (COLUMNS,), (9.0,))[:, None]
    return clump, start, smooth_noise(rng, (COLUMNS,), (12.0,))[:, None]


def _clump_widths(parameters: Mapping[str, Any]) -> tuple[float, float]:
    """Blur of the clump noise in columns and rows: long along straight strands, round in curls."""
    across = parameters["clump_scale_mm"] / 4.0
    curly = float(np.clip(parameters["curl_mm"] / 3.0, 0.0, 1.0))
    return across, (1.0 - curly) * 9.0 + curly * 1.4


def _hang(parameters: Mapping[str, Any], bed: _Bed, paths: Paths, course: Course) -> _Floats:
    """Put the rows on the skin; past the skull let them go down, off the skin and the ears."""
    points = sample_chart(bed.chart, course.azimuth, course.polar)
    leaves = course.down > 0.0
    edge = sample_chart(bed.chart, paths.azimuth, np.linalg.norm(paths.leave, axis=1)) - bed.centre
    width = np.hypot(edge[:, 0], edge[:, 2])[:, None]
    heading = edge[:, [0, 2]] / np.maximum(width, 1e-6)
    top = bed.centre[1] + edge[:, 1:2]
    y = np.where(leaves, top - course.down, points[..., 1])
    columns = np.broadcast_to(paths.azimuth[:, None], y.shape)
    surface = sample_level(bed.skin_radius, columns, y)
    step = width - sample_level(bed.skin_radius, paths.azimuth[:, None], top)
    surface += step * np.exp(-course.down / 30.0)
    if bed.ears_radius is not None:
        surface = np.maximum(surface, sample_level(bed.ears_radius, columns, y))
    flat = points[..., [0, 2]] - bed.centre[[0, 2]]
    radius = np.where(leaves, surface, np.linalg.norm(flat, axis=-1))
    widest = np.maximum.accumulate(radius, axis=1)
    off = smoothstep(0.0, _HANG_AFTER_MM, course.down) * parameters["hang"]
    radius += off * np.minimum(widest - radius, _MOST_HANG_MM)
    x, z = (bed.centre[axis] + heading[:, [k]] * radius for k, axis in enumerate((0, 2)))
    hanging = np.stack([x, y, z], axis=-1)
    return np.where(leaves[..., None], hanging, points)
