"""Statistics of noise whose strength and mean are known, and slopes that are known from them."""

from collections.abc import Mapping

import numpy as np
import pytest
import torch

from lrsr.calibration.objective import Objective
from lrsr.calibration.parameters import Parameter
from lrsr.calibration.picture_statistics import BENT_NAMES, NAMES
from lrsr.errors import InputError

LEVEL = Parameter("level", 0.5, 0.2, 0.8, 0.1, False, "of a wall")
GRAIN = Parameter("grain", 0.02, 0.001, 0.1, 1.0, True, "of its pictures")
IDLE = Parameter("idle", 1.0, 0.1, 9.0, 1.0, True, "no effect")
BRIGHTNESS = NAMES.index("luminance_50")
TRUE = {"level": 0.5, "grain": 0.02}
BRIGHTER = {"level": 0.6, "grain": 0.02}


def walls(values: Mapping[str, float], seed: int, count: int = 24) -> torch.Tensor:
    """Walls, some lighter than others, with patterns of different strength, and grain."""
    generator = torch.Generator().manual_seed(seed)
    paint = 0.04 * torch.randn(count, 1, 1, 1, generator=generator)
    strength = 0.05 * torch.rand(count, 1, 1, 1, generator=generator)
    coarse = torch.randn(count, 3, 4, 4, generator=generator)
    pattern = strength * torch.nn.functional.interpolate(coarse, size=(16, 16))
    grain = values.get("grain", 0.02) * torch.randn(count, 3, 16, 16, generator=generator)
    return (values["level"] + paint + pattern + grain).clamp(0, 1)


def even_walls(values: Mapping[str, float], draw: int, count: int = 24) -> torch.Tensor:
    """Return walls whose paint hardly differs, with a little grain."""
    generator = torch.Generator().manual_seed(100 + draw)
    grain = 0.02 * torch.randn(count, 3, 16, 16, generator=generator)
    paint = 0.02 * torch.arange(count)[:, None, None, None] / count
    return (values["level"] + paint + grain).clamp(0, 1)


def strangers(values: Mapping[str, float], draw: int) -> torch.Tensor:
    return walls(values, 100 + draw)


@pytest.fixture
def objective() -> Objective:
    made = Objective(walls(BRIGHTER, 7, 30), strangers, (LEVEL, IDLE), 1.0)
    made.weigh(np.zeros(2), shrinkage=0.3)
    return made


def test_the_means_are_those_of_the_pictures(objective: Objective) -> None:
    away = 3 * 255 * 0.04 / np.sqrt(24)  # of so few walls
    assert objective.measured.shape == (len(BENT_NAMES),)
    assert objective.measured[BRIGHTNESS] == pytest.approx(255 * 0.6, abs=away)
    assert objective.simulated(np.array([1.0, 0.0]))[BRIGHTNESS] == pytest.approx(
        255 * 0.6, abs=away
    )
    assert objective.simulated(np.zeros(2))[BRIGHTNESS] == pytest.approx(255 * 0.5, abs=away)


def test_chance_falls_with_the_number_of_people(objective: Objective) -> None:
    weights = torch.tensor([0.299, 0.587, 0.114])[:, None, None]  # BT.601
    medians = [
        np.median(255 * (pictures * weights).sum(1).flatten(1).numpy(), axis=1)
        for pictures in (walls(BRIGHTER, 7, 30), strangers(TRUE, 0))
    ]
    variance = sum(np.square(one - one.mean()).sum() for one in medians) / 53
    assert objective.spread[BRIGHTNESS] == pytest.approx(
        np.sqrt(variance * (1 / 30 + 1 / 24)), rel=0.02
    )


