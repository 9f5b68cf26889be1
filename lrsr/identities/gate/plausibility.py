"""Could this head be an adult's? Proportions, eyes, nose, lips, skin and hair, with their limits.

A gate, not a judge of beauty: limits are those of human beings where the literature has them, else
what a mesh may do before it shows. :func:`lrsr.identities.morphable.sample_head` redraws a head
whose geometry fails.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lrsr.identities.face.eyes import Eyes
from lrsr.identities.gate.anthropometry import (
    PROPORTIONS,
    SIGMA_Z_LIMIT,
    Sex,
    limits,
    measure_crookedness,
    measure_lengths,
    nose_depth_mm,
    proportions,
    sigma_z,
    z_scores,
)
from lrsr.identities.gate.folds import measure_folds
from lrsr.identities.gate.hair_fit import measure_hair
from lrsr.identities.gate.intersection import count_nose_crossings, lip_overlap_mm
from lrsr.identities.gate.openings import measure_eyes, mouth_area_mm2, nostril_area_mm2

Points = NDArray[np.float64]

_LIMITS: dict[str, tuple[float, float]] = {
    # Lids of a resting eye open 5.5 to 13 mm; an upper lid covers 1 to 2 mm of the iris, the lower
    # meets it, with age both cover more; openings that differ by 2 mm are a ptosis.
    "eye: visible share of the iris": (0.42, 0.97),
    "eye: middle of the pupil free": (1.0, 1.0),
    "eye: opening, mm": (5.5, 13.0),
    "eye: lids crossed, mm": (0.0, 0.3),
    "eye: pierced by skin, mm": (0.0, 0.45),
    "eye: gap to the lids, mm": (0.0, 0.3),
    "eyes: difference of openings, mm": (0.0, 2.0),
    # Seen from below both nostrils open some 130 mm^2; a nose of 120 degrees shows half from front.
    "nose: nostrils seen from in front, mm^2": (0.0, 62.0),
    "nose: walls that cross, pairs": (0.0, 20.0),
    # From its crease in the cheek, 5 mm and more behind its widest point, to the tip a wing is 28
    # to 35 mm long, SD 2 (Farkas 1994).
    "nose: tip before the wings, mm": (10.0, 37.0),
    "mouth: lips pressed into each other, mm": (0.0, 3.5),
    # Lips that part by 1 mm along the mouth; the template's own, parted a little, show 25.
    "mouth: inside seen from in front, mm^2": (0.0, 48.0),
    # A mouth that anybody sees to be canted; twice the stray of a chin that is called asymmetric.
    "crooked: cant of the mouth, degrees": (0.0, 5.0),
    "crooked: mouth off the middle, mm": (0.0, 5.0),
    "crooked: nose tip off the middle, mm": (0.0, 5.0),
    "crooked: chin off the middle, mm": (0.0, 8.0),
    "skin: share of triangles turned over": (0.0, 0.002),
    "skin: share of triangles crushed": (0.0, 0.002),
    # Hair gives the crown up to 2 cm of volume; a soft edge lies flat.
    "hair: off the skin, mm": (0.0, 22.0),
    "hair: share before the eyes": (0.0, 0.002),
    "hair: share before nose and mouth": (0.0, 0.002),
    "hair: height of the edge on the forehead, mm": (0.0, 14.0),
}
"""Lowest and highest value of each test but the proportions'."""


@dataclass(frozen=True)
class Verdict:
    """The outcome of one test.

    Attributes:
        name: What was measured, with its unit.
        value: The measure.
        low: Least value that passes.
        high: Greatest value that passes.
    """

    name: str
    value: float
    low: float
    high: float

    @property
    def passed(self) -> bool:
        """Whether the value lies within; NaN does not."""
        return bool(self.low <= self.value <= self.high)

    @property
    def excess(self) -> float:
        """How far beyond its limits the value is, in widths between them; NaN counts as far."""
        beyond = max(self.low - self.value, self.value - self.high, 0.0)
        if not math.isfinite(beyond):
            return math.inf
        return 0.0 if self.passed else max(beyond / max(self.high - self.low, 1e-9), 1e-9)


