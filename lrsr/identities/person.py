"""Who can be made, and what is recorded of them? Sex, age, ancestry, skin, what the gate did.

Skin is classed by its individual typology angle (ITA), the angle between lightness and yellowness
above the middle grey of CIELAB (Chardin, Hourseau and Bazin, "Skin colour typology and suntanning
pathways", Int. J. Cosmet. Sci. 13, 1991), with the classes that dermatology uses since (Del Bino
and Bernerd, "Variations in skin colour", Br. J. Dermatol. 169 (s3), 2013).
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lrsr.configuration import as_whole
from lrsr.errors import InputError
from lrsr.identities.day.another_day import SAME_DAY, AnotherDay
from lrsr.identities.face.expression import Expression
from lrsr.identities.head import Head
from lrsr.identities.population import EVERYBODY, Population
from lrsr.identities.splits import LARGEST_INDEX, SPLITS, Split, identity_seed

TONES = {
    "very light": 55.0,
    "light": 41.0,
    "intermediate": 28.0,
    "tan": 10.0,
    "brown": -30.0,
    "dark": -90.0,
}
"""The class of everyone whose angle is above the number, degrees, and below the one before."""

_CHEEK_MM = 9.0
"""Radius of the patch of each cheek that is measured."""

_WHITE = np.array([0.9505, 1.0, 1.089])
_LINEAR_SRGB_TO_XYZ = np.array(
    [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
)  # IEC 61966-2-1, D65


@dataclass(frozen=True)
class Person:
    """Somebody who can be made: one draw from the shape space.

    Attributes:
        split: Which people; the three splits have nobody in common.
        index: Number within the split, 0 to 2**36.
        draw: How often the person was redrawn; see :mod:`lrsr.identities.roster`.
        population: From whom the person is drawn.

    Raises:
        InputError: A value is out of its range.
    """

    split: Split
    index: int
    draw: int = 0
    population: Population = EVERYBODY

    def __post_init__(self) -> None:
        if self.split not in SPLITS:
            raise InputError(f"identities.split={self.split}: wanted one of {', '.join(SPLITS)}")
        for name, largest in (("index", LARGEST_INDEX), ("draw", 2**20)):
            value = as_whole(getattr(self, name), f"identities {name}")
            if not 0 <= value <= largest:
                raise InputError(f"identities {name}={value}: wanted 0 to {largest}")
            object.__setattr__(self, name, value)

    @property
    def id(self) -> str:
        """Stable name: split and number, and what sets them apart from that one.

        Example:
            >>> Person("test", 7).id
            'test-00007'
            >>> Person("test", 7, draw=1, population=Population("female")).id
            'test-00007-female-draw1'
        """
        words = [self.split, f"{self.index:05d}", self.population.tag]
        return "-".join(filter(None, [*words, f"draw{self.draw}" if self.draw else ""]))

    def record(self) -> dict[str, Any]:
        """Return what makes this person's head, in plain values."""
        return asdict(self)

    def head(
        self, expression: Expression, texture_size: int, another_day: AnotherDay = SAME_DAY
    ) -> Head:
        """Build the head.

        Args:
            expression: What the face does.
            texture_size: Of the albedo, px.
            another_day: What has changed since the person was enrolled.
        """
        from lrsr.identities.morphable import sample_head  # measures the space: a second

        head = sample_head(
            identity_seed(self.split, self.index, self.draw),
            texture_size=texture_size,
            population=self.population,
            expression=expression,
            another_day=another_day,
        )
        return replace(head, identity_id=self.id)


@dataclass(frozen=True)
class Traits:
    """The part of a head's parameters that a study is grouped by.

    Attributes:
        sex: "female" or "male".
        age_years: As drawn.
        ancestry: Shares of the poles of the shape space, summing to 1.
        ita_deg: Individual typology angle of the bare cheeks; more is lighter.
        skin_tone: Its class, one of :data:`TONES`.
        gate: What was drawn again and why, as :func:`lrsr.identities.gate.gate.record` writes it;
            None where it was not recorded.
        changes: What another day has done, by its kind; None: the person is as enrolled.
    """

    sex: str
    age_years: float
    ancestry: Mapping[str, float]
    ita_deg: float
    skin_tone: str
    gate: Mapping[str, Any] | None = None
    changes: Mapping[str, Any] | None = None


