from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from lrsr.identities.face.lids import clear_lids
from lrsr.identities.face.template import template
from lrsr.identities.gate import plausibility
from lrsr.identities.gate.anthropometry import Sex, nose_depth_mm
from lrsr.identities.gate.plausibility import _outside, check_face, check_hair
from lrsr.identities.hair.choice import colour_parameters
from lrsr.identities.hair.styles import style_parameters
from lrsr.identities.shape.anatomy import GENDERS

Points = NDArray[np.float64]

IRIS_RAD = 0.37
EDGE = "hair: height of the edge on the forehead, mm"
COLOUR = {"eumelanin": 2.0, "pheomelanin": 0.2, "grey": 0.1}


def skin() -> Points:
    average = template()
    return clear_lids(average.skin, average.eyes, average.lids)


def judged(face: Points, sex: Sex = "female") -> list[str]:
    return check_face(face, template().eyes, sex, IRIS_RAD)


def pushed(around: tuple[float, float, float], by: tuple[float, float, float], mm: float) -> Points:
    """The template with everything around a point moved, and less and less farther away."""
    moved = skin()
    away = np.linalg.norm(moved - around, axis=1)
    moved += np.exp(-0.5 * (away / mm) ** 2)[:, None] * np.array(by)
    return moved


def scaled(around: tuple[float, float, float], by: tuple[float, float, float], mm: float) -> Points:
    """The template with everything around a point scaled about it."""
    moved = skin()
    offset = moved - around
    share = np.exp(-0.5 * (np.linalg.norm(offset, axis=1) / mm) ** 2)[:, None]
    return np.asarray(moved + share * offset * (np.array(by) - 1.0))


def collapsed_nostrils() -> Points:
    moved = skin()
    near = (np.abs(moved[:, 1] + 45.5) < 6) & (moved[:, 2] > 6) & (np.abs(moved[:, 0]) < 17)
    near &= np.abs(moved[:, 0]) > 8
    moved[near, 0] -= 14.0 * np.sign(moved[near, 0])
    return moved


def closed_eye() -> Points:
    moved = skin()
    index = template().lids.vertices[1]
    offset = moved[index] - template().eyes.pupils[1]
    moved[index[(offset[:, 1] > 0.5) & (offset[:, 1] < 12.0)], 1] -= 8.0
    return moved


def mirrored_cheek() -> Points:
    moved = skin()
    near = np.linalg.norm(moved - (40.0, -35.0, 0.0), axis=1) < 20.0
    middle = moved[near].mean(axis=0)
    moved[near] = middle + (moved[near] - middle) * (-1.0, 1.0, 1.0)
    return moved


def raised_brows(mm: float) -> Points:
    """The template with the middle of both brows raised, or lowered."""
    moved = skin()
    for side in (-1.0, 1.0):
        away = np.linalg.norm(moved - (side * 36.7, 18.2, 5.4), axis=1)
        moved[:, 1] += mm * np.exp(-0.5 * (away / 6.0) ** 2)
    return moved


def jowls() -> Points:
    moved = skin()
    for side in (-1.0, 1.0):
        away = np.linalg.norm(moved - (side * 66.0, -45.0, -48.0), axis=1)
        moved[:, 0] += side * 6.0 * np.exp(-0.5 * (away / 14.0) ** 2)
    return moved


def narrow() -> Points:
    return skin() * (0.75, 1.0, 1.0)


def crooked() -> Points:
    moved = skin()
    moved[:, 0] += 0.1 * moved[:, 1]
    return moved


NOSE, MOUTH, CHIN = (0.0, -41.0, 28.0), (0.0, -73.0, 11.0), (0.0, -115.0, -1.0)
MONSTERS: dict[str, tuple[Callable[[], Points], str]] = {
    "Pinocchio": (lambda: pushed(NOSE, (0, 0, 25), 8), "proportion: nose protrusion, mm"),
    "no nose": (lambda: pushed(NOSE, (0, 0, -16), 9), "nose: tip before the wings, mm"),
    "wide nose": (lambda: scaled(NOSE, (2.2, 1, 1), 25), "proportion: nose to face width, %"),
    "no chin": (lambda: pushed(CHIN, (0, 45, 0), 20), "proportion: face height, mm"),
    "endless chin": (lambda: pushed(CHIN, (0, -60, 0), 25), "proportion: face height, mm"),
    "duck": (lambda: scaled(MOUTH, (1, 2.2, 1), 25), "proportion: lower vermilion, mm"),
    "tiny mouth": (lambda: scaled(MOUTH, (0.2, 1, 1), 25), "proportion: mouth to face width, %"),
    "swollen lips": (
        lambda: scaled(MOUTH, (0.8, 1.45, 1), 25),
        "mouth: height of both lips to its width, %",
    ),
    "jowls": (jowls, "cheeks: width to that of the face, %"),
    "frown": (lambda: raised_brows(9.0), "brows: rise from nose to middle, degrees"),
    "sad clown": (lambda: raised_brows(-9.0), "brows: rise from nose to middle, degrees"),
    "narrow": (narrow, "proportion: face width, mm"),
    "crooked": (crooked, "crooked: mouth off the middle, mm"),
    "collapsed nostrils": (collapsed_nostrils, "nose: walls that cross, pairs"),
    "closed eye": (closed_eye, "eye: visible share of the iris"),
    "hanging lid": (closed_eye, "eyes: difference of openings, mm"),
    "turned triangles": (mirrored_cheek, "skin: share of triangles turned over"),
}


def test_the_average_adult_passes_as_woman_and_as_man() -> None:
    for sex in GENDERS:
        assert judged(skin(), sex) == []


@pytest.mark.parametrize("monster", MONSTERS)
def test_a_monster_fails_for_what_is_wrong_with_it(monster: str) -> None:
    make, reason = MONSTERS[monster]
    assert reason in judged(make())


def test_who_has_other_proportions_is_not_looked_at_further() -> None:
    points = pushed(NOSE, (0, 0, 25), 8)
    assert nose_depth_mm(points) > 37.0
    failed = judged(points)
    assert failed
    assert all(name.startswith("proportion") for name in failed)


def test_a_slight_change_is_no_monster() -> None:
    for changed in (pushed(NOSE, (0, 0, 2), 12), pushed(CHIN, (0, -4, 0), 25)):
        assert judged(changed) == []


def test_the_norms_of_men_let_a_longer_face_pass_than_those_of_women() -> None:
    longer = skin() * (1.03, 1.15, 1.03)
    name = "proportion: face height, mm"
    assert name in judged(longer, "female")
    assert name not in judged(longer, "male")


@pytest.mark.parametrize(("sunk_mm", "fails"), [(0.0, [EDGE]), (10.0, [])], ids=["hair", "shaved"])
def test_hair_whose_edge_stands_off_the_forehead_fails(
    monkeypatch: pytest.MonkeyPatch, sunk_mm: float, fails: list[str]
) -> None:
    head = template().skin.astype(np.float32)
    hair = style_parameters("crop", np.random.default_rng(5)) | colour_parameters(COLOUR)
    hair |= {"sunk_mm": sunk_mm}
    assert check_hair(hair, head, seed=3) == []
    monkeypatch.setattr(plausibility, "edge_height_mm", lambda hair, skin: 14.1)
    assert check_hair(hair, head, seed=3) == fails


@pytest.mark.parametrize(
    ("value", "passes"), [(0.0, True), (10.0, True), (10.1, False), (np.nan, False)], ids=str
)
def test_a_measure_passes_within_its_limits(value: float, passes: bool) -> None:
    assert (_outside({"size": value}, {"size": (0.0, 10.0)}) == []) is passes
