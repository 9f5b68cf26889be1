"""Which anatomy does a person have? Coefficients of the shape space, varied but plausible.

Single targets are drawn from a normal distribution, but their joint extremes are cut: within one
region (nose, mouth, ...) the vector of draws is shortened to the length that a typical vector has,
each slider saturates softly, and together they keep to human proportions
(:mod:`lrsr.identities.shape.proportions`). Widths and dampings come from looking at some hundred
heads.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple, TypedDict

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from lrsr.identities.population import ANCESTRIES
from lrsr.identities.shape.proportions import Gauge, draw_measures, fit_measures

GENDERS = ("female", "male")
AGES = ("young", "old")
LEVELS = ("min", "average", "max")

_ANCESTRY_GAIN = 1.25
"""Exaggerates a mix of ancestries about the equal one."""
_USUAL_ASYMMETRY = 0.21
_ASYMMETRY = {"nose": 0.37, "ear": 0.1}
"""Spread of the one-sided targets of a part, so that noses and chins stray from the midline by
Farkas' 1.2 and 1.6 mm."""

REGION_WIDTH = {
    "head": 0.1,
    "forehead": 0.22,
    "eyebrows": 0.5,
    "eyes": 0.5,
    "nose": 0.5,
    "mouth": 0.42,
    "cheek": 0.22,
    "chin": 0.28,
    "ears": 0.2,
    "neck": 0.2,
}
"""Standard deviation of what no measure sees of a slider; 1 is the full length of a MakeHuman
target."""


class _Trend(NamedTuple):
    """What is added to a slider, beyond MakeHuman's own differences; the sign is the direction.

    Attributes:
        average: In everybody, so that the average of each sex has the proportions that were
            measured on people (Farkas 1994): MakeHuman's eyes are a quarter too small, its ears too
            large, its jaws and necks too wide, its mouths a little sad.
        sex: In a man; as much is taken away in a woman.
        age: Per unit of age beyond 0.3, more in some people than in others.
        women_age: Likewise in a woman alone: what makes women look feminine also hides their age.
    """

    average: float = 0.0
    sex: float = 0.0
    age: float = 0.0
    women_age: float = 0.0


_TRENDS = {
    "head/head-age-decr-incr": _Trend(average=-0.2, sex=0.36, age=1.2, women_age=0.5),
    "eyes/eye-bag-decr-incr": _Trend(age=1.1, women_age=0.7),
    "cheek/cheek-trans-down-up": _Trend(age=-0.75, women_age=-0.8),
    "eyes/eye-eyefold-down-up": _Trend(age=-0.6, women_age=-0.4),
    "mouth/mouth-laugh-lines-in-out": _Trend(age=0.75, women_age=0.8),
    "neck/neck-double-decr-incr": _Trend(age=0.6, women_age=0.4),
    "ears/ear-lobe-decr-incr": _Trend(age=0.5),
    "mouth/mouth-upperlip-height-decr-incr": _Trend(average=-0.1, sex=-0.1, age=-0.5),
    "mouth/mouth-lowerlip-height-decr-incr": _Trend(average=-0.1, sex=-0.1, age=-0.5),
    "cheek/cheek-volume-decr-incr": _Trend(women_age=-0.3),
    "chin/chin-width-decr-incr": _Trend(sex=0.45),
    "chin/chin-bones-decr-incr": _Trend(average=-0.15, sex=0.35),
    "chin/chin-height-decr-incr": _Trend(sex=0.25),
    "chin/chin-prominent-decr-incr": _Trend(sex=0.3),
    "cheek/cheek-bones-decr-incr": _Trend(sex=-0.2),
    "eyes/eye-scale-decr-incr": _Trend(average=0.5, sex=-0.06),
    "eyes/eye-trans-in-out": _Trend(average=0.15),
    "eyes/eye-height2-decr-incr": _Trend(average=0.4, sex=-0.3),
    "eyebrows/eyebrows-trans-backward-forward": _Trend(sex=0.3),
    "eyebrows/eyebrows-trans-down-up": _Trend(sex=-0.7),
    "neck/neck-scale-horiz-decr-incr": _Trend(average=-0.7, sex=0.3),
    "neck/neck-scale-depth-decr-incr": _Trend(sex=0.3),
    "nose/nose-scale-vert-decr-incr": _Trend(average=-0.2, sex=0.2),
    "nose/nose-width2-decr-incr": _Trend(sex=0.35),
    "nose/nose-width1-decr-incr": _Trend(sex=0.3),
    "nose/nose-scale-horiz-decr-incr": _Trend(average=-0.1, sex=0.18),
    "nose/nose-width3-decr-incr": _Trend(average=-0.05, sex=0.1),
    "nose/nose-volume-decr-incr": _Trend(average=-0.4, sex=0.2),
    "nose/nose-point-width-decr-incr": _Trend(average=-0.2, sex=0.1),
    "nose/nose-scale-depth-decr-incr": _Trend(average=-0.05),
    "nose/nose-point-down-up": _Trend(average=0.05, sex=-0.12),
    "head/head-scale-horiz-decr-incr": _Trend(average=-0.1, sex=-0.1),
    "head/head-fat-decr-incr": _Trend(average=-0.2, sex=-0.12),
    "mouth/mouth-trans-backward-forward": _Trend(average=-0.15),
    "mouth/mouth-scale-depth-decr-incr": _Trend(average=-0.15),
    "mouth/mouth-upperlip-volume-decr-incr": _Trend(average=-0.2),
    "mouth/mouth-lowerlip-volume-decr-incr": _Trend(average=-0.2),
    "mouth/mouth-trans-down-up": _Trend(average=0.16, sex=-0.1),
    "mouth/mouth-scale-horiz-decr-incr": _Trend(average=0.08, sex=-0.06),
    "mouth/mouth-angles-down-up": _Trend(average=0.3, sex=-0.2),
    "cheek/cheek-inner-decr-incr": _Trend(average=0.2, sex=-0.2),
    "eyes/eye-push2-in-out": _Trend(average=0.9),
    "eyes/eye-push1-in-out": _Trend(average=-0.2),
    "ears/ear-scale-decr-incr": _Trend(average=-0.35),
    "nose/nose-flaring-decr-incr": _Trend(average=0.2),
}

