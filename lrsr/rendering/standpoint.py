"""From where does the camera look? At eye level, or from a height and a distance on the floor."""

import math
from dataclasses import dataclass

from lrsr.configuration import settle
from lrsr.errors import InputError

_EYE_HEIGHT_M = 1.6
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
    eye_height_m: float = _EYE_HEIGHT_M

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            InputError: A distance that is not positive, or a number that is none.
        """
        settle(self, "standpoint")
        if self.distance_m is not None and self.distance_m <= 0:
            raise InputError(f"standpoint.distance_m={self.distance_m:g}: wanted a distance > 0")

    @property
    def above_m(self) -> float:
        """How much higher than the eyes the camera is, m."""
        return 0.0 if self.height_m is None else self.height_m - self.eye_height_m

    @property
    def camera_m(self) -> float | None:
        """Straight from the eyes to the camera, m; None where the reference camera says it.

        Example:
            >>> round(Standpoint("near", distance_m=1.0, height_m=2.25).camera_m, 3)
            1.193
        """
        return None if self.distance_m is None else math.hypot(self.distance_m, self.above_m)

    def record(self) -> dict[str, float | None]:
        """Return what makes this standpoint and no other, in plain values."""
        return {"camera_m": self.camera_m, "above_m": self.above_m}


LEVEL = Standpoint("level")
"""At the height of the eyes, where the reference camera must stand."""