def describe(head: Head) -> Traits:
    """Say who a head is.

    Args:
        head: Of :func:`lrsr.identities.morphable.sample_head`: its skin's albedo is measured, its
            parameters tell the rest; only the gate's record may be missing.

    Raises:
        KeyError: The parameters lack sex, age or ancestry.
    """
    drawn = head.parameters
    ita_deg = _typology_angle_deg(_cheek_reflectance(head))
    return Traits(
        sex=str(drawn["sex"]),
        age_years=round(float(drawn["age_years"]), 2),  # type: ignore[arg-type]  # a number
        ancestry={
            race: round(float(share), 4)
            for race, share in dict(drawn["ancestry"]).items()  # type: ignore[call-overload]  # shares by name
        },
        ita_deg=round(ita_deg, 2),
        skin_tone=_tone_of(ita_deg),
        gate=drawn.get("gate"),  # type: ignore[arg-type]  # a record
        changes=drawn.get("another_day"),  # type: ignore[arg-type]  # another
    )


def _cheek_reflectance(head: Head) -> NDArray[np.float64]:
    """Measure the skin of both cheeks: the median, so that moles and single hairs do not count.

    The patches lie between each eye and its corner of the mouth, a little outwards, where neither
    the shadows under the eyes nor a beard reach.

    Args:
        head: Its first part is the skin.

    Returns:
        ``(3,)`` linear sRGB reflectance.
    """
    skin = head.parts[0]
    left_eye, right_eye, _, mouth_left, mouth_right = head.landmarks
    height, width = skin.albedo.shape[:2]
    front = skin.vertices[:, 2] > min(mouth_left[2], mouth_right[2]) - 40.0
    near = np.zeros(len(skin.vertices), dtype=bool)
    for eye, mouth, outwards in ((left_eye, mouth_left, -1), (right_eye, mouth_right, 1)):
        middle = 0.45 * eye[:2] + 0.55 * mouth[:2] + np.array([10.0 * outwards, 0.0])
        near |= front & (np.hypot(*(skin.vertices[:, :2] - middle).T) < _CHEEK_MM)
    column = np.clip(skin.uv[near, 0] * width, 0, width - 1).astype(int)
    row = np.clip(skin.uv[near, 1] * height, 0, height - 1).astype(int)
    return np.asarray(np.median(skin.albedo[row, column].astype(np.float64), axis=0))


def _typology_angle_deg(linear: ArrayLike) -> float:
    """Return the individual typology angle, arctan((L* - 50) / b*).

    Args:
        linear: ``(3,)`` linear sRGB reflectance, white = 1.

    Returns:
        -90 to 90 degrees for any skin (b* > 0).

    Example:
        >>> round(_typology_angle_deg([0.55, 0.36, 0.27]))  # fair skin
        52
    """
    ratio = _LINEAR_SRGB_TO_XYZ @ np.asarray(linear, dtype=np.float64) / _WHITE
    f = np.where(ratio > (6 / 29) ** 3, np.cbrt(ratio), ratio / (3 * (6 / 29) ** 2) + 4 / 29)
    lightness, yellowness = 116 * f[1] - 16, 200 * (f[1] - f[2])
    return float(np.degrees(np.arctan2(lightness - 50, max(yellowness, 1e-9))))


def _tone_of(ita_deg: float) -> str:
    """Return the class of an angle; a boundary belongs to the darker class.

    Example:
        >>> [_tone_of(angle) for angle in (60, 50, 28, 28.1, -30)]
        ['very light', 'light', 'tan', 'intermediate', 'dark']
    """
    names = list(TONES)
    for name, _ in pairwise(names):
        if ita_deg > TONES[name]:
            return name
    return names[-1]
