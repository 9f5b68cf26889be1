import json

import numpy as np
import pytest

from lrsr.identities.morphable import sample_head
from lrsr.identities.person import describe
from lrsr.identities.population import Population
from lrsr.identities.skin.complexion import (
    _BLOOD_LIMITS,
    MELANIN_LIMITS,
    sample_complexion,
)
from lrsr.identities.splits import identity_seed


@pytest.mark.parametrize(
    ("ancestry", "melanin"),
    [((1, 0, 0), 0.21), ((0, 1, 0), 0.030), ((0, 0, 1), 0.0080), ((0.5, 0, 0.5), 0.0410)],
    ids=["african", "asian", "european", "half and half"],
)
def test_melanins_median_follows_ancestry(
    ancestry: tuple[float, float, float], melanin: float
) -> None:
    rng = np.random.default_rng(0)
    drawn = [
        sample_complexion(rng, masculinity=0.5, age=0.3, ancestry=ancestry)["melanin"]
        for _ in range(1600)
    ]
    # the median of 1600 draws of spread 0.58 in the logarithm: 4 standard errors are 7.3 %
    assert np.median(drawn) == pytest.approx(melanin, rel=0.075)
    assert min(drawn) >= MELANIN_LIMITS[0]
    assert max(drawn) <= MELANIN_LIMITS[1]


def test_women_are_lighter_than_men_of_the_same_chance() -> None:
    woman, man = (
        sample_complexion(
            np.random.default_rng(3), masculinity=degree, age=0.3, ancestry=(0.4, 0.3, 0.3)
        )
        for degree in (0.0, 1.0)
    )
    assert woman["melanin"] == pytest.approx(man["melanin"] * np.exp(-0.30))
    assert {**woman, "melanin": 0.0} == {**man, "melanin": 0.0}


@pytest.mark.parametrize(
    ("ancestry", "lowest", "highest"),
    [("african", -60.0, 0.0), ("asian", 15.0, 40.0), ("caucasian", 28.0, 48.0)],
)
def test_cheeks_are_as_light_as_those_of_people(
    ancestry: str, lowest: float, highest: float
) -> None:
    only = Population(ancestry=(ancestry,))
    seeds = [identity_seed("test", index) for index in range(12)]
    heads = [sample_head(seed, texture_size=128, population=only) for seed in seeds]
    assert lowest < np.median([describe(head).ita_deg for head in heads]) < highest


def test_blood_keeps_within_its_limits() -> None:
    rng = np.random.default_rng(0)
    drawn = [
        sample_complexion(rng, masculinity=0.5, age=0.3, ancestry=(0, 0, 1))["blood"]
        for _ in range(400)
    ]
    assert min(drawn) >= _BLOOD_LIMITS[0]
    assert max(drawn) <= _BLOOD_LIMITS[1]
    assert np.median(drawn) == pytest.approx(0.022, rel=0.1)


def test_circles_darken_with_age() -> None:
    rng = np.random.default_rng(0)
    young, old = (
        np.mean(
            [
                sample_complexion(rng, masculinity=0.5, age=age, ancestry=(0, 0, 1))["dark_circles"]
                for _ in range(200)
            ]
        )
        for age in (0.0, 1.0)
    )
    assert old > young + 0.1


def test_no_cheek_is_a_clowns() -> None:
    rng = np.random.default_rng(0)
    drawn = [
        sample_complexion(rng, masculinity=0.5, age=0.3, ancestry=(0, 0, 1)) for _ in range(500)
    ]
    assert max(person["cheeks"] for person in drawn) < 0.6
    assert np.std([person["cheeks"] for person in drawn]) > 0.1


def test_everything_survives_json() -> None:
    rng = np.random.default_rng(0)
    drawn = [
        sample_complexion(rng, masculinity=0.5, age=0.5, ancestry=(0.2, 0.3, 0.5)),
    ]
    assert json.loads(json.dumps(drawn)) == drawn
