"""Could this head be an adult's? Proportions, eyes, nose, lips, skin and hair, with their limits.

A gate, not a judge of beauty: limits are those of human beings where the literature has them, else
what a mesh may do before it shows. Tests are those that refuse somebody;
:func:`lrsr.identities.morphable.sample_head` redraws a head whose geometry fails one.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lrsr.identities.face.eyes import Eyes
from lrsr.identities.gate.anthropometry import (
    PROPORTIONS,
    SIGMA_Z_LIMIT,
    Sex,
    brow_rise_degrees,
    limits,
    measure_crookedness,
    measure_lengths,
    nose_depth_mm,
    proportions,
    sigma_z,
    z_scores,
)
from lrsr.identities.gate.folds import turned_share
from lrsr.identities.gate.hair_fit import EVERY_COLUMN, edge_height_mm
from lrsr.identities.gate.intersection import count_nose_crossings, lip_overlap_mm
from lrsr.identities.gate.openings import measure_eyes, mouth_area_mm2, nostril_area_mm2
from lrsr.identities.hair.shell import lay_shell, strand_stream

Points = NDArray[np.float64]

_LIMITS: dict[str, tuple[float, float]] = {
    # Lids of a resting eye open 5.5 to 13 mm; an upper lid covers 1 to 2 mm of the iris, the lower
    # meets it, with age both cover more; openings that differ by 2 mm are a ptosis.
    "eye: visible share of the iris": (0.42, 0.97),
    "eye: middle of the pupil free": (1.0, 1.0),
    "eye: opening, mm": (5.5, 13.0),
    "eye: lids crossed, mm": (0.0, 0.3),
    "eyes: difference of openings, mm": (0.0, 2.0),
    # Seen from below both nostrils open some 130 mm^2; a nose of 120 degrees shows half from front.
    "nose: nostrils seen from in front, mm^2": (0.0, 62.0),
    "nose: walls that cross, pairs": (0.0, 20.0),
    # From its crease in the cheek, 5 mm and more behind its widest point, to the tip a wing is 28
    # to 35 mm long, SD 2 (Farkas 1994).
    "nose: tip before the wings, mm": (10.0, 37.0),
    # A face is widest at the cheekbones; jowls as wide are a caricature's.
    "cheeks: width to that of the face, %": (85.0, 100.5),
    # Brows that are lower at the nose by more are a frown's, those that are higher a clown's.
    "brows: rise from nose to middle, degrees": (0.0, 27.0),
    # Means of the widest lips (African Americans, Farkas 2005): 27 mm to 54 mm.
    "mouth: height of both lips to its width, %": (15.0, 62.0),
    "mouth: lips pressed into each other, mm": (0.0, 3.5),
    # Lips that part by 1 mm along the mouth; the template's own, parted a little, show 25.
    "mouth: inside seen from in front, mm^2": (0.0, 48.0),
    # A mouth that anybody sees to be canted.
    "crooked: cant of the mouth, degrees": (0.0, 5.0),
    "crooked: mouth off the middle, mm": (0.0, 5.0),
    "skin: share of triangles turned over": (0.0, 0.002),
    # A soft edge lies flat.
    "hair: height of the edge on the forehead, mm": (0.0, 14.0),
}
"""Lowest and highest value of each test but the proportions'."""


def check_face(skin: Points, eyes: Eyes, sex: Sex, iris_rad: float) -> list[str]:
    """Judge the shape of a face alone, before anything costly is made of it.

    Args:
        skin: ``(V, 3)`` render vertices, head frame, mm.
        eyes: In the same frame.
        sex: Whose proportions are the norm.
        iris_rad: Half angle of the iris, seen from the eyeball's centre.

    Returns:
        Names of the tests that it fails, with their units: of the first kind that it fails at all,
        since most of those who fail do so by what is measured in no time.
    """
    return (
        _check_proportions(skin, eyes, sex)
        or _outside(_measure_points(skin), _LIMITS)
        or _outside(_measure_eyes(skin, eyes, iris_rad), _LIMITS)
        or _outside(_measure_folds(skin), _LIMITS)
    )


def check_hair(hair: Mapping[str, Any], skin: NDArray[np.float32], seed: int) -> list[str]:
    """Judge how hair would sit on a head; its shell is laid for that.

    Args:
        hair: Its numbers: :func:`lrsr.identities.hair.choice.sample_hair`.
        skin: ``(V, 3)`` render vertices of the skin, mm.
        seed: Of the person.

    Returns:
        Names of the tests that it fails; none of shaved heads, whose hair is below the skin.
    """
    if hair["sunk_mm"] > 0.0:
        return []
    shell = lay_shell(hair, skin, strand_stream(seed), every=EVERY_COLUMN).points
    measured = {"hair: height of the edge on the forehead, mm": edge_height_mm(shell, skin)}
    return _outside(measured, _LIMITS)


def _measure_points(skin: Points) -> dict[str, float]:
    """Measure what single points of a face tell."""
    brows = "brows: rise from nose to middle, degrees"
    return {
        "nose: tip before the wings, mm": nose_depth_mm(skin),
        **measure_crookedness(skin),
        brows: _farther(brow_rise_degrees(skin), *_LIMITS[brows]),
    }


def _measure_folds(skin: Points) -> dict[str, float]:
    """Measure nostrils, mouth and the outside of the face, triangle by triangle."""
    return {
        "skin: share of triangles turned over": turned_share(skin),
        "nose: nostrils seen from in front, mm^2": nostril_area_mm2(skin),
        "nose: walls that cross, pairs": float(count_nose_crossings(skin)),
        "mouth: lips pressed into each other, mm": lip_overlap_mm(skin),
        "mouth: inside seen from in front, mm^2": mouth_area_mm2(skin),
    }


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
        "eyes: difference of openings, mm": abs(heights[0] - heights[1]),
    }


def _farther(values: Sequence[float], low: float, high: float) -> float:
    """Return the value that is farther from the middle between two limits."""
    return max(values, key=lambda value: abs(value - (low + high) / 2))


def _check_proportions(skin: Points, eyes: Eyes, sex: Sex) -> list[str]:
    """Judge every proportion by the norms of a sex, and all of them together."""
    left, right = eyes.pupils
    lengths = measure_lengths(skin, float(np.linalg.norm(right - left)))
    values = proportions(lengths)
    lips = lengths["upper vermilion"] + lengths["lower vermilion"]
    measured = {
        "cheeks: width to that of the face, %": 100.0
        * lengths["cheek width"]
        / lengths["face width"],
        "mouth: height of both lips to its width, %": 100.0 * lips / lengths["mouth width"],
    }
    allowed = {name: _LIMITS[name] for name in measured}
    for proportion in PROPORTIONS:
        name = f"proportion: {proportion.name}, {'%' if proportion.whole else 'mm'}"
        measured[name], allowed[name] = values[proportion.name], limits(proportion, sex)
    measured["proportions: sigma z"] = sigma_z(z_scores(values, sex))
    allowed["proportions: sigma z"] = (0.0, SIGMA_Z_LIMIT)
    return _outside(measured, allowed)


def _outside(
    measured: Mapping[str, float], allowed: Mapping[str, tuple[float, float]]
) -> list[str]:
    """Return the names of measures that do not lie within their limits; NaN does not."""
    return [
        name
        for name, value in measured.items()
        if not allowed[name][0] <= value <= allowed[name][1]
    ]
