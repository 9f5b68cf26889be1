"""How is hair combed? Where strands start, where they leave the skull, how long they are.

Degrees of the flattened chart (:func:`lrsr.identities.hair.chart.flatten`) and millimetres along
the strand; the head's own shape enters by its chart only.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from lrsr.identities.hair.chart import flatten, sample_chart
from lrsr.identities.hair.scalp import MM_PER_DEG, bald_polar, hairline_polar
from lrsr.identities.hair.styles import AT_HAIRLINE_MM, LOWER_AZIMUTHS_DEG
from lrsr.identities.ramp import smoothstep

_Floats = NDArray[np.float64]

COLUMNS = 288

_HANG_POLAR_DEG = 80.0
_PARTING_POLAR_DEG = 56.0
_COLUMN_MM = 2.1
_FRINGE_ABOVE_MM = 22.0
_RETREAT_MM = (8.0, 4.0)
"""The shell ends this far before a hairline, and before free tips: strands carry the edge."""


@dataclass(frozen=True)
class Paths:
    """Columns of strands, from the front by the subject's left and the back to the front again.

    Attributes:
        azimuth: ``(COLUMNS,)`` where they leave the skull, degrees.
        root: ``(COLUMNS, 2)`` flattened chart, degrees.
        leave: ``(COLUMNS, 2)`` flattened chart, degrees.
        over_skull_mm: ``(COLUMNS,)`` length of the way from root to where they leave the skull.
        length_mm: ``(COLUMNS,)`` length to the tip, >= 1; shorter than ``over_skull_mm`` if cut.
        on_parting: ``(COLUMNS,)`` 1 = root at the front end of the parting, 0 = at the whorl.
        leading: ``(COLUMNS,)`` 0 = the open front edge of parted hair, 1 = not near it.
        free: ``(COLUMNS,)`` 1 = the tips hang free, 0 = they end at the hairline.
        tuft: ``(COLUMNS,)`` -1..1 from one side of a tuft to the other.
    """

    azimuth: _Floats
    root: _Floats
    leave: _Floats
    over_skull_mm: _Floats
    length_mm: _Floats
    on_parting: _Floats
    leading: _Floats
    free: _Floats
    tuft: _Floats

    def every(self, step: int) -> "Paths":
        """Return one of so many columns."""
        return Paths(**{field.name: getattr(self, field.name)[::step] for field in fields(self)})


def plan_paths(parameters: Mapping[str, Any], chart: _Floats, rng: np.random.Generator) -> Paths:
    """Comb one head of hair.

    Args:
        parameters: Of one head of hair.
        chart: ``(AZIMUTHS, POLARS, 3)`` of the head, mm.
        rng: Of tufts and ragged edges.
    """
    u = np.linspace(0.0, 1.0, COLUMNS)
    side, frontness = np.where(u < 0.5, 1.0, -1.0), np.abs(1.0 - 2.0 * u)
    first = _first_azimuth(parameters, side)
    azimuth = side * (first + (180.0 - first) * (1.0 - frontness))
    leave_polar, drop, cut = _leave(parameters, chart, azimuth)
    leave = flatten(azimuth, leave_polar)
    root, on_parting = _roots(parameters, frontness)
    if parameters["bald_deg"] > 0:
        rim = bald_polar(azimuth, parameters["bald_deg"])
        root = flatten(azimuth, np.minimum(rim, leave_polar - 1.0))
    over_skull = np.maximum(np.linalg.norm(leave - root, axis=1) * MM_PER_DEG, 1.0)
    tuft = _group_tufts(parameters["clump_scale_mm"], rng)
    ragged = smooth_noise(rng, (COLUMNS,), (5.0,), spread=0.3) + 0.25 * np.abs(tuft)
    framing = np.clip(1.0 - np.abs(np.abs(azimuth) - first) / 40.0, 0.0, 1.0) * (drop > 60.0)
    free = smoothstep(6.0, 14.0, drop)
    retreat = _RETREAT_MM[0] + free * (_RETREAT_MM[1] - _RETREAT_MM[0])
    length = over_skull + drop - cut - retreat - parameters["ragged_mm"] * ragged
    length -= parameters["layer_mm"] * framing**1.5
    closed = parameters["front_left_deg"] == 0.0
    return Paths(
        azimuth=azimuth,
        root=root,
        leave=leave,
        over_skull_mm=over_skull,
        length_mm=np.maximum(length, 1.0),
        on_parting=on_parting,
        leading=np.ones(COLUMNS) if closed else smoothstep(0.0, 0.06, 1.0 - frontness),
        free=free,
        tuft=tuft,
    )


def follow_paths(paths: Paths, share: _Floats, bow: float) -> _Floats:
    """Return points of each column on its way over the skull.

    Args:
        paths: The columns.
        share: ``(COLUMNS, rows)`` of the way; past 1 stays where the column leaves the skull.
        bow: How far parted strands swing to the front on their way, as a share of it.

    Returns:
        ``(COLUMNS, rows, 2)``, flattened chart, degrees; quadratic Bézier curves.
    """
    t = np.clip(share, 0.0, 1.0)[..., None]
    root, leave = paths.root[:, None, :], paths.leave[:, None, :]
    reach = np.linalg.norm(leave - root, axis=-1, keepdims=True)
    middle = 0.5 * (root + leave)
    middle[..., 1:] += bow * reach * paths.on_parting[:, None, None]
    return np.asarray((1 - t) ** 2 * root + 2 * t * (1 - t) * middle + t**2 * leave)


def _group_tufts(width_mm: float, rng: np.random.Generator) -> _Floats:
    """Group neighbouring columns: ``(COLUMNS,)``, -1..1 from one side of a tuft to the other."""
    widths = max(width_mm / _COLUMN_MM, 2.0) * rng.uniform(0.5, 1.5, COLUMNS)
    ends = np.cumsum(widths)
    columns = np.arange(COLUMNS, dtype=np.float64)
    which = np.searchsorted(ends, columns, side="right")
    return np.asarray(1.0 - 2.0 * (ends[which] - columns) / widths[which])


def smooth_noise(
    rng: np.random.Generator, shape: tuple[int, ...], widths: tuple[float, ...], spread: float = 1.0
) -> _Floats:
    """Return blurred noise of zero mean and the given standard deviation, wrapping around."""
    values = gaussian_filter(rng.normal(size=shape), widths, mode="wrap")
    return np.asarray(spread * (values - values.mean()) / max(float(values.std()), 1e-12))


def _parting_azimuth(parameters: Mapping[str, Any]) -> float:
    return float(np.rad2deg(np.arctan2(parameters["parting_deg"], _PARTING_POLAR_DEG)))


def _first_azimuth(parameters: Mapping[str, Any], side: _Floats) -> _Floats:
    """How far from the middle the first column of each side leaves the skull, degrees."""
    parting = _parting_azimuth(parameters)
    left = parameters["front_left_deg"] or parting
    right = parameters["front_right_deg"] or -parting
    return np.where(side > 0, left, right)


def _leave(
    parameters: Mapping[str, Any], chart: _Floats, azimuth: _Floats
) -> tuple[_Floats, _Floats, _Floats]:
    """Where columns leave the skull (polar angle), how far they go down from there, how far cut."""
    hairline = _trimmed_hairline(parameters, azimuth)
    low = np.interp(np.abs(azimuth), LOWER_AZIMUTHS_DEG, parameters["lower_mm"])
    hangs = low < sample_chart(chart, azimuth, hairline)[:, 1]
    polar = np.where(hangs, np.minimum(hairline, _HANG_POLAR_DEG), hairline)
    fringe = parameters["fringe_mm"] + parameters["fringe_tilt_mm"] * np.sin(np.deg2rad(azimuth))
    fringe = fringe + parameters["fringe_arch_mm"] * (azimuth / 45.0) ** 2
    end = 54.0 if parameters["lower_mm"][2] == AT_HAIRLINE_MM else 70.0
    fringe = fringe * smoothstep(end, end - 14.0, np.abs(azimuth))
    height = sample_chart(chart, azimuth, polar)[:, 1]
    above_brows = np.maximum(height - _FRINGE_ABOVE_MM, 0.0)
    drop = np.where(hangs, height - low, np.clip(fringe, 0.0, above_brows))
    return polar, drop, np.maximum(-fringe, 0.0)


def _trimmed_hairline(parameters: Mapping[str, Any], azimuth: _Floats) -> _Floats:
    """The natural hairline, cut higher above the ears and at the nape."""
    away = np.abs(azimuth)
    side = smoothstep(60.0, 75.0, away) * smoothstep(122.0, 107.0, away)
    back = smoothstep(115.0, 140.0, away)
    trim = parameters["trim_side_deg"] * side + parameters["trim_back_deg"] * back
    return np.asarray(hairline_polar(azimuth, parameters) - trim)


def _roots(parameters: Mapping[str, Any], frontness: _Floats) -> tuple[_Floats, _Floats]:
    """Roots in the flattened chart, and how far each lies along the parting."""
    crown = np.array(
        [parameters["crown_x_deg"] + 0.8 * parameters["parting_deg"], parameters["crown_z_deg"]]
    )
    if parameters["parting_length"] == 0.0:
        return np.broadcast_to(crown, (COLUMNS, 2)), np.zeros(COLUMNS)
    azimuth = np.array([_parting_azimuth(parameters)])
    front = flatten(azimuth, hairline_polar(azimuth, parameters) - 1.0)[0]
    whorl = front + parameters["parting_length"] * (crown - front)
    on_parting = smoothstep(0.1, 1.0, frontness)
    return whorl + on_parting[:, None] * (front - whorl), on_parting
