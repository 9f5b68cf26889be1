"""Could this head be an adult's? Proportions, eyes, nose, skin, hair and colour, with their limits.

A gate, not a judge of beauty: limits are those of human beings where the literature has them, else
what a mesh may do before it shows. :func:`lrsr.identities.morphable.sample_head` redraws a head
whose geometry fails; colour is judged but draws nothing again, because it depends on the size of
the texture, and a seed must stand for the same person at every size.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lrsr.errors import InputError, NonFiniteError
from lrsr.identities.face.eyes import Eyes, unit_ball
from lrsr.identities.face.template import template
from lrsr.identities.gate import anthropometry
from lrsr.identities.gate.anthropometry import PROPORTIONS, SIGMA_Z_LIMIT, Sex
from lrsr.identities.gate.blotches import measure_paint
from lrsr.identities.gate.folds import measure_folds
from lrsr.identities.gate.hair_fit import measure_hair
from lrsr.identities.gate.intersection import count_nose_crossings, lip_overlap_mm
from lrsr.identities.gate.openings import (
    IRIS_RAD,
    eyes_of,
    measure_eyes,
    mouth_area_mm2,
    nostril_area_mm2,
)
from lrsr.identities.head import Head

Points = NDArray[np.float64]

LIMITS: dict[str, tuple[float, float]] = {
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
    "hair: ribbons off skin and shell, mm": (0.0, 14.0),
    "hair: share before the eyes": (0.0, 0.002),
    "hair: share before nose and mouth": (0.0, 0.002),
    "hair: height of the edge on the forehead, mm": (0.0, 14.0),
    "colour: lowest reflectance": (0.002, 0.95),
    "colour: highest reflectance": (0.002, 0.95),
    "colour: dark share of the cheeks": (0.0, 0.06),
    "colour: dark share of the nose": (0.0, 0.06),
    "colour: dark share of the forehead": (0.0, 0.25),
}
"""Lowest and highest value of each test but the proportions'."""

RELIEF_LEEWAY = 0.05
"""Wrinkles move the skin, landmarks included, by up to half a millimetre: this share of the width
between two limits is added to both for a head that has them."""


@dataclass(frozen=True)
class Verdict:
    """The outcome of one test.

    Attributes:
        name: What was measured, with its unit.
        value: The measure.
        low: Least value that passes.
        high: Greatest value that passes.
        passed: Whether it lies within; NaN does not.
    """

    name: str
    value: float
    low: float
    high: float
    passed: bool

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

    def as_json(self) -> dict[str, Any]:
        """Return plain values: ``passed`` and ``verdicts``, a list of mappings."""
        return {"passed": self.passed, "verdicts": [asdict(v) for v in self.verdicts]}


def check_plausibility(head: Head) -> Plausibility:
    """Judge a finished head with a neutral face.

    Its shape passes within :data:`RELIEF_LEEWAY` of the limits that :func:`check_face` and
    :func:`check_hair` hold a face without wrinkles to.

    Args:
        head: Of the morphable topology; its parameters say "sex", without it both sexes' limits
            hold together, and may hold "appearance" and "hair".

    Returns:
        One verdict per test.

    Raises:
        InputError: The skin is not of the template's topology.
    """
    skin = np.asarray(head.part("skin").vertices, dtype=np.float64)
    face = check_face(skin, eyes_of(head, _EYE_RIM), head.parameters)
    hair = check_hair(head.part("hair").vertices, skin, head.pupils, head.parameters)
    paint = measure_paint(head.part("skin").albedo)
    colours = {
        "colour: lowest reflectance": paint.lowest,
        "colour: highest reflectance": paint.highest,
        "colour: dark share of the cheeks": paint.dark_cheeks,
        "colour: dark share of the nose": paint.dark_nose,
        "colour: dark share of the forehead": paint.dark_forehead,
    }
    shape = (_with_leeway(verdict) for verdict in (*face.verdicts, *hair.verdicts))
    return Plausibility((*shape, *_judge_all(colours)))


def check_face(skin: Points, eyes: Eyes, parameters: Mapping[str, Any]) -> Plausibility:
    """Judge the shape of a face alone, before anything costly is made of it.

    Args:
        skin: ``(V, 3)`` render vertices, head frame, mm.
        eyes: In the same frame.
        parameters: Of the head; see :func:`check_plausibility`.

    Returns:
        Verdicts on proportions, eyes, nose, lips and the mesh of the face.

    Raises:
        InputError: The skin is not of the template's topology.
        NonFiniteError: A coordinate is NaN or infinite.
    """
    if skin.shape != template().skin.shape:
        raise InputError(
            f"plausibility is judged on {len(template().skin)} vertices of the template's skin, got"
            f" an array of shape {skin.shape}: give a head of lrsr.identities.morphable"
        )
    if not np.isfinite(skin).all():
        raise NonFiniteError("a vertex of the skin is not finite: plausibility cannot be judged")
    iris = parameters.get("appearance", {}).get("iris", {}).get("half_angle_rad", IRIS_RAD)
    shape = _judge_all(dict(_face_measures(skin, eyes, iris)))
    return Plausibility((*_check_proportions(skin, eyes, parameters.get("sex")), *shape))


