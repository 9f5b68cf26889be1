import json

import numpy as np
import pytest

from lrsr.identities.skin.hair_colour import HairColour, hair_rgb, sample_hair_colour


def _hair(eumelanin: float = 1.3, pheomelanin: float = 0.1, grey: float = 0.0) -> HairColour:
    return {"eumelanin": eumelanin, "pheomelanin": pheomelanin, "grey": grey}


def test_brown_hair_as_worked_by_hand() -> None:
    # red: absorption 1.3 * 0.419 + 0.1 * 0.187 = 0.5634; 0.009 + exp(-3.2 * sqrt(0.5634))
    assert hair_rgb(_hair())[0] == pytest.approx(0.009 + np.exp(-3.2 * 0.75060), rel=1e-4)


def test_more_pigment_is_darker() -> None:
    tones = np.array([hair_rgb(_hair(eumelanin=e)) for e in (0.1, 0.5, 1.3, 3.0, 7.0)])
    assert (np.diff(tones, axis=0) < 0).all()
    assert tones[-1].max() < 0.02


def test_pheomelanin_makes_hair_red() -> None:
    red, fair = hair_rgb(_hair(0.2, 1.2)), hair_rgb(_hair(0.6, 0.05))
    assert red[0] / red[2] > 1.4 * fair[0] / fair[2]


def test_white_hair_is_grey_and_brows_stay_darker() -> None:
    white = hair_rgb(_hair(grey=1.0))
    assert white.max() / white.min() < 1.1
    brow = hair_rgb(_hair(grey=1.0), darker=2.0, grey=0.35)
    assert (hair_rgb(_hair(), darker=2.0) < brow).all()
    assert (brow < 0.5 * white).all()


def test_a_share_of_grey_beyond_all_hairs_is_all_hairs() -> None:
    np.testing.assert_array_equal(hair_rgb(_hair(grey=0.9), grey=2.0), hair_rgb(_hair(grey=1.0)))


def test_some_hair_is_dyed_or_born_red() -> None:
    rng = np.random.default_rng(2)
    asian = [sample_hair_colour(rng, age=0.2, ancestry=(0, 1, 0)) for _ in range(300)]
    assert 0.04 < np.mean([hair["eumelanin"] < 3.2 for hair in asian]) < 0.2
    european = [sample_hair_colour(rng, age=0.2, ancestry=(0, 0, 1)) for _ in range(300)]
    assert 0.04 < np.mean([hair["pheomelanin"] > 0.7 for hair in european]) < 0.25


def test_ancestry_and_age_colour_hair() -> None:
    rng = np.random.default_rng(0)

    def draw(age: float, ancestry: tuple[int, int, int]) -> list[HairColour]:
        return [sample_hair_colour(rng, age=age, ancestry=ancestry) for _ in range(200)]

    african, european = draw(0.2, (1, 0, 0)), draw(0.2, (0, 0, 1))
    assert min(hair["eumelanin"] for hair in african) > 2
    assert min(hair["eumelanin"] for hair in european) < 0.4
    assert np.mean([hair["grey"] for hair in african]) < 0.05
    assert np.mean([hair["grey"] for hair in draw(1.0, (0, 0, 1))]) > 0.4
    assert all(hair["grey"] == 0 for hair in draw(0.1, (0, 0, 1)))
    assert json.loads(json.dumps(african[0])) == african[0]


@pytest.mark.parametrize(("masculinity", "expected"), [(0.0, 0.25), (1.0, 0.0)])
def test_one_woman_in_four_dyes_what_turns_grey_and_no_man(
    masculinity: float, expected: float
) -> None:
    rng, shares = np.random.default_rng(2), (0.0, 0.0, 1.0)
    drawn = [
        sample_hair_colour(rng, age=1.0, ancestry=shares, masculinity=masculinity)["grey"]
        for _ in range(600)
    ]
    # at that age grey is 2.1 x 0.48 of all hairs, so what is under a quarter is dyed
    share = float(np.mean(np.array(drawn) < 0.25))
    assert share == pytest.approx(expected, abs=4 * (0.25 * 0.75 / 600) ** 0.5 if expected else 0)
