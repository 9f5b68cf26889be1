import json

import numpy as np
import pytest

from lrsr.identities.skin.make_up import Lips, sample_lips, sample_make_up


def _lips(masculinity: float, melanin: float) -> list[Lips]:
    rng = np.random.default_rng(0)
    return [sample_lips(rng, masculinity=masculinity, melanin=melanin) for _ in range(200)]


def test_only_women_wear_make_up() -> None:
    rng = np.random.default_rng(0)
    women = [sample_make_up(rng, masculinity=0.05, age=0.2) for _ in range(400)]
    men = [sample_make_up(rng, masculinity=0.6, age=0.2) for _ in range(200)]
    shares = {"lipstick": 0.5, "eyeliner": 0.95, "eyeshadow": 0.4, "blush": 0.4}
    for kind, share in shares.items():
        worn = np.mean([person[kind] > 0 for person in women])
        expected = share * 0.95**2
        assert worn == pytest.approx(expected, abs=4 * np.sqrt(expected * (1 - expected) / 400))
        assert all(person[kind] == 0 for person in men)


@pytest.mark.parametrize("masculinity", [0.02, 0.15, 0.25])
def test_most_women_wear_some_make_up_but_not_everything(masculinity: float) -> None:
    rng = np.random.default_rng(3)
    kinds = ("lipstick", "eyeliner", "eyeshadow", "blush")
    women = [sample_make_up(rng, masculinity=masculinity, age=0.2) for _ in range(300)]
    worn = np.array([[woman[kind] > 0 for kind in kinds] for woman in women])
    assert worn.any(axis=1).mean() > 0.75
    assert worn.all(axis=1).mean() < 0.3


def test_no_man_wears_any() -> None:
    rng = np.random.default_rng(4)
    for masculinity in np.linspace(0.5, 1.0, 100):
        man = sample_make_up(rng, masculinity=masculinity, age=0.2)
        assert man["lipstick"] == man["eyeliner"] == man["eyeshadow"] == man["blush"] == 0.0


def test_what_is_worn_is_an_opacity() -> None:
    rng = np.random.default_rng(5)
    for _ in range(200):
        woman = sample_make_up(rng, masculinity=0.05, age=0.2)
        for kind in ("lipstick", "eyeliner", "eyeshadow", "blush"):
            assert 0.0 <= woman[kind] < 1.0


def test_lipsticks_are_reflectances_and_strong_colours_are_rare() -> None:
    rng = np.random.default_rng(1)
    colours = np.array(
        [sample_make_up(rng, masculinity=0.1, age=0.2)["lipstick_colour"] for _ in range(400)]
    )
    assert colours.min() > 0
    assert colours.max() < 0.8
    assert np.mean(colours[:, 0] > 5 * colours[:, 1]) < 0.2


def test_lips_are_redder_than_skin_and_womens_more() -> None:
    women, men = (np.mean([lips["blood"] for lips in _lips(m, 0.02)]) for m in (0.1, 0.9))
    assert min(lips["blood"] for lips in _lips(1.0, 0.3)) > 0.2
    assert women > men + 0.3


def test_lips_of_dark_skin_are_browner() -> None:
    fair, dark = (np.mean([lips["blood"] for lips in _lips(0.1, m)]) for m in (0.02, 0.25))
    assert dark < 0.85 * fair


def test_everything_survives_json() -> None:
    rng = np.random.default_rng(0)
    drawn = [_lips(0.1, 0.02)[0], sample_make_up(rng, masculinity=0.1, age=0.2)]
    assert json.loads(json.dumps(drawn)) == drawn
