"""Which styles of hair are there? Tables of ranges that a person's numbers are drawn from.

A style is a set of plain numbers: where strands start (a parting or a whorl), where they end (the
hairline or a lower edge in mm), how thick the hair lies on the skull, and how it clumps and waves.
:mod:`lrsr.identities.hair.hair` turns the numbers into one mesh, the same mesh for all styles.

Positions on the skull are degrees of the chart in :mod:`lrsr.identities.hair.anchors`; heights are
mm in the template's head frame (0 = pupils, about -105 = chin).
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

_Range = tuple[float, float]

LOWER_AZIMUTHS_DEG = (0.0, 35.0, 60.0, 85.0, 115.0, 180.0)
"""Azimuths of the six numbers of ``lower_mm``: brow, temple, cheek, ear, behind the ear, nape."""

AT_HAIRLINE_MM = 300.0
"""A lower edge above everything: strands end at the hairline."""

# Ranges shared by short hair. ``side_mm`` and ``back_mm`` up to 1 are shares of ``top_mm``.
_SHORT: dict[str, _Range] = {
    "parting_deg": (0.0, 0.0),
    "parting_length": (0.0, 0.0),
    "crown_x_deg": (-6.0, 6.0),
    "crown_z_deg": (-30.0, -16.0),
    "front_left_deg": (0.0, 0.0),
    "front_right_deg": (0.0, 0.0),
    "bow": (0.0, 0.0),
    "top_mm": (10.0, 20.0),
    "side_mm": (4.0, 10.0),
    "back_mm": (5.0, 11.0),
    "front_lift_mm": (0.0, 6.0),
    "lean_mm": (-4.0, 4.0),
    "taper_mm": (14.0, 26.0),
    "tip_mm": (2.0, 4.0),
    "parting_dip": (0.0, 0.0),
    "hang": (0.0, 0.0),
    "wave_mm": (0.0, 0.8),
    "wave_period_mm": (30.0, 50.0),
    "clump_mm": (1.0, 2.2),
    "clump_scale_mm": (7.0, 14.0),
    "ragged_mm": (4.0, 8.0),
    "roundness": (0.0, 0.0),
    "curl_mm": (0.0, 1.0),
    "flyaway_mm": (1.0, 2.5),
    "sway_mm": (0.0, 1.5),
    "flare_mm": (0.0, 0.0),
    "layer_mm": (0.0, 0.0),
    "density": (0.9, 1.0),
    "trim_side_deg": (0.0, 5.0),
    "trim_back_deg": (0.0, 10.0),
    "bald_deg": (0.0, 0.0),
    "sunk_mm": (0.0, 0.0),
    "stubble_mm": (0.0, 0.0),
}

_LONG: dict[str, _Range] = _SHORT | {
    "parting_length": (0.7, 1.0),
    "parting_deg": (-6.0, 6.0),
    "front_left_deg": (40.0, 60.0),
    "front_right_deg": (40.0, 60.0),
    "bow": (0.05, 0.3),
    "top_mm": (9.0, 20.0),
    "side_mm": (7.0, 20.0),
    "back_mm": (8.0, 18.0),
    "front_lift_mm": (0.0, 5.0),
    "taper_mm": (8.0, 16.0),
    "tip_mm": (5.0, 9.0),
    "parting_dip": (0.5, 0.8),
    "hang": (0.85, 1.0),
    "clump_mm": (1.5, 3.0),
    "clump_scale_mm": (9.0, 18.0),
    "ragged_mm": (4.0, 12.0),
    "sway_mm": (2.0, 6.0),
    "flare_mm": (-6.0, 6.0),
    "layer_mm": (0.0, 45.0),
    "trim_side_deg": (0.0, 0.0),
    "trim_back_deg": (0.0, 0.0),
}

_RANGES: dict[str, dict[str, _Range]] = {
    "shaved": _SHORT | {"sunk_mm": (10.0, 10.0), "density": (0.12, 0.6)},
    "buzz": _SHORT
    | {
        "top_mm": (2.0, 5.0),
        "side_mm": (1.2, 3.0),
        "back_mm": (1.5, 3.0),
        "front_lift_mm": (0.0, 0.5),
        "lean_mm": (0.0, 0.0),
        "taper_mm": (8.0, 14.0),
        "clump_mm": (0.2, 0.5),
        "flyaway_mm": (0.2, 0.6),
        "wave_mm": (0.0, 0.0),
        "stubble_mm": (1.0, 4.0),
        "density": (0.6, 0.9),
    },
    "crop": _SHORT
    | {"fringe_mm": (-6.0, 18.0), "fringe_tilt_mm": (-10.0, 10.0), "sweep_mm": (-14.0, 14.0)},
    "side_parting": _SHORT
    | {
        "parting_deg": (16.0, 30.0),
        "parting_length": (0.8, 1.0),
        "front_left_deg": (34.0, 44.0),
        "front_right_deg": (46.0, 62.0),
        "bow": (0.1, 0.35),
        "top_mm": (11.0, 20.0),
        "side_mm": (5.0, 10.0),
        "front_lift_mm": (3.0, 14.0),
        "parting_dip": (0.5, 0.9),
    },
    "receding": _SHORT
    | {
        "top_mm": (4.0, 10.0),
        "hairline_deg": (4.0, 14.0),
        "recession_deg": (8.0, 18.0),
        "density": (0.55, 0.85),
        "taper_mm": (20.0, 35.0),
    },
    "horseshoe": _SHORT
    | {
        "bald_deg": (44.0, 60.0),
        "side_mm": (2.5, 5.0),
        "back_mm": (2.5, 6.0),
        "density": (0.6, 0.95),
        "taper_mm": (24.0, 36.0),
    },
    "quiff": _SHORT
    | {
        "crown_z_deg": (-52.0, -40.0),
        "top_mm": (12.0, 22.0),
        "side_mm": (2.5, 6.0),
        "front_lift_mm": (8.0, 24.0),
        "taper_mm": (10.0, 18.0),
        "clump_mm": (1.5, 3.0),
        "trim_side_deg": (0.0, 8.0),
    },
    "slicked_back": _SHORT
    | {
        "crown_z_deg": (-70.0, -55.0),
        "top_mm": (5.0, 11.0),
        "side_mm": (4.0, 8.0),
        "back_mm": (7.0, 12.0),
        "clump_mm": (0.8, 1.8),
        "taper_mm": (12.0, 20.0),
    },
    "curly": _SHORT
    | {
        "top_mm": (14.0, 28.0),
        "side_mm": (0.4, 0.8),
        "back_mm": (0.4, 0.8),
        "roundness": (0.0, 0.7),
        "clump_mm": (3.0, 5.5),
        "clump_scale_mm": (7.0, 11.0),
        "curl_mm": (2.4, 4.5),
        "flyaway_mm": (2.5, 5.0),
        "fringe_mm": (-4.0, 22.0),
        "taper_mm": (8.0, 16.0),
    },
    "long_curly": _LONG
    | {
        "parting_deg": (-22.0, 22.0),
        "low_side_mm": (-190.0, -75.0),
        "low_back_mm": (-190.0, -85.0),
        "top_mm": (14.0, 28.0),
        "side_mm": (16.0, 30.0),
        "back_mm": (14.0, 28.0),
        "wave_mm": (3.0, 7.0),
        "wave_period_mm": (24.0, 40.0),
        "clump_mm": (3.0, 5.5),
        "clump_scale_mm": (7.0, 12.0),
        "curl_mm": (2.6, 4.5),
        "flyaway_mm": (3.0, 6.0),
        "flare_mm": (-4.0, 14.0),
        "hang": (0.7, 0.95),
    },
    "afro": _SHORT
    | {
        "top_mm": (22.0, 58.0),
        "side_mm": (0.55, 0.95),
        "back_mm": (0.5, 0.9),
        "roundness": (0.7, 1.0),
        "trim_side_deg": (-4.0, 2.0),
        "crown_z_deg": (-16.0, -4.0),
        "clump_mm": (2.2, 4.0),
        "clump_scale_mm": (6.0, 9.0),
        "curl_mm": (2.2, 3.4),
        "flyaway_mm": (3.0, 6.0),
        "taper_mm": (26.0, 44.0),
        "ragged_mm": (3.0, 6.0),
    },
    "pixie": _SHORT
    | {
        "parting_deg": (14.0, 26.0),
        "parting_length": (0.5, 0.9),
        "crown_z_deg": (-30.0, -18.0),
        "top_mm": (12.0, 20.0),
        "side_mm": (7.0, 12.0),
        "fringe_mm": (8.0, 34.0),
        "fringe_tilt_mm": (-22.0, 22.0),
        "sweep_mm": (-24.0, 24.0),
        "ragged_mm": (8.0, 14.0),
    },
    "curtain": _LONG
    | {
        "low_side_mm": (-45.0, 5.0),
        "low_back_mm": (-80.0, -40.0),
        "front_left_deg": (44.0, 56.0),
        "front_right_deg": (44.0, 56.0),
        "hang": (0.5, 0.9),
        "front_lift_mm": (3.0, 10.0),
    },
    "bob": _LONG
    | {
        "parting_deg": (-22.0, 22.0),
        "low_side_mm": (-125.0, -60.0),
        "low_back_mm": (-115.0, -70.0),
        "tip_mm": (6.0, 12.0),
        "flare_mm": (-14.0, 10.0),
        "layer_mm": (-15.0, 20.0),
    },
    "long_straight": _LONG
    | {
        "parting_deg": (-18.0, 18.0),
        "low_side_mm": (-240.0, -150.0),
        "low_back_mm": (-240.0, -150.0),
    },
    "long_wavy": _LONG
    | {
        "parting_deg": (-22.0, 22.0),
        "low_side_mm": (-220.0, -110.0),
        "low_back_mm": (-220.0, -120.0),
        "wave_mm": (3.5, 8.0),
        "wave_period_mm": (38.0, 75.0),
        "side_mm": (10.0, 20.0),
        "back_mm": (10.0, 20.0),
        "clump_mm": (2.5, 5.0),
        "curl_mm": (1.5, 3.5),
        "flyaway_mm": (2.5, 5.0),
    },
    "fringe": _LONG
    | {
        "parting_length": (0.0, 0.0),
        "parting_deg": (0.0, 0.0),
        "front_left_deg": (0.0, 0.0),
        "front_right_deg": (0.0, 0.0),
        "parting_dip": (0.0, 0.0),
        "fringe_mm": (24.0, 54.0),
        "fringe_tilt_mm": (-10.0, 10.0),
        "fringe_arch_mm": (-2.0, 22.0),
        "sweep_mm": (-16.0, 16.0),
        "side_mm": (7.0, 17.0),
        "sway_mm": (0.5, 3.0),
        "low_side_mm": (-220.0, -70.0),
        "low_back_mm": (-220.0, -80.0),
    },
    "tucked": _LONG
    | {
        "parting_deg": (-18.0, 18.0),
        "low_back_mm": (-220.0, -90.0),
        "hang": (0.6, 0.9),
        "side_mm": (4.0, 9.0),
    },
    "pulled_back": _SHORT
    | {
        "crown_z_deg": (-90.0, -60.0),
        "top_mm": (4.0, 11.0),
        "side_mm": (3.0, 6.0),
        "bun_mm": (0.0, 48.0),
        "bun_z_deg": (-44.0, -16.0),
        "back_mm": (5.0, 10.0),
        "front_lift_mm": (0.0, 8.0),
        "taper_mm": (16.0, 28.0),
        "clump_mm": (0.6, 1.4),
        "ragged_mm": (4.0, 7.0),
        "trim_side_deg": (0.0, 0.0),
        "trim_back_deg": (0.0, 0.0),
    },
}

STYLES: tuple[str, ...] = tuple(_RANGES)

_ALL: dict[str, _Range] = {
    "hairline_deg": (-5.0, 5.0),
    "recession_deg": (-3.0, 4.0),
    "peak_deg": (-1.0, 4.0),
    "tilt_deg": (-2.0, 2.0),
    "sideburn_mm": (-12.0, 12.0),
    "nape_deg": (-8.0, 6.0),
    "fringe_mm": (0.0, 0.0),
    "low_side_mm": (AT_HAIRLINE_MM, AT_HAIRLINE_MM),
    "low_back_mm": (AT_HAIRLINE_MM, AT_HAIRLINE_MM),
    "fringe_tilt_mm": (0.0, 0.0),
    "fringe_arch_mm": (0.0, 0.0),
    "bun_mm": (0.0, 0.0),
    "bun_z_deg": (-30.0, -30.0),
    "sweep_mm": (0.0, 0.0),
}


def style_parameters(style: str, rng: np.random.Generator) -> dict[str, Any]:
    """Draw the numbers of one of :data:`STYLES`, colour excepted."""
    ranges = _ALL | _RANGES[style]
    values: dict[str, Any] = {"style": style}
    for key, (low, high) in ranges.items():
        values[key] = float(rng.uniform(low, high)) if high > low else float(low)
    if rng.random() < 0.5:
        values["parting_deg"] = -values["parting_deg"]
        left, right = values["front_left_deg"], values["front_right_deg"]
        values["front_left_deg"], values["front_right_deg"] = right, left
    for key in ("side_mm", "back_mm"):
        if values[key] <= 1.0:
            values[key] *= values["top_mm"]
    values["lower_mm"] = _lower_edge(values, rng)
    return values


def _lower_edge(values: Mapping[str, Any], rng: np.random.Generator) -> list[float]:
    """Return the heights of the lower edge at :data:`LOWER_AZIMUTHS_DEG`, mm."""
    side, back = values["low_side_mm"], values["low_back_mm"]
    if back == AT_HAIRLINE_MM:
        return [AT_HAIRLINE_MM] * 6
    if values["style"] == "tucked":
        return [AT_HAIRLINE_MM] * 4 + [back, back]
    behind = 0.5 * (side + back) + float(rng.uniform(-6.0, 6.0))
    front = AT_HAIRLINE_MM if values["front_left_deg"] == 0.0 else side
    if values["style"] == "fringe":
        return [AT_HAIRLINE_MM, AT_HAIRLINE_MM, side, side, behind, back]
    return [front, front, side, side, behind, back]
