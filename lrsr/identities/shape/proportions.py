"""Which proportions do faces have? Measured distances keep drawn shapes within human variation.

Sliders drawn one by one add up: ten of them lengthen the chin. Every measure here is a difference
of coordinates of two vertices, hence linear in the coefficients of the shape space, so what a set
of sliders does to all measures is one small matrix product, and the smallest change of the sliders
that brings the measures back is a least-squares step. What no measure sees stays as drawn.

Standard deviations within one sex and ancestry follow Farkas, "Anthropometry of the Head and Face"
(2nd ed., 1994), rounded.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lrsr.identities.shape.basis import load_basis

_Group = Literal["features", "outline"]
"""Features of the face seen from in front; outline of head and profile."""

X, Y, Z = 0, 1, 2
LIMIT_SD = {"outline": 1.6, "features": 2.2}
"""Measures saturate softly towards this many standard deviations. Of 36 measures of a person one
or two lie farther out, but heads, jaws and profiles that do look like caricatures, and tell
recognisers little; the features of a face seen from in front may."""
STEPS = 3


class Measure(NamedTuple):
    """The distance of two points of the template along one axis.

    Attributes:
        name: What it is.
        axis: 0 across, 1 up, 2 out of the face.
        high: Point on the template, mm from its pupils' middle; the nearest vertex is meant.
        low: The other point.
        sd_mm: Standard deviation among people of one sex and ancestry.
        of: What it is part of.
    """

    name: str
    axis: int
    high: tuple[float, float, float]
    low: tuple[float, float, float]
    sd_mm: float
    of: _Group = "features"


def _across(
    name: str, x: float, y: float, z: float, sd_mm: float, of: _Group = "features"
) -> Measure:
    return Measure(name, X, (x, y, z), (-x, y, z), sd_mm, of)


_NASION = (0.0, 1.3, 8.3)
_SUBNASALE = (0.0, -51.6, 16.3)
_STOMION = (0.0, -70.7, 10.3)
_GNATHION = (0.0, -110.8, 2.5)
_NOSE_TIP = (0.0, -38.9, 28.3)
_UPPER_LIP = (0.0, -62.4, 20.1)
_LOWER_LIP = (0.0, -84.0, 14.8)
_POGONION = (0.0, -101.3, 8.3)
_GLABELLA = (0.0, 19.5, 11.5)
_VERTEX = (0.0, 115.0, -85.0)
_LEFT_EAR = (-76.1, 23.4, -95.7), (-76.6, -51.8, -92.3)
_RIGHT_EAR = (76.1, 23.4, -95.7), (76.6, -51.8, -92.3)

MEASURES = (
    _across("width between cheekbones", 68.3, -19.2, -41.6, 5.0, "outline"),
    _across("width between jaw angles", 57.9, -80.4, -48.0, 5.5, "outline"),
    _across("width of the forehead", 60.0, 30.0, -30.0, 5.0, "outline"),
    _across("width of the head", 71.8, 51.1, -78.0, 5.5, "outline"),
    _across("width between the ears", 89.8, -6.0, -110.0, 7.0, "outline"),
    _across("width of the chin", 20.9, -103.4, -1.4, 3.5, "outline"),
    _across("width of the nose", 19.0, -45.0, 8.0, 2.4),
    _across("width of the bridge", 9.0, -8.0, 0.0, 1.6),
    _across("width of the mouth", 25.0, -73.0, 0.0, 3.5),
    _across("inner canthi", 18.0, -4.0, -6.0, 2.5),
    _across("outer canthi", 46.0, -2.0, -12.0, 3.8),
    Measure("opening of the left lids", Y, (-32.0, 2.9, -2.0), (-32.0, -5.7, -2.0), 1.0),
    Measure("opening of the right lids", Y, (32.0, 2.9, -2.0), (32.0, -5.7, -2.0), 1.0),
    Measure("height of the brow", Y, (34.6, 17.3, 6.8), (32.0, 2.9, -2.0), 2.5),
    Measure("height of the nose", Y, _NASION, _SUBNASALE, 3.2),
    Measure("height of the lower face", Y, _SUBNASALE, _GNATHION, 4.2, "outline"),
    Measure("height of the upper lip", Y, _SUBNASALE, _STOMION, 2.2),
    Measure("red of the upper lip", Y, _UPPER_LIP, _STOMION, 1.6),
    Measure("red of the lower lip", Y, _STOMION, _LOWER_LIP, 1.7),
    Measure("height of the chin", Y, _STOMION, _GNATHION, 3.2, "outline"),
    Measure("height of the skull", Y, _VERTEX, _NASION, 6.0, "outline"),
    Measure("height of the left ear", Y, *_LEFT_EAR, 4.0, "outline"),
    Measure("height of the right ear", Y, *_RIGHT_EAR, 4.0, "outline"),
    Measure("protrusion of the nose", Z, _NOSE_TIP, _SUBNASALE, 1.9, "outline"),
    Measure("depth of the bridge", Z, _NOSE_TIP, _NASION, 2.4, "outline"),
    Measure("protrusion of the brow", Z, _GLABELLA, _NASION, 1.3, "outline"),
    Measure("protrusion of the chin", Z, _POGONION, _SUBNASALE, 3.2, "outline"),
    Measure("protrusion of the lips", Z, _UPPER_LIP, _SUBNASALE, 1.8),
    Measure("lips to each other", Z, _UPPER_LIP, _LOWER_LIP, 1.8),
    Measure("droop of the nose tip", Y, _NOSE_TIP, _SUBNASALE, 2.2),
    Measure("left mouth corner", Y, (-25.0, -73.0, 0.0), _STOMION, 1.6),
    Measure("right mouth corner", Y, (25.0, -73.0, 0.0), _STOMION, 1.6),
    Measure("left cheek", Z, (-42.0, -45.0, -5.0), _SUBNASALE, 3.0, "outline"),
    Measure("right cheek", Z, (42.0, -45.0, -5.0), _SUBNASALE, 3.0, "outline"),
    Measure("crook of the nose", X, _NOSE_TIP, _NASION, 1.2),
    Measure("crook of the jaw", X, _GNATHION, _NASION, 1.6, "outline"),
)


@dataclass(frozen=True)
class Gauge:
    """What every field of the basis does to every measure.

    Attributes:
        effects: ``(M, K)``: mm per unit of a coefficient.
        limits: ``(M,)`` mm: where a measure saturates.
    """

    effects: NDArray[np.float64]
    limits: NDArray[np.float64]


@lru_cache(maxsize=1)
def load_gauge() -> Gauge:
    """Look up the measures' vertices on the average adult and weigh the fields."""
    basis = load_basis()
    average = basis.shape(basis.neutral)
    centres = average.eyes.mean(axis=1, keepdims=True)
    origin = centres.mean(axis=(0, 1))  # between the pupils
    origin[2] += np.linalg.norm(average.eyes - centres, axis=2).mean()
    head = np.unique(basis.quads[basis.region == 0])
    skin = average.skin[head] - origin

    def row(point: tuple[float, float, float], axis: int) -> int:
        return 3 * int(head[np.argmin(np.linalg.norm(skin - point, axis=1))]) + axis

    high = [row(measure.high, measure.axis) for measure in MEASURES]
    low = [row(measure.low, measure.axis) for measure in MEASURES]
    effects = (basis.fields[high] - basis.fields[low]).toarray()
    limits = [LIMIT_SD[measure.of] * measure.sd_mm for measure in MEASURES]
    return Gauge(effects, np.array(limits))


