import json

import numpy as np
import pytest

from lrsr.identities.hair.styles import (
    AT_HAIRLINE_MM,
    LOWER_AZIMUTHS_DEG,
    STYLES,
    style_parameters,
)


def test_there_are_nineteen_styles() -> None:
    assert len(STYLES) == len(set(STYLES)) == 19


@pytest.mark.parametrize("style", STYLES)
def test_every_style_is_described_by_the_same_plain_numbers(style: str) -> None:
    values = style_parameters(style, np.random.default_rng(1))
    assert set(values) == set(style_parameters("buzz", np.random.default_rng(2)))
    assert json.loads(json.dumps(values)) == values
    assert len(values["lower_mm"]) == len(LOWER_AZIMUTHS_DEG)


@pytest.mark.parametrize("style", STYLES)
def test_sides_are_thinner_than_a_hand_and_thicker_than_skin(style: str) -> None:
    for seed in range(20):
        values = style_parameters(style, np.random.default_rng(seed))
        assert 1.0 < values["side_mm"] < 60.0
        assert 1.0 < values["back_mm"] < 60.0


def test_partings_lie_on_both_sides() -> None:
    partings = [
        style_parameters("side_parting", np.random.default_rng(seed))["parting_deg"]
        for seed in range(40)
    ]
    assert 8 <= sum(parting > 0 for parting in partings) <= 32


def test_a_bob_ends_between_mouth_and_collar() -> None:
    low = style_parameters("bob", np.random.default_rng(0))["lower_mm"]
    assert all(-130.0 < height < -50.0 for height in low)


def test_hair_behind_the_ears_leaves_the_ears_free() -> None:
    low = style_parameters("tucked", np.random.default_rng(0))["lower_mm"]
    assert low[:4] == [AT_HAIRLINE_MM] * 4
    assert max(low[4:]) < -80.0
