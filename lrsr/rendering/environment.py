"""What light comes from far away, and how much does a meter at the face read of all light?"""

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from lrsr.errors import InputError
from lrsr.rendering.colour import LUMINANCE
from lrsr.rendering.lighting import Lighting
from lrsr.rendering.lights import Panel
from lrsr.rendering.panorama import load_map

_Floats = NDArray[np.float64]

_MAP_HEIGHT_PX = 64
"""Rows of the environment map, one per 2.9°; twice as many columns."""

_PANEL_STEPS = 24
"""Points along each side of a panel at which the meter looks at it."""


def lambert_phase(angle_rad: _Floats) -> _Floats:
    """Return the mean radiance of a white Lambertian sphere's disc, lit from that phase angle.

    In units of E/π, E the irradiance of a facing surface: (2/3)(sin θ + (π − θ) cos θ)/π, Lambert's
    phase law. Full light gives 2/3, and light from everywhere averages to that of a plane.

    Args:
        angle_rad: Between the directions to the light and to the viewer, 0..π, any shape.

    Example:
        >>> lambert_phase(np.array([0.0, np.pi])).round(4).tolist()
        [0.6667, 0.0]
    """
    angle = np.asarray(angle_rad, dtype=np.float64)
    law = np.sin(angle) + (np.pi - angle) * np.cos(angle)
    return np.asarray(2 / 3 * law / np.pi)


@lru_cache(maxsize=64)
def environment(lighting: Lighting) -> tuple[NDArray[np.float32], float]:
    """Paint what is far away as a latitude-longitude map, and meter the whole lighting.

    Row 0 is the zenith (+y) and the last row the nadir; column x looks at the longitude
    φ = 2π (x + 0.5) / W, with the direction (sin φ sin θ, cos θ, -cos φ sin θ): the camera (+z) is
    in the middle. This is Mitsuba's ``envmap``.

    Returns:
        The map, ``(H, 2H, 3)`` float32, radiance, linear sRGB; and what is metered: the luminance
        of an 18 % grey Lambertian sphere's disc as the level camera sees it, divided by 0.18
        (:attr:`Radiance.metered`), summed over the very map, so exact for any light, and over the
        panels as seen from between the eyes.

    Raises:
        InputError: The lighting's map cannot be used.
    """
    directions, solid_angles = map_grid()
    radiance = _paint_lights(lighting, directions, solid_angles)
    phase = lambert_phase(np.arccos(np.clip(directions[..., 2], -1, 1)))
    room, free = _room(lighting, phase * solid_angles / math.pi), 1.0
    if lighting.panels:  # they hide what is behind them
        hidden = np.any([hides(panel, directions) for panel in lighting.panels], axis=0)
        fill = room * lighting.fill_colour @ LUMINANCE
        free -= float((fill * phase * solid_angles * hidden).sum()) / math.pi
        phase = phase * ~hidden
    key = float((radiance @ LUMINANCE * phase * solid_angles).sum()) / math.pi
    key += sum(panel_metered(panel) for panel in lighting.panels)
    lit = bool(lighting.lights or lighting.panels)
    metered = key / (1 - lighting.fill_share * free) if lit else 1.0
    radiance += lighting.fill_share * metered * lighting.fill_colour * room
    painted = radiance.astype(np.float32)
    painted.flags.writeable = False
    return painted, metered


def _paint_lights(lighting: Lighting, directions: _Floats, solid_angles: _Floats) -> _Floats:
    """Return the radiance of the far discs, ``(H, 2H, 3)``."""
    radiance = np.zeros((*solid_angles.shape, 3))
    for light in lighting.lights:
        angle = np.arccos(np.clip(directions @ light.direction(), -1, 1))
        edge = math.pi / (_MAP_HEIGHT_PX - 1)  # a pixel wide: small discs keep their shape
        disc = np.clip((math.radians(light.diameter_deg) / 2 - angle) / edge + 0.5, 0, 1)
        facing = np.clip(directions @ light.direction(), 0, None)
        level = light.irradiance / float((disc * facing * solid_angles).sum())
        radiance += level * disc[..., None] * light.colour
    return radiance


