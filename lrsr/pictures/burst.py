"""How do the frames of one person differ? A video shows somebody who does not quite hold still."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from lrsr.configuration import as_mapping, as_number, require, settle
from lrsr.identities.face.expression import Expression
from lrsr.pictures.recipe import Recipe, derived_seed

_DIGITS = 4
"""Of what is drawn: a record in a manifest that can be read, and equal keys everywhere."""


@dataclass(frozen=True)
class Burst:
    """How far a frame may be from the first, which is the recipe itself.

    All is drawn evenly from -x to +x (units: from 0 to x), for each frame by itself, from the run's
    seed, the person and the frame's number: a person moves alike under every light, and a reference
    like its probe.

    Attributes:
        name: For records.
        shift_ipds: Of the whole picture, to the right and down, in interpupillary distances: the
            camera trembles, the person steps aside. Less than 0.25.
        nearer: Share of the way to the camera, 0 to 0.5.
        yaw_deg: Of the head, >= 0, as the next two.
        pitch_deg: Of the head.
        roll_deg: Of the head.
        units: How much of each face unit comes on top of what the face does, 0 to 1; see
            :class:`lrsr.identities.face.expression.Expression`.

    Raises:
        InputError: A number is out of its range, or there is no such unit.
    """

    name: str = "still"
    shift_ipds: float = 0.0
    nearer: float = 0.0
    yaw_deg: float = 0.0
    pitch_deg: float = 0.0
    roll_deg: float = 0.0
    units: Mapping[str, float] = field(default_factory=dict, hash=False)

    def __post_init__(self) -> None:
        settle(self, "burst")
        most = {"shift_ipds": 0.24, "nearer": 0.5, "yaw_deg": 90, "pitch_deg": 90, "roll_deg": 90}
        for name, high in most.items():
            value = getattr(self, name)
            require(0 <= value <= high, f"burst.{name}", f"{value:g}", f"0 to {high}")
        given = as_mapping(self.units, "burst.units")
        units = {unit: as_number(most, f"burst.units.{unit}") for unit, most in given.items()}
        Expression(self.name, units)  # refuses what does not exist
        object.__setattr__(self, "units", dict(sorted(units.items())))

    def frame(self, recipe: Recipe, number: int, seed: int) -> Recipe:
        """Return a frame, without a seed of its sampler.

        Args:
            recipe: The first frame.
            number: Of the frame; 0 is the first.
            seed: The run's.
        """
        if number == 0:
            return recipe
        draw = np.random.default_rng(derived_seed(seed, "burst", recipe.person.id, number))

        def near(value: float, reach: float) -> float:
            return round(value + float(draw.uniform(-reach, reach)), _DIGITS)

        film, pose, face = recipe.film, recipe.scene.pose, recipe.scene.expression
        reach_px = self.shift_ipds * film.ipd_px
        shift_px = (near(film.shift_px[0], reach_px), near(film.shift_px[1], reach_px))
        film = replace(film, shift_px=shift_px, nearer=near(film.nearer, self.nearer))
        pose = replace(
            pose,
            yaw_deg=near(pose.yaw_deg, self.yaw_deg),
            pitch_deg=near(pose.pitch_deg, self.pitch_deg),
            roll_deg=near(pose.roll_deg, self.roll_deg),
        )
        face = face.adding({unit: abs(near(0.0, most)) for unit, most in self.units.items()})
        return replace(recipe, film=film, scene=replace(recipe.scene, pose=pose, expression=face))


STILL = Burst()
"""Frames that differ in noise alone."""
