"""How thick does hair lie on the skin? Full on the skull, thin at tips, nothing at a hairline."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lrsr.identities.hair.chart import flatten
from lrsr.identities.hair.paths import Paths
from lrsr.identities.ramp import smoothstep

_Floats = NDArray[np.float64]

_ROOT_DEPTH_MM = 2.4
_SUNK_MM = 11.0
"""At a hairline the shell rises from under the skin, so that single hairs come first."""

_GONE_DEPTH_MM = 5.0
_BUN_RADIUS_DEG = 20.0


class Course(NamedTuple):
    """Every row of every column on its way, each ``(COLUMNS, rows)``.

    Attributes:
        along: From the root, mm.
        down: Since it left the skull, mm.
        azimuth: Degrees; where it left the skull, once it has.
        polar: Degrees; likewise.
    """

    along: _Floats
    down: _Floats
    azimuth: _Floats
    polar: _Floats


def lay_thickness(
    parameters: Mapping[str, Any], paths: Paths, course: Course
) -> tuple[_Floats, _Floats]:
    """Return how far the hair stands off the skin.

    Args:
        parameters: Of one head of hair.
        paths: Its columns.
        course: Their rows.

    Returns:
        Height off the skin, mm, negative below it, and the share that hair has not faded at an
        edge, 0..1; each ``(COLUMNS, rows)``.
    """
    full = _full_thickness(parameters, paths, course)
    height, fade = _fade_at_tips(parameters, paths, course, full)
    leading = paths.leading[:, None]
    bare = np.where(course.down > 0.0, 0.4 * height, -1.2)
    height = bare + leading * (height - bare)
    fade = fade * leading
    if parameters["bald_deg"] > 0:
        rim = smoothstep(0.0, 0.8 * parameters["taper_mm"], course.along)
        height = height * rim - _ROOT_DEPTH_MM * (1.0 - smoothstep(0.0, 6.0, course.along))
        grows = smoothstep(8.0, 24.0, paths.over_skull_mm)[:, None]
        height = grows * height - _GONE_DEPTH_MM * (1.0 - grows)
        fade = fade * rim
    return height, fade


def _full_thickness(parameters: Mapping[str, Any], paths: Paths, course: Course) -> _Floats:
    """Thickness away from all edges: top, sides and back, the front's lift, the parting's dip."""
    top = smoothstep(78.0, 40.0, course.polar)
    back = smoothstep(95.0, 130.0, np.abs(course.azimuth))
    sides = (1.0 - back) * parameters["side_mm"] + back * parameters["back_mm"]
    lift = np.exp(-(((course.polar - 50.0) / 15.0) ** 2) - (course.azimuth / 40.0) ** 2)
    full = top * parameters["top_mm"] + (1.0 - top) * sides + parameters["front_lift_mm"] * lift
    full = full + _bun(parameters, course)
    dip = parameters["parting_dip"] * np.exp(-((course.along / 9.0) ** 2))
    return np.asarray(full * (1.0 - dip * np.minimum(1.0, 4.0 * paths.on_parting[:, None])))


def _bun(parameters: Mapping[str, Any], course: Course) -> _Floats:
    """Rise as a knot of hair on the back of the crown."""
    centre = np.array([0.0, parameters["bun_z_deg"]])
    away = np.linalg.norm(flatten(course.azimuth, course.polar) - centre, axis=-1)
    round_ = np.clip(1.0 - (away / _BUN_RADIUS_DEG) ** 2, 0.0, 1.0) ** 0.6
    return np.asarray(max(parameters["bun_mm"], 0.0) * round_)


def _fade_at_tips(
    parameters: Mapping[str, Any], paths: Paths, course: Course, full: _Floats
) -> tuple[_Floats, _Floats]:
    """Sink into the skin at a hairline; thin out to the tips where they hang free."""
    left = paths.length_mm[:, None] - course.along
    inner = np.clip(left / parameters["taper_mm"], 0.0, 1.0)
    fade = smoothstep(0.0, 1.0, inner)
    fade = fade + parameters["roundness"] * (np.sqrt(inner * (2.0 - inner)) - fade)
    close = full * fade - _ROOT_DEPTH_MM * (1.0 - smoothstep(0.0, _SUNK_MM, left))
    share = smoothstep(
        0.0, 1.0, course.down / np.maximum(course.down.max(axis=1, keepdims=True), 1.0)
    )
    hanging = full + share * (np.minimum(parameters["tip_mm"], full) - full)
    free = paths.free[:, None]
    return close + free * (hanging - close), fade + free * (1.0 - fade)
