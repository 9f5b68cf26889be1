import json
from collections.abc import Mapping

import numpy as np
import pytest
from numpy.typing import NDArray

from lrsr.identities.face.lids import _lid_heights, lid_margins
from lrsr.identities.face.resting import RestingFace
from lrsr.identities.face.template import template
from lrsr.identities.gate.anthropometry import Sex, measure_lengths, proportions, z_scores
from lrsr.identities.population import ANCESTRIES
from lrsr.identities.shape.anatomy import (
    GENDERS,
    REGION_WIDTH,
    Anatomy,
    coefficients,
    sample_anatomy,
)
from lrsr.identities.shape.basis import load_basis
from lrsr.identities.shape.proportions import _MEASURES, load_gauge

EQUAL = dict.fromkeys(ANCESTRIES, 1 / 3)
PLAIN: Anatomy = {
    "muscle": 0.5,
    "weight": 0.5,
    "head_shapes": {},
    "sliders": {},
    "asymmetry": {},
    "expression": {},
}


def draw(seed: int, masculinity: float = 0.5, age: float = 0.2) -> Anatomy:
    rng = np.random.default_rng(seed)
    names = load_basis().names
    return sample_anatomy(
        names, load_gauge(), rng, masculinity=masculinity, age=age, ancestry=EQUAL
    )


def test_average_numbers_give_the_template() -> None:
    basis = load_basis()
    weights = coefficients(basis.names, PLAIN, masculinity=0.5, age=0.25, ancestry=EQUAL)
    np.testing.assert_allclose(weights, basis.neutral, atol=1e-12)