def check_hair(
    hair: NDArray[np.floating],
    skin: NDArray[np.floating],
    pupils: Points,
    parameters: Mapping[str, Any],
) -> Plausibility:
    """Judge how hair sits on a head.

    Args:
        hair: ``(N, 3)`` vertices of the part "hair", mm, or of its shell alone.
        skin: ``(V, 3)`` render vertices, mm.
        pupils: ``(2, 3)``, mm.
        parameters: Of the head; ``parameters["hair"]["sunk_mm"]`` > 0 says that there is no hair.
    """
    stands = not parameters.get("hair", {}).get("sunk_mm", 0.0) > 0.0
    fit = measure_hair(hair, skin, pupils, stands=stands)
    measured = {
        "hair: off the skin, mm": fit.off_skin_mm,
        "hair: ribbons off skin and shell, mm": fit.ribbons_off_mm,
        "hair: share before the eyes": fit.before_eyes,
        "hair: share before nose and mouth": fit.before_face,
        "hair: height of the edge on the forehead, mm": fit.edge_mm,
    }
    return Plausibility(tuple(_judge_all(measured)))


_EYE_RIM = np.flatnonzero(np.abs(unit_ball().vertices[:, 2]) < 1e-9)


def _face_measures(skin: Points, eyes: Eyes, iris_rad: float) -> Iterator[tuple[str, float]]:
    """Measure eyes, nose, lips and the mesh; of both eyes the worse counts."""
    both = measure_eyes(skin, eyes, iris_rad)
    shares = [eye.iris_share for eye in both]
    low, high = LIMITS["eye: visible share of the iris"]
    yield "eye: visible share of the iris", _farther(shares, (low + high) / 2)
    yield "eye: middle of the pupil free", float(min(eye.pupil_free for eye in both))
    low, high = LIMITS["eye: opening, mm"]
    heights = [eye.height_mm for eye in both]
    yield "eye: opening, mm", _farther(heights, (low + high) / 2)
    yield "eye: lids crossed, mm", max(eye.crossed_mm for eye in both)
    yield "eye: pierced by skin, mm", max(eye.pierced_mm for eye in both)
    yield "eye: gap to the lids, mm", max(eye.gap_mm for eye in both)
    yield "eyes: difference of openings, mm", abs(heights[0] - heights[1])
    yield "nose: nostrils seen from in front, mm^2", nostril_area_mm2(skin)
    yield "nose: walls that cross, pairs", float(count_nose_crossings(skin))
    yield "nose: tip before the wings, mm", anthropometry.nose_depth_mm(skin)
    yield "mouth: lips pressed into each other, mm", lip_overlap_mm(skin)
    yield "mouth: inside seen from in front, mm^2", mouth_area_mm2(skin)
    crooked = anthropometry.measure_crookedness(skin)
    yield "crooked: cant of the mouth, degrees", crooked.mouth_deg
    yield "crooked: mouth off the middle, mm", crooked.mouth_mm
    yield "crooked: nose tip off the middle, mm", crooked.nose_mm
    yield "crooked: chin off the middle, mm", crooked.chin_mm
    folds = measure_folds(skin)
    yield "skin: share of triangles turned over", folds.turned_share
    yield "skin: share of triangles crushed", folds.crushed_share


def _farther(values: list[float], middle: float) -> float:
    return max(values, key=lambda value: abs(value - middle))


def _check_proportions(skin: Points, eyes: Eyes, sex: object) -> Iterator[Verdict]:
    """Judge every proportion by the norms of the head's sex, and all of them together."""
    pupils = eyes.pupils
    lengths = anthropometry.measure_lengths(skin, float(np.linalg.norm(pupils[1] - pupils[0])))
    measured = anthropometry.proportions(lengths)
    sexes: tuple[Sex, ...] = ("male",) if sex == "male" else ("female",)
    if sex not in ("female", "male"):
        sexes = ("female", "male")
    for proportion in PROPORTIONS:
        bounds = [anthropometry.limits(proportion, which) for which in sexes]
        unit = "%" if proportion.whole else "mm"
        yield _judge(
            f"proportion: {proportion.name}, {unit}",
            measured[proportion.name],
            min(low for low, _ in bounds),
            max(high for _, high in bounds),
        )
    spread = min(anthropometry.sigma_z(anthropometry.z_scores(measured, which)) for which in sexes)
    yield _judge("proportions: sigma z", spread, 0.0, SIGMA_Z_LIMIT)


def _judge_all(measured: Mapping[str, float]) -> list[Verdict]:
    return [_judge(name, value, *LIMITS[name]) for name, value in measured.items()]


def _with_leeway(verdict: Verdict) -> Verdict:
    more = RELIEF_LEEWAY * (verdict.high - verdict.low)
    return _judge(verdict.name, verdict.value, verdict.low - more, verdict.high + more)


def _judge(name: str, value: float, low: float, high: float) -> Verdict:
    return Verdict(name, float(value), low, high, bool(low <= value <= high))
