"""How do people stand before a camera when nobody tells them to? Poses, lights, faces for training.

The ranges are estimated: a head that turns at most 35° still shows both eyes, and a room lights a
face with one or two lamps and whatever its walls send back.
"""

import numpy as np

from lrsr.identities.face.expression import EXPRESSIONS, Expression, find_expression
from lrsr.rendering.scene import LIGHTINGS, POSES, Light, Lighting, Pose

NAMED_SHARE = 0.3
"""How often one of the named poses or lightings is drawn instead of a random one."""


def random_pose(rng: np.random.Generator) -> Pose:
    """Draw a named pose, or yaw within ±35°, pitch within ±20° and roll within ±5°, uniform.

    Example:
        >>> abs(random_pose(np.random.default_rng(0)).yaw_deg) <= 35
        True
    """
    if rng.random() < NAMED_SHARE:
        return list(POSES.values())[rng.integers(len(POSES))]
    yaw, pitch, roll = (rng.uniform(-1, 1, 3) * (35, 20, 5)).round(2).tolist()
    return Pose("random", yaw_deg=yaw, pitch_deg=pitch, roll_deg=roll)


def random_lighting(rng: np.random.Generator) -> Lighting:
    """Draw a named lighting, or one or two lamps of any direction, size and warmth, and a fill.

    Example:
        >>> 1 <= len(random_lighting(np.random.default_rng(0)).lights) <= 2
        True
    """
    if rng.random() < NAMED_SHARE:
        return list(LIGHTINGS.values())[rng.integers(len(LIGHTINGS))]
    lamps = tuple(_lamp(rng) for _ in range(rng.integers(1, 3)))
    return Lighting(
        "random", lamps, fill_share=round(rng.uniform(0.15, 0.6), 3), fill_rgb=_white(rng)
    )


def random_expression(rng: np.random.Generator) -> Expression:
    """Draw a mild expression: a named one at 20 to 80 %, the lips perhaps parted.

    Nobody's eyes are more than half closed: pictures of a blink are usually thrown away.

    Example:
        >>> random_expression(np.random.default_rng(0)).name
        'random'
    """
    names = [name for name in EXPRESSIONS if name != "neutral"]
    name, strength = names[rng.integers(len(names))], round(rng.uniform(0.2, 0.8), 3)
    parted = round(max(0.0, rng.uniform(-0.15, 0.15)), 3)
    mild = find_expression(name, strength=0.6 * strength if name == "blink" else strength)
    jaw = min(1.0, mild.units.get("jawOpen", 0.0) + parted)
    return Expression("random", {**mild.units, "jawOpen": jaw})


def _lamp(rng: np.random.Generator) -> Light:
    return Light(
        azimuth_deg=round(rng.uniform(-80, 80), 2),
        elevation_deg=round(rng.uniform(-50, 70), 2),
        diameter_deg=round(rng.uniform(15, 60), 2),
        irradiance=round(float(np.exp(rng.uniform(-1, 1))), 3),
        rgb=_white(rng),
    )


def _white(rng: np.random.Generator) -> tuple[float, float, float]:
    """Draw a white between a warm lamp and a cloudy sky: red against blue within ±15 %."""
    warmth = rng.uniform(-0.15, 0.15)
    return (round(1 + warmth, 3), 1.0, round(1 - warmth, 3))
