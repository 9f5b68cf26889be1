"""From where does the camera look? At eye level, or from a height and a distance on the floor."""

import math
from dataclasses import dataclass, replace
from typing import Any

from lrsr.errors import InputError

EYE_HEIGHT_M = 1.6
"""Of a standing adult, between the means of women and men, in shoes (estimated)."""


@dataclass(frozen=True)
class Standpoint:
    """Where the camera stands before somebody who looks straight ahead; it looks at the face.

    Attributes:
        name: For manifests; two of the same numbers make the same picture.
        distance_m: Along the floor from below the eyes to below the camera, m, > 0; the focal
            length then follows from the size of the face. None: where the reference camera must
            stand.
        height_m: Of the camera above the floor, m; None: that of the eyes.
        eye_height_m: Of the subject's eyes above the floor, m.
    """

    name: str
    distance_m: float | None = None
    height_m: float | None = None
    eye_height_m: float = EYE_HEIGHT_M

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            InputError: A distance that is not positive, or a number that is none.
        """
        given = (self.height_m or 0.0, self.eye_height_m)
        near = self.distance_m is not None and not 0 < self.distance_m < math.inf
        if near or not all(map(math.isfinite, given)):
            raise InputError(
                f"standpoint {self.name!r}: distance_m={self.distance_m}, height_m={self.height_m},"
                f" eye_height_m={self.eye_height_m}; give a distance > 0 and finite heights"
            )

    @property
    def above_m(self) -> float:
        """How much higher than the eyes the camera is, m."""
        return 0.0 if self.height_m is None else self.height_m - self.eye_height_m

    @property
    def camera_m(self) -> float | None:
        """Straight from the eyes to the camera, m; None where the reference camera says it.

        Example:
            >>> round(STANDPOINTS["scface_near"].camera_m, 3)
            1.193
        """
        return None if self.distance_m is None else math.hypot(self.distance_m, self.above_m)

    def record(self) -> dict[str, float | None]:
        """Return what makes this standpoint and no other, in plain values."""
        return {"camera_m": self.camera_m, "above_m": self.above_m}


STANDPOINTS = {
    place.name: place
    for place in (
        Standpoint("level"),
        Standpoint("scface_far", 4.2, 2.25),
        Standpoint("scface_middle", 2.6, 2.25),
        Standpoint("scface_near", 1.0, 2.25),
    )
}
"""Standpoints by name; SCFace (Grgic, Delac and Grgic 2011) has its cameras 2.25 m above the floor
and its subjects 4.2, 2.6 and 1.0 m away."""


def find_standpoint(name: str | Standpoint, **changes: Any) -> Standpoint:
    """Return a standpoint by its name, or the standpoint itself; ``changes`` replace fields.

    Raises:
        InputError: There is no standpoint of that name.

    Example:
        >>> find_standpoint("scface_far", eye_height_m=1.8).above_m
        0.44999999999999996
    """
    if isinstance(name, Standpoint):
        return replace(name, **changes)
    if name not in STANDPOINTS:
        known = ", ".join(STANDPOINTS)
        raise InputError(f"standpoint {name!r} does not exist; choose one of {known}")
    return replace(STANDPOINTS[name], **changes)