_RESTING_UNITS = {
    "browInnerUp": 0.08,
    "browDown": 0.06,
    "browOuterUp": 0.3,
    "cheekSquint": 0.25,
    "eyeSquint": 0.55,
    "eyeBlink": 0.25,
    "mouthDimple": 0.25,
    "mouthFrown": 0.04,
    "mouthPress": 0.23,
    "mouthPucker": 0.12,
    "mouthShrugLower": 0.08,
    "mouthSmile": 0.35,
    "noseSneer": 0.09,
    "jawForward": 0.15,
}
"""Face units of a resting face and the width of their strength."""
_EXPRESSION_SHARE = 0.25
"""How many people show each of them."""


class Anatomy(TypedDict):
    """Everything that sets a head's geometry, as plain numbers.

    ``sliders`` run from -1.5 to 1.5, where -1 and +1 are the ends of a MakeHuman pair;
    ``head_shapes``, ``asymmetry`` and ``expression`` are weights of single targets.
    """

    muscle: float
    weight: float
    head_shapes: dict[str, float]
    sliders: dict[str, float]
    asymmetry: dict[str, float]
    expression: dict[str, float]


def _pairs(names: Sequence[str]) -> dict[str, list[str]]:
    """List the sliders ("region/pair") of every region."""
    pairs: dict[str, list[str]] = {region: [] for region in REGION_WIDTH}
    for name in names:
        region, *rest = name.split("/")
        if region in pairs and rest[-1] == "+":
            pairs[region].append(f"{region}/{rest[0]}")
    return pairs


def _fit_sliders(
    names: Sequence[str],
    gauge: Gauge,
    usual: Mapping[str, float],
    weights: NDArray[np.float64],
    masculinity: float,
    rng: Generator,
) -> dict[str, float]:
    """Draw sliders that give a person's measures.

    Args:
        names: The fields of the basis.
        gauge: What they do to the measures of a face.
        usual: The average person's sliders.
        weights: ``(K,)`` coefficients of the person with these sliders.
        masculinity: 0 (female) to 1 (male).
        rng: Source of randomness.
    """
    place = {name: k for k, name in enumerate(names)}
    ends = np.array([[place[f"{slider}/-"], place[f"{slider}/+"]] for slider in usual])
    width = np.array([REGION_WIDTH[slider.split("/")[0]] for slider in usual])
    drawn = np.array(list(usual.values())) + width * rng.standard_normal(len(usual))
    fitted = fit_measures(gauge, weights, drawn, ends, width, draw_measures(rng, masculinity))
    return dict(zip(usual, np.clip(fitted, -1.5, 1.5).tolist(), strict=True))


def _usual_sliders(
    names: Sequence[str], masculinity: float, age: float, rng: Generator
) -> dict[str, float]:
    """Return the sliders of the average person of that sex and age; some age more than others."""
    sliders = {slider: 0.0 for region in _pairs(names).values() for slider in region}
    beyond = max(0.0, age - 0.3)
    for slider, trend in _TRENDS.items():
        value = trend.average + trend.sex * (2.0 * masculinity - 1.0)
        if trend.age:
            value += trend.age * beyond * abs(rng.normal(0.7, 0.5))
        sliders[slider] = value + (trend.women_age * beyond if masculinity < 0.5 else 0.0)
    return sliders