def _room(lighting: Lighting, meter: _Floats) -> _Floats:
    """Return the lighting's map, ``(H, 2H, 3)``, scaled so that a meter reads 1 in its fill.

    Without a map everything is 1.

    Raises:
        InputError: The map cannot be used, or is black.
    """
    if lighting.map is None:
        return np.ones((*meter.shape, 3))
    room = load_map(lighting.map, lighting.map_deg, _MAP_HEIGHT_PX)
    read = float((room * lighting.fill_colour @ LUMINANCE * meter).sum())
    if not read > 0:
        raise InputError(f"map {lighting.map} lights nothing: it is black on all sides of the face")
    return room / read


def hides(panel: Panel, directions: _Floats) -> NDArray[np.bool_]:
    """Return which directions ``(..., 3)`` from between the eyes a panel lies in."""
    matrix = panel.to_world()
    ahead = -(directions @ matrix[:3, 2])
    scale = panel.distance_mm / np.where(ahead > 1e-9, ahead, np.inf)
    offset = directions * scale[..., None] - matrix[:3, 3]
    half = np.array([panel.width_mm, panel.height_mm]) / 2
    along = np.abs(offset @ (matrix[:3, :2] / half)) / half
    return np.asarray((ahead > 1e-9) & (along <= 1).all(axis=-1))


def panel_radiance(panel: Panel) -> float:
    """Return the luminance of a panel that gives its irradiance between the eyes."""
    distance_mm, cosines, area = _seen(panel)
    facing = distance_mm[1] @ np.array(panel.position_mm) / panel.distance_mm
    unit = float((np.clip(facing, 0, None) * cosines * area / distance_mm[0] ** 2).sum())
    return panel.irradiance / unit


def panel_metered(panel: Panel) -> float:
    """Return what a panel adds to the meter between the eyes."""
    (distance_mm, towards), cosines, area = _seen(panel)
    phase = lambert_phase(np.arccos(np.clip(towards[:, 2], -1, 1)))
    seen = float((phase * cosines * area / distance_mm**2).sum())
    return panel_radiance(panel) * seen / math.pi


def _seen(panel: Panel) -> tuple[tuple[_Floats, _Floats], _Floats, float]:
    """Return points of a panel as seen from between the eyes.

    Returns:
        distances and directions: ``(N,)`` mm and ``(N, 3)``.
        cosines: ``(N,)``, between its normal and the way to the eyes.
        area: Of each point, mm².
    """
    steps = (np.arange(_PANEL_STEPS) + 0.5) / _PANEL_STEPS * 2 - 1
    x, y = (axis.ravel() for axis in np.meshgrid(steps, steps))
    square = np.stack([x, y, 0 * x, np.ones_like(x)], axis=1)
    matrix = panel.to_world()
    points = (square @ matrix.T)[:, :3]
    distance = np.linalg.norm(points, axis=1)
    towards = points / distance[:, None]
    area = panel.width_mm * panel.height_mm / _PANEL_STEPS**2
    return (distance, towards), -(towards @ matrix[:3, 2]), area


def map_grid() -> tuple[_Floats, _Floats]:
    """Return directions ``(H, 2H, 3)`` and solid angles ``(H, 2H)`` that sum to 4π."""
    theta = np.linspace(0, np.pi, _MAP_HEIGHT_PX)
    phi = 2 * np.pi * (np.arange(2 * _MAP_HEIGHT_PX) + 0.5) / (2 * _MAP_HEIGHT_PX)
    theta, phi = np.meshgrid(theta, phi, indexing="ij")
    directions = np.stack(
        [np.sin(phi) * np.sin(theta), np.cos(theta), -np.cos(phi) * np.sin(theta)], axis=-1
    )
    weights = np.sin(theta)
    return directions, np.asarray(4 * np.pi * weights / weights.sum())
