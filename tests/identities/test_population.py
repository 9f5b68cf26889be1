"""Restricting who is drawn changes a person only as far as it must."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
import pytest

from lrsr.errors import InputError
from lrsr.identities.morphable import sample_parameters
from lrsr.identities.population import (
    _PURITY,
    ANCESTRIES,
    EVERYBODY,
    OLDEST_YEARS,
    YOUNGEST_YEARS,
    Population,
    population_from,
)
from lrsr.identities.shape.basis import load_basis

SEEDS = range(12)


def test_the_ancestries_are_those_of_the_shape_space() -> None:
    races = [name.split("/")[1] for name in load_basis().names if name.startswith("race/")]
    assert tuple(dict.fromkeys(races)) == ANCESTRIES


def test_everybody_is_who_they_were_without_a_population() -> None:
    assert sample_parameters(7, population=Population()) == sample_parameters(7)


def test_everybody_are_women_and_men_of_all_ages(
    crowds: Mapping[str, list[dict[str, Any]]],
) -> None:
    people = crowds["any"]
    assert 1 / 4 < np.mean([person["sex"] == "female" for person in people]) < 3 / 4
    ages = [person["age_years"] for person in people]
    assert YOUNGEST_YEARS <= min(ages) < 35
    assert 60 < max(ages) <= OLDEST_YEARS


@pytest.mark.parametrize("sex", ["female", "male"])
def test_one_sex_is_all_there_is(sex: Any) -> None:
    only = Population(sex)
    people = [sample_parameters(seed, population=only) for seed in SEEDS]
    assert {person["sex"] for person in people} == {sex}
    low, high = {"female": (0.01, 0.12), "male": (0.75, 0.98)}[sex]  # as among everybody
    assert all(low <= person["masculinity"] <= high for person in people)


def test_who_has_the_wanted_sex_stays_who_they_were() -> None:
    for seed in SEEDS:
        person = sample_parameters(seed)
        assert sample_parameters(seed, population=Population(person["sex"])) == person


@pytest.mark.parametrize("race", ANCESTRIES)
def test_a_single_ancestry_is_most_of_everyone(race: str) -> None:
    only = Population(ancestry=(race,))
    shares = [sample_parameters(seed, population=only)["ancestry"] for seed in SEEDS]
    assert min(share[race] for share in shares) >= _PURITY
    np.testing.assert_allclose([sum(share.values()) for share in shares], 1.0)


def test_two_ancestries_keep_their_proportion() -> None:
    shares = Population(ancestry=("asian", "african")).shares([0.1, 0.3, 0.6])
    np.testing.assert_allclose(shares, [0.85 * 0.25 + 0.015, 0.85 * 0.75 + 0.045, 0.09], rtol=1e-8)


def test_a_drawn_share_of_nothing_at_all_can_still_be_restricted() -> None:
    shares = Population(ancestry=("asian",)).shares([1.0, 0.0, 0.0])
    np.testing.assert_allclose(shares, [0.15, 0.85, 0.0], rtol=1e-8)


def test_ages_keep_to_their_span_and_their_order() -> None:
    young = Population(age_years=(30, 40))
    everyone = [sample_parameters(seed)["age_years"] for seed in SEEDS]
    narrowed = [sample_parameters(seed, population=young)["age_years"] for seed in SEEDS]
    assert 30 <= min(narrowed) < max(narrowed) <= 40
    assert np.argsort(everyone).tolist() == np.argsort(narrowed).tolist()


def test_the_order_in_which_ancestries_are_named_does_not_matter() -> None:
    assert Population(ancestry=("caucasian", "african")) == Population(
        ancestry=("african", "caucasian")
    )
    assert Population(ancestry=tuple(reversed(ANCESTRIES))) == EVERYBODY


@pytest.mark.parametrize(
    ("population", "tag"),
    [
        (EVERYBODY, ""),
        (Population("male"), "male"),
        (Population(ancestry=("asian", "african")), "african-asian"),
        (Population("female", ("caucasian",), (30, 40.5)), "female-caucasian-30to40.5"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_population_has_a_short_name(population: Population, tag: str) -> None:
    assert population.tag == tag


def test_a_population_comes_back_from_plain_values() -> None:
    population = Population("female", ("asian",), (30, 50))
    assert population_from(asdict(population)) == population


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"sex": "woman"}, "identities.sex=woman: wanted one of any, female, male"),
        ({"ancestry": ("martian",)}, r"identities.ancestry=\[martian\]: wanted some of african"),
        ({"ancestry": ()}, r"identities.ancestry=\[\]"),
        ({"age_years": (12, 40)}, r"identities.age_years=\[12,40\]: .* within 25 to 75"),
        ({"age_years": (40, 30)}, r"identities.age_years=\[40,30\]"),
        ({"age_years": (30,)}, r"identities.age_years=\[30\]"),
        ({"age_years": (30, float("nan"))}, r"identities.age_years=\[30,nan\]"),
    ],
    ids=str,
)
def test_who_cannot_be_drawn_is_named(wrong: dict[str, Any], says: str) -> None:
    with pytest.raises(InputError, match=says):
        Population(**wrong)


@pytest.mark.parametrize("values", [{}, {"sex": "any", "ancestry": 3, "age_years": [30, 40]}])
def test_what_is_no_population_is_refused(values: dict[str, object]) -> None:
    with pytest.raises(InputError, match="no population"):
        population_from(values)