@pytest.mark.parametrize("kind", ["macro", "race"])
@pytest.mark.parametrize("seed", range(5))
def test_weights_of_sex_age_build_and_ancestry_each_sum_to_one(kind: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    basis = load_basis()
    plain = PLAIN.copy()
    plain["muscle"], plain["weight"] = rng.random(2).tolist()
    shares = dict(zip(ANCESTRIES, rng.dirichlet([0.45] * 3).tolist(), strict=True))
    sex, age = rng.random(2).tolist()
    weights = coefficients(basis.names, plain, masculinity=sex, age=age, ancestry=shares)
    chosen = [name.startswith(f"{kind}/") for name in basis.names]
    assert weights[chosen].sum() == pytest.approx(1.0)


def test_a_slider_moves_one_end_only() -> None:
    basis = load_basis()
    plain = PLAIN.copy()
    plain["sliders"] = {"nose/nose-hump-decr-incr": -0.4}
    weights = coefficients(basis.names, plain, masculinity=0.5, age=0.25, ancestry=EQUAL)
    assert weights[basis.column["nose/nose-hump-decr-incr/-"]] == pytest.approx(0.4)
    assert weights[basis.column["nose/nose-hump-decr-incr/+"]] == 0.0


def test_the_same_seed_gives_the_same_plain_numbers() -> None:
    assert json.dumps(draw(3)) == json.dumps(draw(3))
    assert draw(3) != draw(4)


def test_everything_drawn_is_a_field_of_the_basis() -> None:
    column = load_basis().column
    for seed in range(20):
        anatomy = draw(seed)
        assert {f"{slider}/{end}" for slider in anatomy["sliders"] for end in "+-"} <= set(column)
        assert {f"shape/{name}" for name in anatomy["head_shapes"]} <= set(column)
        assert {f"asym/{name}" for name in anatomy["asymmetry"]} <= set(column)
        assert {f"unit/{name}" for name in anatomy["expression"]} <= set(column)


def test_sliders_vary_in_every_region_and_stay_within_their_ends() -> None:
    values = np.array([list(draw(seed)["sliders"].values()) for seed in range(60)])
    assert np.abs(values).max() <= 1.5
    regions = [slider.split("/")[0] for slider in draw(0)["sliders"]]
    for region in REGION_WIDTH:
        spread = values[:, [r == region for r in regions]].std(axis=0)
        assert 0.05 < spread.mean() < 0.6, region


def test_every_measure_spreads_as_among_people_of_one_sex_and_ancestry() -> None:
    basis, gauge = load_basis(), load_gauge()
    extents = []
    for seed in range(300):
        anatomy: Anatomy = {**draw(seed), "expression": {}}
        weights = coefficients(basis.names, anatomy, masculinity=0.5, age=0.2, ancestry=EQUAL)
        extents.append(gauge.effects @ weights)
    spread = np.std(extents, axis=0) / [measure.sd_mm for measure in _MEASURES]
    ours = {m.name: s for m, s in zip(_MEASURES, spread, strict=True) if "parting" not in m.name}
    assert {name: s for name, s in ours.items() if not 0.85 <= s <= 1.15} == {}


Faces = Mapping[str, list[RestingFace]]


def _scores(faces: Faces, sex: Sex) -> dict[str, NDArray[np.float64]]:
    people = []
    for face in faces[sex]:
        ipd_mm = float(np.linalg.norm(face.eyes.pupils[1] - face.eyes.pupils[0]))
        people.append(z_scores(proportions(measure_lengths(face.skin, ipd_mm)), sex))
    return {name: np.array([person[name] for person in people]) for name in people[0]}


@pytest.mark.parametrize("sex", ["female", "male"])
def test_the_average_woman_and_the_average_man_have_the_proportions_of_people(
    resting_faces: Faces, sex: Sex
) -> None:
    means = {name: scores.mean() for name, scores in _scores(resting_faces, sex).items()}
    assert max(map(abs, means.values())) < 1.4, means
    assert np.median(np.abs(list(means.values()))) < 0.5


@pytest.mark.parametrize("sex", ["female", "male"])
def test_people_vary_as_people_do_and_little_more(resting_faces: Faces, sex: Sex) -> None:
    spreads = {name: scores.std() for name, scores in _scores(resting_faces, sex).items()}
    assert 0.8 < np.median(list(spreads.values())) < 1.3
    assert max(spreads.values()) < 1.75, spreads


def _lengths(faces: Faces, sex: str, name: str) -> NDArray[np.float64]:
    return np.array([measure_lengths(face.skin, 63.0)[name] for face in faces[sex]])


@pytest.mark.parametrize(
    ("name", "at_least_mm"),
    [("face height", 5.0), ("lower face height", 3.0), ("chin height", 2.0), ("nose width", 1.5)],
)  # Farkas 1994: 10, 8, 6 and 3 mm
def test_men_have_longer_faces_and_chins_and_wider_noses(
    resting_faces: Faces, name: str, at_least_mm: float
) -> None:
    women, men = (_lengths(resting_faces, sex, name).mean() for sex in GENDERS)
    assert men > women + at_least_mm


def test_women_open_their_eyes_wider_and_both_as_adults_do(resting_faces: Faces) -> None:
    def opening(face: RestingFace) -> float:
        margins = lid_margins(face.skin, face.eyes, template().lids)[..., 12:-12, 1]
        return float((margins[:, 0] - margins[:, 1]).mean(axis=1).mean())

    women, men = (np.mean([opening(face) for face in resting_faces[sex]]) for sex in GENDERS)
    # Palpebral fissures of adults are 8 to 11 mm high in women, 7 to 10 mm in men.
    assert 8.0 < women < 11.0
    assert 7.0 < men < 10.0
    assert women > men + 0.4


def test_upper_lids_stand_over_the_pupils_as_those_of_adults_do(resting_faces: Faces) -> None:
    basis, lids = load_basis(), template().lids
    for sex in GENDERS:
        heights = np.array([_lid_heights(basis, f.weights, lids) for f in resting_faces[sex]])
        assert heights.min() > 2.0  # a lid that is lower needs surgery
        assert np.mean(heights > 2.4) > 0.98
        assert heights.max() < 5.5  # beyond, lids are retracted
        assert 3.3 < heights.mean() < 5.0


def test_womens_brows_stand_higher_over_their_lids(resting_faces: Faces) -> None:
    effects = load_gauge().effects[[m.name for m in _MEASURES].index("height of the brow")]
    women, men = (np.mean([effects @ f.weights for f in resting_faces[sex]]) for sex in GENDERS)
    assert women > men + 1.0


def test_age_adds_to_the_bags_under_the_eyes() -> None:
    young = [draw(seed, age=0.1)["sliders"]["eyes/eye-bag-decr-incr"] for seed in range(60)]
    old = [draw(seed, age=1.0)["sliders"]["eyes/eye-bag-decr-incr"] for seed in range(60)]
    assert np.mean(old) - np.mean(young) > 0.25


def test_men_have_wider_chins_and_necks() -> None:
    women = [draw(seed, masculinity=0.05)["sliders"] for seed in range(40)]
    men = [draw(seed, masculinity=0.95)["sliders"] for seed in range(40)]
    for slider in ("chin/chin-bones-decr-incr", "neck/neck-scale-horiz-decr-incr"):
        assert np.mean([m[slider] for m in men]) > np.mean([w[slider] for w in women]) + 0.2