def _saturate(extent: NDArray[np.float64]) -> NDArray[np.float64]:
    """Leave what is within half the limit, lead what is beyond softly to the limit itself."""
    beyond = np.maximum(np.abs(extent) - 0.5, 0.0)
    within = np.minimum(np.abs(extent), 0.5)
    return np.asarray(np.sign(extent) * (within + 0.5 * np.tanh(2.0 * beyond)))


def restrain(
    gauge: Gauge,
    values: NDArray[np.float64],
    columns: NDArray[np.int64],
    width: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Change sliders as little as possible until no measure is extreme.

    Args:
        gauge: Of the basis.
        values: ``(S,)`` sliders, positive towards their "+" end.
        columns: ``(S, 2)`` coefficients of each slider's "-" and "+" end.
        width: ``(S,)`` > 0: standard deviation of each slider; wide ones give way more.

    Returns:
        ``(S,)`` new sliders.
    """
    values = values.copy()
    wanted: NDArray[np.float64] | None = None
    for _ in range(STEPS):  # a slider that crosses zero acts by its other end from then on
        positive = values >= 0
        ends = np.where(positive, columns[:, 1], columns[:, 0])
        scaled = gauge.effects[:, ends] * np.where(positive, 1.0, -1.0) / gauge.limits[:, None]
        extent = scaled @ values
        if wanted is None:
            wanted = _saturate(extent)
        spread = scaled * width**2
        system = spread @ scaled.T
        system += 1e-3 * np.trace(system) / len(system) * np.eye(len(system))
        values += spread.T @ np.linalg.solve(system, wanted - extent)
    return values
