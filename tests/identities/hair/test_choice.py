import json
from typing import Any

import numpy as np
import pytest

from lrsr.identities.hair.choice import colour_parameters, sample_hair
from lrsr.identities.hair.styles import STYLES
from lrsr.identities.skin.hair_colour import sample_hair_colour

EUROPEAN = {"african": 0.0, "asian": 0.0, "caucasian": 1.0}
ASIAN = {"african": 0.0, "asian": 1.0, "caucasian": 0.0}
AFRICAN = {"african": 1.0, "asian": 0.0, "caucasian": 0.0}
LONG = {"bob", "long_straight", "long_wavy", "fringe", "tucked"}


def draw(
    count: int, masculinity: float, age: float, ancestry: dict[str, float]
) -> list[dict[str, Any]]:
    rng, shares = np.random.default_rng(4), list(ancestry.values())
    people = []
    for _ in range(count):
        colour = sample_hair_colour(rng, age=age, ancestry=shares, masculinity=masculinity)
        people.append(sample_hair(rng, masculinity, age, ancestry, colour))
    return people


def share(people: list[dict[str, Any]], styles: set[str]) -> float:
    return sum(hair["style"] in styles for hair in people) / len(people)


def test_hair_is_plain_numbers_and_names() -> None:
    hair = draw(1, 0.4, 0.5, EUROPEAN)[0]
    assert json.loads(json.dumps(hair)) == hair
    assert hair["style"] in STYLES
    assert len(hair["hair_colour"]) == 3
    assert 0.0 <= hair["grey"] <= 1.0


def test_same_stream_draws_the_same_hair() -> None:
    assert draw(3, 0.2, 0.2, EUROPEAN) == draw(3, 0.2, 0.2, EUROPEAN)


def test_women_wear_long_hair_more_often() -> None:
    women, men = draw(300, 0.0, 0.3, EUROPEAN), draw(300, 1.0, 0.3, EUROPEAN)
    assert share(women, LONG) > 0.5 > 0.15 > share(men, LONG)


def test_few_women_wear_mens_cuts_and_few_men_womens() -> None:
    women, men = draw(600, 0.1, 0.3, EUROPEAN), draw(600, 0.9, 0.3, EUROPEAN)
    assert share(women, {"crop", "side_parting", "quiff", "slicked_back"}) <= 0.03
    assert share(men, {"bob", "fringe", "long_straight", "long_wavy"}) <= 0.06


def test_womens_hairlines_are_lower() -> None:
    women, men = draw(300, 0.1, 0.0, EUROPEAN), draw(300, 0.9, 0.0, EUROPEAN)
    high = [
        np.mean([h["hairline_deg"] for h in people if h["style"] != "receding"])
        for people in (women, men)
    ]
    assert high[0] + 2.0 < high[1]


@pytest.mark.parametrize("age", [0.0, 0.5, 1.0])
def test_women_are_neither_bald_nor_shaved(age: float) -> None:
    women = draw(300, 0.1, age, EUROPEAN) + draw(300, 0.25, age, AFRICAN)
    assert share(women, {"receding", "horseshoe", "shaved"}) == 0.0


def test_womens_temples_recede_less() -> None:
    women, men = (
        np.mean([h["recession_deg"] for h in draw(300, masculinity, 0.6, EUROPEAN)])
        for masculinity in (0.1, 0.9)
    )
    assert women < 0.6 * men


@pytest.mark.parametrize("ancestry", [EUROPEAN, ASIAN], ids=["european", "asian"])
def test_hair_tells_most_women_from_most_men(ancestry: dict[str, float]) -> None:
    covered = LONG | {"pulled_back", "pixie"}
    women, men = draw(300, 0.15, 0.4, ancestry), draw(300, 0.85, 0.4, ancestry)
    assert share(women, covered) > 0.85
    assert share(men, covered) < 0.25


def test_old_men_are_bald_more_often() -> None:
    bald = {"receding", "horseshoe"}
    old, young = draw(300, 1.0, 1.0, EUROPEAN), draw(300, 1.0, 0.0, EUROPEAN)
    assert share(old, bald) > 3 * share(young, bald)


def test_old_hair_is_greyer() -> None:
    old, young = draw(100, 0.5, 1.0, EUROPEAN), draw(100, 0.5, 0.0, EUROPEAN)
    assert np.mean([h["grey"] for h in old]) > np.mean([h["grey"] for h in young]) + 0.3


def test_african_hair_is_curlier() -> None:
    african, european = draw(300, 0.5, 0.3, AFRICAN), draw(300, 0.5, 0.3, EUROPEAN)
    assert share(african, {"afro", "curly"}) > 3 * share(european, {"afro", "curly"})
    assert np.median([h["curl_mm"] for h in african]) > np.median([h["curl_mm"] for h in european])


def test_african_women_wear_afros_less_often_than_men_and_long_hair_more() -> None:
    women, men = draw(1500, 0.0, 0.4, AFRICAN), draw(1500, 1.0, 0.4, AFRICAN)
    assert 0.05 < share(women, {"afro"}) < share(men, {"afro"})
    assert share(women, {"long_straight"}) > 0.1 > share(men, {"long_straight"})


@pytest.mark.parametrize("ancestry", [AFRICAN, EUROPEAN])
def test_womens_curls_are_long_and_mens_short(ancestry: dict[str, float]) -> None:
    women, men = draw(1500, 0.0, 0.4, ancestry), draw(400, 1.0, 0.4, ancestry)
    assert share(women, {"long_curly"}) > 3 * share(women, {"curly"})
    assert share(men, {"curly"}) > 3 * share(men, {"long_curly"})


def test_hairlines_recede_with_age() -> None:
    old, young = draw(200, 1.0, 1.0, EUROPEAN), draw(200, 1.0, 0.0, EUROPEAN)
    assert np.mean([h["recession_deg"] for h in old]) > np.mean([h["recession_deg"] for h in young])


def test_given_colour_is_used() -> None:
    colour = {"eumelanin": 0.2, "pheomelanin": 0.1, "grey": 0.25}
    hair = sample_hair(np.random.default_rng(0), 0.5, 0.5, EUROPEAN, colour=colour)
    assert hair["grey"] == 0.25
    assert hair["hair_colour"] == colour_parameters(colour)["hair_colour"]


def test_all_styles_occur() -> None:
    people = [
        hair["style"]
        for masculinity in (0.0, 1.0)
        for ancestry in (EUROPEAN, AFRICAN)
        for hair in draw(250, masculinity, 0.6, ancestry)
    ]
    assert set(people) == set(STYLES)
