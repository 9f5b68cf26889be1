import numpy as np
import pytest

from lrsr.identities.gate.mildness import PATIENCE, draws_averaged, mean_anatomy
from lrsr.identities.shape.anatomy import Anatomy, sample_anatomy
from lrsr.identities.shape.basis import load_basis
from lrsr.identities.shape.proportions import load_gauge


def drawn(count: int, seed: int = 0) -> list[Anatomy]:
    rng, names = np.random.default_rng(seed), load_basis().names
    return [
        sample_anatomy(names, load_gauge(), rng, masculinity=0.9, age=0.3) for _ in range(count)
    ]


def made(**sides: float) -> Anatomy:
    return {
        "muscle": 0.2,
        "weight": 0.4,
        "head_shapes": {"round": 1.0},
        "sliders": {"nose/width": -1.0},
        "asymmetry": sides,
        "expression": {},
    }


def test_the_mean_of_two_anatomies_is_half_way() -> None:
    other = made(jaw=0.4, brow=0.2) | {"muscle": 0.4, "sliders": {"nose/width": 0.5}}
    mean = mean_anatomy([made(jaw=0.2), other])  # type: ignore[list-item]  # an Anatomy, too
    assert mean["muscle"] == pytest.approx(0.3)
    assert mean["sliders"] == {"nose/width": -0.25}
    assert mean["asymmetry"] == pytest.approx({"jaw": 0.3, "brow": 0.1})
    assert mean["head_shapes"] == {"round": 1.0}


def test_one_anatomy_is_its_own_mean() -> None:
    one = drawn(1)[0]
    assert mean_anatomy([one]) is one


def test_the_mean_of_four_strays_half_as_far_from_the_same_middle() -> None:
    singles = np.array([list(one["sliders"].values()) for one in drawn(80)])
    means = np.array(
        [list(mean_anatomy(drawn(4, seed))["sliders"].values()) for seed in range(1, 21)]
    )
    assert means.std(axis=0).mean() == pytest.approx(singles.std(axis=0).mean() / 2, rel=0.15)
    assert np.abs(means.mean(axis=0) - singles.mean(axis=0)).mean() < 0.1


def test_the_first_attempts_are_single_draws_and_later_ones_ever_milder() -> None:
    counts = [draws_averaged(attempt) for attempt in range(32)]
    assert counts[:PATIENCE] == [1] * PATIENCE
    assert counts == sorted(counts)
    assert counts[PATIENCE] == 2
    assert counts[-1] > 8
