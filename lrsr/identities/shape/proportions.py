"""Which proportions do faces have? Distances that vary between people as those of adults do.

Sliders drawn one by one add up: ten of them lengthen the chin. So the distances are drawn, with the
spread and the correlations of people, and the sliders are made to fit them. Every measure here is a
difference of coordinates of two vertices, hence linear in the coefficients of the shape space, and
the smallest change of the sliders that gives the drawn measures is a least-squares step: Matheron's
rule for a Gaussian that is conditioned on them. What no measure sees stays as drawn.

Standard deviations within one sex and ancestry follow Farkas, "Anthropometry of the Head and Face"
(2nd ed., 1994), rounded.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from lrsr.identities.shape.basis import load_basis

_Group = Literal["features", "outline"]
"""Features of the face seen from in front; outline of head and profile."""

_X, _Y, _Z = 0, 1, 2
_IN_COMMON = {"outline": 0.55, "features": 0.25}
"""Share of a measure's variance that it has in common with all others along its axis: breadths of
head, cheekbones and jaws correlate by 0.5 to 0.65, features less (Farkas 1994)."""
_AS_WIDE_AS = {"width between the ears": "width of the head"}
_FARTHEST_SD = 2.5
"""One person in eighty is farther from the mean in a measure; those look like caricatures."""
_STEPS = 8
_TOLERANCE = 0.03
"""Of the variance of a measure, what it may miss the wanted one by: sliders that nearly cancel each
other would have to go to their ends for the last tenth of a millimetre."""


class _Measure(NamedTuple):
    """The distance of two points of the template along one axis.

    Attributes:
        name: What it is.
        axis: 0 across, 1 up, 2 out of the face.
        high: Point on the template, mm from its pupils' middle; the nearest vertex is meant.
        low: The other point.
        sd_mm: Standard deviation among people of one sex and ancestry.
        of: What it is part of.
        means_mm: What the averages of women and of men lack to those of people (Farkas 1994);
            women's jaws and chins by eye, beyond that.
    """

    name: str
    axis: int
    high: tuple[float, float, float]
    low: tuple[float, float, float]
    sd_mm: float
    of: _Group = "features"
    means_mm: tuple[float, float] = (0.0, 0.0)


def _across(
    name: str,
    x: float,
    y: float,
    z: float,
    sd_mm: float,
    of: _Group = "features",
    means_mm: tuple[float, float] = (0.0, 0.0),
) -> _Measure:
    return _Measure(name, _X, (x, y, z), (-x, y, z), sd_mm, of, means_mm)


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

_MEASURES = (
    _across("width between cheekbones", 68.3, -19.2, -41.6, 5.0, "outline", means_mm=(-3.0, 0.0)),
    _across("width between jaw angles", 57.9, -80.4, -48.0, 5.5, "outline", means_mm=(-4.0, 0.0)),
    _across("width of the forehead", 60.0, 30.0, -30.0, 5.0, "outline"),
    _across("width of the head", 71.8, 51.1, -78.0, 5.5, "outline", means_mm=(-2.0, 0.0)),
    _across("width between the ears", 89.8, -6.0, -110.0, 7.0, "outline"),
    _across("width of the chin", 20.9, -103.4, -1.4, 3.5, "outline", means_mm=(-3.0, 0.0)),
    _across("width of the nose", 19.0, -45.0, 8.0, 2.4),
    _across("width of the bridge", 9.0, -8.0, 0.0, 1.6),
    _across("width of the mouth", 25.0, -73.0, 0.0, 3.5),
    _across("inner canthi", 18.0, -4.0, -6.0, 2.5, means_mm=(0.5, -1.5)),
    _across("outer canthi", 46.0, -2.0, -12.0, 3.8, means_mm=(0.0, 2.0)),
    _Measure("opening of the left lids", _Y, (-32.0, 2.9, -2.0), (-32.0, -5.7, -2.0), 1.0),
    _Measure("opening of the right lids", _Y, (32.0, 2.9, -2.0), (32.0, -5.7, -2.0), 1.0),
    _Measure("height of the brow", _Y, (34.6, 17.3, 6.8), (32.0, 2.9, -2.0), 2.5),
    _Measure("height of the nose", _Y, _NASION, _SUBNASALE, 3.2, means_mm=(0.5, -2.5)),
    _Measure("height of the lower face", _Y, _SUBNASALE, _GNATHION, 4.2, "outline"),
    _Measure("height of the upper lip", _Y, _SUBNASALE, _STOMION, 2.2, means_mm=(-1.5, -1.0)),
    _Measure("red of the upper lip", _Y, _UPPER_LIP, _STOMION, 1.6),
    _Measure("red of the lower lip", _Y, _STOMION, _LOWER_LIP, 1.7),
    _Measure("height of the chin", _Y, _STOMION, _GNATHION, 3.2, "outline", means_mm=(0.0, -2.5)),
    _Measure("height of the skull", _Y, _VERTEX, _NASION, 6.0, "outline"),
    _Measure("height of the left ear", _Y, *_LEFT_EAR, 4.0, "outline"),
    _Measure("height of the right ear", _Y, *_RIGHT_EAR, 4.0, "outline"),
    _Measure("protrusion of the nose", _Z, _NOSE_TIP, _SUBNASALE, 1.9, "outline"),
    _Measure("depth of the bridge", _Z, _NOSE_TIP, _NASION, 2.4, "outline"),
    _Measure("protrusion of the brow", _Z, _GLABELLA, _NASION, 1.3, "outline"),
    _Measure("protrusion of the chin", _Z, _POGONION, _SUBNASALE, 3.2, "outline"),
    _Measure("protrusion of the lips", _Z, _UPPER_LIP, _SUBNASALE, 1.8),
    _Measure("lips to each other", _Z, _UPPER_LIP, _LOWER_LIP, 1.8),
    _Measure("droop of the nose tip", _Y, _NOSE_TIP, _SUBNASALE, 2.2),
    _Measure("left mouth corner", _Y, (-25.0, -73.0, 0.0), _STOMION, 1.6),
    _Measure("right mouth corner", _Y, (25.0, -73.0, 0.0), _STOMION, 1.6),
    _Measure("left cheek", _Z, (-42.0, -45.0, -5.0), _SUBNASALE, 3.0, "outline"),
    _Measure("right cheek", _Z, (42.0, -45.0, -5.0), _SUBNASALE, 3.0, "outline"),
    _Measure("crook of the nose", _X, _NOSE_TIP, _NASION, 1.2),
    _Measure("crook of the jaw", _X, _GNATHION, _NASION, 1.6, "outline"),
)


_PLACE = {measure.name: k for k, measure in enumerate(_MEASURES)}

_SEALS = (
    _Measure("parting of the lips", _Y, (0.0, -72.4, 13.3), (0.0, -73.7, 12.9), 0.25),
    _Measure("left parting of the lips", _Y, (-11.1, -72.1, 11.5), (-11.6, -73.8, 10.8), 0.25),
    _Measure("right parting of the lips", _Y, (11.1, -72.1, 11.5), (11.6, -73.8, 10.8), 0.25),
)
"""What no two people differ in, whatever their sex, age and ancestry: lips at rest are closed."""
_PRESSED_MM = 1.5
"""By how much they press upon each other, so that no draw shows what is behind them."""


@dataclass(frozen=True)
class Gauge:
    """What every field of the basis does to every measure.

    Attributes:
        effects: ``(M, K)``: mm per unit of a coefficient.
        seals: ``(3, K)``: the same of the lips' parting.
        sealed_mm: ``(3,)``: what the coefficients of a face with closed lips add to it.
    """

    effects: NDArray[np.float64]
    seals: NDArray[np.float64]
    sealed_mm: NDArray[np.float64]


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

    def rows(measures: Sequence[_Measure], end: str) -> list[int]:
        points = [(measure.axis, np.array(getattr(measure, end))) for measure in measures]
        nearest = [head[np.linalg.norm(skin - point, axis=1).argmin()] for _, point in points]
        return [3 * int(vertex) + axis for vertex, (axis, _) in zip(nearest, points, strict=True)]

    def effects(measures: Sequence[_Measure]) -> NDArray[np.float64]:
        difference = basis.fields[rows(measures, "high")] - basis.fields[rows(measures, "low")]
        return np.asarray(difference.toarray())

    seals = effects(_SEALS)
    return Gauge(effects(_MEASURES), seals, seals @ basis.neutral - _PRESSED_MM)


def draw_measures(rng: Generator, masculinity: float) -> NDArray[np.float64]:
    """Draw how far the measures of a person are from the mean of the person's sex and ancestry.

    Both sides of a face get the same; :mod:`lrsr.identities.shape.anatomy` makes them differ.

    Args:
        rng: Source of randomness.
        masculinity: 0 (female) to 1 (male).

    Returns:
        ``(M,)``, mm, in the order of :data:`_MEASURES`.
    """
    of_axis, own = rng.standard_normal(3), dict[str, float]()
    drawn = np.zeros(len(_MEASURES))
    for k, measure in enumerate(_MEASURES):
        name = measure.name.replace("left ", "").replace("right ", "")
        name = _AS_WIDE_AS.get(name, name)
        if name not in own:
            own[name] = rng.standard_normal()
        common = _IN_COMMON[measure.of]
        z = np.sqrt(common) * of_axis[measure.axis] + np.sqrt(1 - common) * own[name]
        drawn[k] = measure.sd_mm * np.clip(z, -_FARTHEST_SD, _FARTHEST_SD)
        drawn[k] += np.dot((1.0 - masculinity, masculinity), measure.means_mm)
    whole, *parts = (
        _PLACE[f"height of the {part}"] for part in ("lower face", "upper lip", "chin")
    )
    drawn[whole] = drawn[parts].sum()
    return drawn


def fit_measures(
    gauge: Gauge,
    usual: NDArray[np.float64],
    values: NDArray[np.float64],
    columns: NDArray[np.int64],
    width: NDArray[np.float64],
    wanted_mm: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Change sliders as little as possible until they give the measures that are wanted.

    Args:
        gauge: Of the basis.
        usual: ``(K,)`` coefficients of the person with the sliders of the average one.
        values: ``(S,)`` sliders as drawn, positive towards their "+" end.
        columns: ``(S, 2)`` coefficients of each slider's "-" and "+" end.
        width: ``(S,)`` > 0: standard deviation of each slider; wide ones give way more.
        wanted_mm: ``(M,)``, how far the measures shall be from those of ``usual``.

    Returns:
        ``(S,)`` new sliders; with them the lips close, too.
    """
    sd = np.array([measure.sd_mm for measure in (*_MEASURES, *_SEALS)])
    effects = np.concatenate([gauge.effects, gauge.seals])
    without = usual.copy()
    without[columns] = 0.0
    wanted = np.concatenate([wanted_mm + gauge.effects @ usual, gauge.sealed_mm])
    wanted = (wanted - effects @ without) / sd
    minus, plus = (effects[:, ends] / sd[:, None] for ends in columns.T)
    values = values.copy()
    for step in range(_STEPS):  # a slider that crosses zero acts by its other end from then on
        acting = np.where(values >= 0, plus, -minus)
        spread = acting * width**2
        system = spread @ acting.T
        system += np.diag(_TOLERANCE * np.diag(system) + 1e-9)
        change = spread.T @ np.linalg.solve(system, wanted - acting @ values)
        values += change / (1 + step // 2)  # smaller and smaller, lest one goes to and fro
    return values