def _draw_expression(names: Sequence[str], rng: Generator) -> dict[str, float]:
    known = {name.removeprefix("unit/") for name in names}
    strengths: dict[str, float] = {}
    for unit, width in _RESTING_UNITS.items():
        shown, strength = rng.random() < _EXPRESSION_SHARE, abs(rng.normal(0.0, width))
        sides = zip((f"{unit}Left", f"{unit}Right"), rng.uniform(0.75, 1.25, 2), strict=True)
        if shown:
            factors = {unit: 1.0} if unit in known else dict(sides)
            strengths |= {side: float(strength * factor) for side, factor in factors.items()}
    return strengths


def sample_anatomy(
    names: Sequence[str],
    gauge: Gauge,
    rng: Generator,
    *,
    masculinity: float,
    age: float,
    ancestry: Mapping[str, float],
) -> Anatomy:
    """Draw a person's anatomy beyond sex, age and ancestry.

    Args:
        names: The fields of the basis.
        gauge: What they do to the measures of a face.
        rng: Source of randomness.
        masculinity: 0 (female) to 1 (male).
        age: 0 (25 years) to 1 (old).
        ancestry: Shares of :data:`lrsr.identities.population.ANCESTRIES`, summing to 1.

    Returns:
        Plain numbers; :func:`coefficients` turns them into a shape.
    """
    shapes = [name.split("/")[1] for name in names if name.startswith("shape/")]
    sides = [name.split("/")[1] for name in names if name.startswith("asym/")]
    amount = rng.uniform(0.1, 0.5)
    spread = [_ASYMMETRY.get(side.split("-")[1], _USUAL_ASYMMETRY) for side in sides]
    asymmetry = np.clip(rng.normal(0.0, spread), -0.6, 0.6)
    traits = {"masculinity": masculinity, "age": age}
    anatomy: Anatomy = {
        "muscle": float(rng.uniform(0.22, 0.5 + 0.25 * masculinity)),
        "weight": float(np.clip(rng.normal(0.5, 0.22), 0.04, 0.96)),
        "head_shapes": dict(
            zip(shapes, (amount * rng.dirichlet([0.3] * len(shapes))).tolist(), strict=True)
        ),
        "sliders": _usual_sliders(names, masculinity, age, rng),
        "asymmetry": {
            side: float(value) for side, value in zip(sides, asymmetry, strict=True) if value > 0
        },
        "expression": _draw_expression(names, rng),
    }
    usual = coefficients(names, anatomy, **traits, ancestry=ancestry)
    sliders = _fit_sliders(names, gauge, anatomy["sliders"], usual, masculinity, rng)
    return {**anatomy, "sliders": sliders}


def _tents(value: float) -> dict[str, float]:
    """Weights of min, average and max for a value in [0, 1]; they sum to 1."""
    return {
        "min": max(0.0, 1.0 - 2.0 * value),
        "average": 1.0 - abs(2.0 * value - 1.0),
        "max": max(0.0, 2.0 * value - 1.0),
    }


def coefficients(
    names: Sequence[str],
    anatomy: Anatomy,
    *,
    masculinity: float,
    age: float,
    ancestry: Mapping[str, float],
) -> NDArray[np.float64]:
    """Turn plain numbers into coefficients of the basis.

    Args:
        names: The fields of the basis, in order.
        anatomy: As :func:`sample_anatomy` draws it.
        masculinity: 0 (female) to 1 (male).
        age: 0 (MakeHuman's young adult) to 1 (its old one).
        ancestry: Shares of :data:`lrsr.identities.population.ANCESTRIES`, summing to 1.

    Returns:
        ``(K,)``.
    """
    sex = {"female": 1.0 - masculinity, "male": masculinity}
    ages = {"young": 1.0 - age, "old": age}
    muscle, weight = _tents(anatomy["muscle"]), _tents(anatomy["weight"])
    values: dict[str, float] = {}
    for gender in GENDERS:
        for years in AGES:
            both = sex[gender] * ages[years]
            for m in LEVELS:
                for w in LEVELS:
                    values[f"macro/{gender}/{years}/{m}/{w}"] = both * muscle[m] * weight[w]
            for race in ANCESTRIES:
                share = 1 / 3 + _ANCESTRY_GAIN * (ancestry[race] - 1 / 3)
                values[f"race/{race}/{gender}/{years}"] = both * share
    for slider, value in anatomy["sliders"].items():
        values[f"{slider}/+"], values[f"{slider}/-"] = max(value, 0.0), max(-value, 0.0)
    values |= {f"shape/{name}": value for name, value in anatomy["head_shapes"].items()}
    values |= {f"asym/{name}": value for name, value in anatomy["asymmetry"].items()}
    values |= {f"unit/{name}": value for name, value in anatomy["expression"].items()}
    return np.array([values.get(name, 0.0) for name in names])
