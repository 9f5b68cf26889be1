"""How do people stand before a camera when nobody tells them to? Poses, lights, faces for training.

The ranges are estimated: a room lights a face with one or two lamps and whatever its walls send
back.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lrsr.configuration import as_list, as_number, require
from lrsr.identities.face.expression import NEUTRAL, Expression
from lrsr.rendering.lighting import Lighting
from lrsr.rendering.lights import Light
from lrsr.rendering.pose import Pose

_EYES_SHUT = 0.48  # at most: pictures of a blink are usually thrown away


@dataclass(frozen=True)
class Variety:
    """What is drawn from.

    Attributes:
        poses: Named ones.
        lightings: Named ones.
        expressions: Shown at 20 to 80 %.
        named_share: How often a named pose or lighting is drawn instead of a random one, 0..1.
        expression_share: How often an expression is drawn, 0..1; else the face is at rest.
        turned_deg: Largest yaw, pitch and roll of a random pose, each 0 to 90.

    Raises:
        InputError: A number is out of its range, or there is nothing to draw from.
    """

    poses: Sequence[Pose]
    lightings: Sequence[Lighting]
    expressions: Sequence[Expression]
    named_share: float
    expression_share: float
    turned_deg: Sequence[float]

    def __post_init__(self) -> None:
        for name in ("named_share", "expression_share"):
            share = as_number(getattr(self, name), f"data.variety.{name}")
            require(0 <= share <= 1, f"data.variety.{name}", share, "0 to 1")
        turned = as_list(self.turned_deg, "data.variety.turned_deg")
        angles = [as_number(angle, "data.variety.turned_deg") for angle in turned]
        holds = len(angles) == 3 and min(angles) >= 0 and max(angles) <= 90
        require(holds, "data.variety.turned_deg", angles, "yaw, pitch, roll, each 0 to 90")
        for name in ("poses", "lightings", "expressions"):
            require(len(getattr(self, name)) > 0, f"data.variety.{name}", [], "at least one")

    def pose(self, rng: np.random.Generator) -> Pose:
        """Draw a named pose, or one within the largest angles, uniform."""
        if rng.random() < self.named_share:
            return self.poses[int(rng.integers(len(self.poses)))]
        yaw, pitch, roll = (rng.uniform(-1, 1, 3) * self.turned_deg).round(2).tolist()
        return Pose("random", yaw_deg=yaw, pitch_deg=pitch, roll_deg=roll)

    def lighting(self, rng: np.random.Generator) -> Lighting:
        """Draw a named lighting, or one or two lamps of any direction and warmth, and a fill."""
        if rng.random() < self.named_share:
            return self.lightings[int(rng.integers(len(self.lightings)))]
        lamps = tuple(_lamp(rng) for _ in range(rng.integers(1, 3)))
        return Lighting(
            "random", lamps, fill_share=round(rng.uniform(0.15, 0.6), 3), fill_rgb=_white(rng)
        )

    def expression(self, rng: np.random.Generator) -> Expression:
        """Draw a face at rest, or a mild expression, no eye more than half shut."""
        acted = self.expressions[int(rng.integers(len(self.expressions)))]
        strength = round(rng.uniform(0.2, 0.8), 3)
        parted = round(max(0.0, rng.uniform(-0.15, 0.15)), 3)
        units = {name: strength * value for name, value in acted.units.items()}
        units["jawOpen"] = min(1.0, units.get("jawOpen", 0.0) + parted)
        for eye in {"eyeBlinkLeft", "eyeBlinkRight"} & units.keys():
            units[eye] = min(units[eye], _EYES_SHUT)
        acting = rng.random() < self.expression_share
        return Expression("random", units) if acting else NEUTRAL


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
