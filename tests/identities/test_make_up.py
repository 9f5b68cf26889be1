import json

import numpy as np
import pytest

from lrsr.identities.make_up import Lips, sample_lips, sample_make_up


def _lips(masculinity: float, melanin: float) -> list[Lips]:
    rng = np.random.default_rng(0)
    return [sample_lips(rng, masculinity=masculinity, melanin=melanin) for _ in range(200)]


def test_only_women_wear_make_up() -> None:
    rng = np.random.default_rng(0)
    women = [sample_make_up(rng, masculinity=0.05) for _ in range(400)]
    men = [sample_make_up(rng, masculinity=0.6) for _ in range(200)]
    for kind, share in (("lipstick", 0.5), ("eyeliner", 0.5), ("eyeshadow", 0.3), ("blush", 0.4)):
        worn = np.mean([person[kind] > 0 for person in women])
        expected = share * 0.95**2
        assert worn == pytest.approx(expected, abs=4 * np.sqrt(expected * (1 - expected) / 400))
        assert all(person[kind] == 0 for person in men)


def test_lipsticks_are_reflectances_and_strong_colours_are_rare() -> None:
    rng = np.random.default_rng(1)
    colours = np.array(
        [sample_make_up(rng, masculinity=0.1)["lipstick_colour"] for _ in range(400)]
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
    drawn = [_lips(0.1, 0.02)[0], sample_make_up(rng, masculinity=0.1)]
    assert json.loads(json.dumps(drawn)) == drawn