@pytest.mark.usefixtures("one_thread")
@pytest.mark.parametrize(("pictures", "others"), [(20, 20), (50, 60)])
def test_errors_and_misfit_are_those_of_repeated_estimates(pictures: int, others: int) -> None:
    # 0.96 and 0.93 standard errors, misfits of 0.88 and 0.85; of the people whom the weights were
    # made from, chance would seem 2.6 times too small with 20.
    away, misfits = [], []
    for k in range(30):
        made = Objective(
            walls(TRUE, 1000 + k, pictures),
            lambda values, _, k=k: walls(values, 5000 + k, others),
            (LEVEL, GRAIN),
            1.0,
        )
        made.weigh(np.zeros(2), shrinkage=0.3)
        slopes = made.slopes(np.zeros(2), np.array([0.3, 0.3]))
        step = np.linalg.pinv(made.jacobian(slopes)) @ made.residuals(np.zeros(2))
        away.append(step / np.sqrt(np.diag(made.covariance(slopes))))
        misfits.append(made.misfit(made.simulated(np.zeros(2))))
    assert 0.7 < np.sqrt(np.square(away).mean()) < 1.3
    assert 0.7 < np.mean(misfits) < 1.3


def test_at_the_answer_only_chance_is_left() -> None:
    # 1.2, and 0.8 to 1.3 with other noise; 70 to 88 elsewhere.
    made = Objective(even_walls(BRIGHTER, 7, 30), even_walls, (LEVEL, IDLE), 1.0)
    made.weigh(np.zeros(2), shrinkage=0.3)
    assert made.misfit(made.simulated(np.array([1.0, 0.0]))) < 2
    assert made.misfit(made.simulated(np.zeros(2))) > 50


def test_slopes_are_those_of_long_differences(objective: Objective) -> None:
    place, step = np.array([1.0, 0.0]), np.array([0.5, 0.5])
    jacobian = objective.jacobian(objective.slopes(place, step))
    by_hand = objective.residuals(np.array([1.5, 0.0])) - objective.residuals(np.array([0.5, 0.0]))
    assert np.allclose(jacobian[:, 0], by_hand)
    assert np.allclose(jacobian[:-2, 1], 0)
    assert np.array_equal(jacobian[-2:], np.eye(2))


def test_what_has_no_effect_keeps_the_guess_s_doubt(objective: Objective) -> None:
    slopes = objective.slopes(np.array([1.0, 0.0]), np.array([0.3, 0.3]), draws=2)
    covariance = objective.covariance(slopes)
    assert covariance[1, 1] == pytest.approx(1)
    assert covariance[0, 1] == pytest.approx(0, abs=1e-9)


def test_halves_that_disagree_prove_nothing(objective: Objective) -> None:
    first, _ = objective.slopes(np.array([1.0, 0.0]), np.array([0.3, 0.3]))
    # Their product is negative: taken for a curvature it would make the error infinite near -1.
    assert objective.covariance((first, -first)) == pytest.approx(np.eye(2))


def test_no_trial_leaves_the_range_and_the_slope_is_that_of_the_shorter_way() -> None:
    tried: list[float] = []

    def camera(values: Mapping[str, float], draw: int) -> torch.Tensor:
        tried.append(values["level"])
        return strangers(values, draw)

    made = Objective(walls(BRIGHTER, 7), camera, (LEVEL, IDLE), 1.0)
    made.weigh(None, shrinkage=0.3)
    place = np.array([2.9, 0.0])
    jacobian = made.jacobian(made.slopes(place, np.array([1.0, 1.0])))
    ends = [made.residuals(np.array([end, 0.0])) for end in (1.9, 3.0)]
    assert max(tried) == pytest.approx(0.8)
    assert made.trials == len(tried)
    assert np.allclose(jacobian[:-2, 0], (ends[1] - ends[0])[:-2] / 1.1)


def test_without_the_bent_columns_there_are_fewer_residuals(objective: Objective) -> None:
    place = np.zeros(2)
    assert len(objective.residuals(place)) == len(BENT_NAMES) + 2
    objective.weigh(None, shrinkage=0.3, bent=False)
    assert len(objective.residuals(place)) == len(NAMES) + 2


def test_too_few_strangers_are_refused() -> None:
    real = walls(BRIGHTER, 7)
    with pytest.raises(InputError, match="3 rendered people: give at least 20"):
        Objective(real, lambda values, draw: walls(values, draw, 3), (LEVEL,), 1.0)


def test_too_few_pictures_are_refused() -> None:
    with pytest.raises(InputError, match="19 pictures to fit: give at least 20"):
        Objective(walls(BRIGHTER, 7, 19), strangers, (LEVEL,), 1.0)
