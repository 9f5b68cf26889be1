import json

import numpy as np
import pytest

from lrsr.identities.make_up import sample_lips, sample_make_up


def test_only_women_wear_make_up() -> None:
    rng = np.random.default_rng(0)
    women = [sample_make_up(rng, masculinity=0.05) for _ in range(400)]
    men = [sample_make_up(rng, masculinity=0.6) for _ in range(200)]
    for kind, share in (("lipstick", 0.42), ("eyeliner", 0.45), ("eyeshadow", 0.25)):
        worn = np.mean([person[kind] > 0 for person in women])
        expected = share * 0.95**2
        assert worn == pytest.approx(expected, abs=4 * np.sqrt(expected * (1 - expected) / 400))
        assert all(person[kind] == 0 for person in men)


def test_lips_are_redder_than_skin() -> None:
    rng = np.random.default_rng(0)
    lips = [sample_lips(rng) for _ in range(100)]
    assert min(person["blood"] for person in lips) >= 0.6
    assert min(person["melanin"] for person in lips) >= 0


def test_everything_survives_json() -> None:
    rng = np.random.default_rng(0)
    drawn = [sample_lips(rng), sample_make_up(rng, masculinity=0.1)]
    assert json.loads(json.dumps(drawn)) == drawn
