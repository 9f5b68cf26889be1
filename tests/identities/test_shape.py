import json

import numpy as np
import pytest

from lrsr.identities.basis import load_basis
from lrsr.identities.proportions import MEASURES, load_gauge
from lrsr.identities.shape import (
    RACES,
    REGION_WIDTH,
    SHAPE_GAIN,
    Anatomy,
    coefficients,
    sample_anatomy,
)

EQUAL = dict.fromkeys(RACES, 1 / 3)
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
    return sample_anatomy(names, load_gauge(), rng, masculinity=masculinity, age=age)


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
    shares = dict(zip(RACES, rng.dirichlet([0.45] * 3).tolist(), strict=True))
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
        assert 0.05 < spread.mean() < 1.1 * SHAPE_GAIN * REGION_WIDTH[region], region


def test_local_variation_of_proportions_is_human() -> None:
    # The standard deviations of MEASURES are Farkas'; sliders alone must not exceed them by half.
    basis, gauge = load_basis(), load_gauge()
    extents = []
    for seed in range(80):
        plain = PLAIN.copy()
        plain["sliders"] = draw(seed)["sliders"]
        weights = coefficients(basis.names, plain, masculinity=0.5, age=0.25, ancestry=EQUAL)
        extents.append(gauge.effects @ (weights - basis.neutral))
    spread = np.std(extents, axis=0) / np.array([measure.sd_mm for measure in MEASURES])
    assert spread.max() < 1.8
    assert 0.6 < np.median(spread) < 1.4


def test_age_adds_to_the_bags_under_the_eyes() -> None:
    young = [draw(seed, age=0.1)["sliders"]["eyes/eye-bag-decr-incr"] for seed in range(60)]
    old = [draw(seed, age=1.0)["sliders"]["eyes/eye-bag-decr-incr"] for seed in range(60)]
    assert np.mean(old) - np.mean(young) > 0.25


def test_men_have_wider_chins_and_necks() -> None:
    women = [draw(seed, masculinity=0.05)["sliders"] for seed in range(40)]
    men = [draw(seed, masculinity=0.95)["sliders"] for seed in range(40)]
    for slider in ("chin/chin-bones-decr-incr", "neck/neck-scale-horiz-decr-incr"):
        assert np.mean([m[slider] for m in men]) > np.mean([w[slider] for w in women]) + 0.2