@dataclass(frozen=True)
class Plausibility:
    """All verdicts on one head.

    Attributes:
        verdicts: One per test, names unique.
    """

    verdicts: tuple[Verdict, ...]

    @property
    def passed(self) -> bool:
        """Whether every test passed."""
        return all(verdict.passed for verdict in self.verdicts)

    @property
    def failures(self) -> tuple[str, ...]:
        """Names of the tests that failed."""
        return tuple(verdict.name for verdict in self.verdicts if not verdict.passed)

    @property
    def excess(self) -> float:
        """By how much all tests together are missed; 0 if none is."""
        return sum(verdict.excess for verdict in self.verdicts)


def check_face(skin: Points, eyes: Eyes, sex: Sex, iris_rad: float) -> Plausibility:
    """Judge the shape of a face alone, before anything costly is made of it.

    Args:
        skin: ``(V, 3)`` render vertices, head frame, mm.
        eyes: In the same frame.
        sex: Whose proportions are the norm.
        iris_rad: Half angle of the iris, seen from the eyeball's centre.

    Returns:
        Verdicts on proportions, eyes, nose, lips and the mesh of the face.
    """
    measured = {
        **_measure_eyes(skin, eyes, iris_rad),
        "nose: nostrils seen from in front, mm^2": nostril_area_mm2(skin),
        "nose: walls that cross, pairs": float(count_nose_crossings(skin)),
        "nose: tip before the wings, mm": nose_depth_mm(skin),
        "mouth: lips pressed into each other, mm": lip_overlap_mm(skin),
        "mouth: inside seen from in front, mm^2": mouth_area_mm2(skin),
        **measure_crookedness(skin),
        **measure_folds(skin),
    }
    return Plausibility((*_check_proportions(skin, eyes, sex), *_judge(measured)))


def check_hair(
    hair: NDArray[np.floating], skin: NDArray[np.floating], pupils: Points, *, stands: bool
) -> Plausibility:
    """Judge how hair sits on a head; see :func:`lrsr.identities.gate.hair_fit.measure_hair`."""
    return Plausibility(_judge(measure_hair(hair, skin, pupils, stands=stands)))


def _measure_eyes(skin: Points, eyes: Eyes, iris_rad: float) -> dict[str, float]:
    """Measure both eyes; the worse counts."""
    both = measure_eyes(skin, eyes, iris_rad)
    heights = [eye.height_mm for eye in both]
    return {
        "eye: visible share of the iris": _farther(
            [eye.iris_share for eye in both], *_LIMITS["eye: visible share of the iris"]
        ),
        "eye: middle of the pupil free": float(min(eye.pupil_free for eye in both)),
        "eye: opening, mm": _farther(heights, *_LIMITS["eye: opening, mm"]),
        "eye: lids crossed, mm": max(eye.crossed_mm for eye in both),
        "eye: pierced by skin, mm": max(eye.pierced_mm for eye in both),
        "eye: gap to the lids, mm": max(eye.gap_mm for eye in both),
        "eyes: difference of openings, mm": abs(heights[0] - heights[1]),
    }


def _farther(values: list[float], low: float, high: float) -> float:
    """Return the value that is farther from the middle between two limits."""
    return max(values, key=lambda value: abs(value - (low + high) / 2))


def _check_proportions(skin: Points, eyes: Eyes, sex: Sex) -> tuple[Verdict, ...]:
    """Judge every proportion by the norms of a sex, and all of them together."""
    left, right = eyes.pupils
    measured = proportions(measure_lengths(skin, float(np.linalg.norm(right - left))))
    single = (
        Verdict(
            f"proportion: {proportion.name}, {'%' if proportion.whole else 'mm'}",
            measured[proportion.name],
            *limits(proportion, sex),
        )
        for proportion in PROPORTIONS
    )
    spread = sigma_z(z_scores(measured, sex))
    return (*single, Verdict("proportions: sigma z", spread, 0.0, SIGMA_Z_LIMIT))


def _judge(measured: dict[str, float]) -> tuple[Verdict, ...]:
    return tuple(Verdict(name, value, *_LIMITS[name]) for name, value in measured.items())
