"""Statistics of noise whose strength and mean are known, and slopes that are known from them."""

from collections.abc import Mapping

import numpy as np
import pytest
import torch

from lrsr.camera.moments import Moments
from lrsr.camera.parameters import Parameter
from lrsr.camera.statistics import BENT_NAMES, NAMES
from lrsr.errors import InputError

LEVEL = Parameter("level", 0.5, 0.2, 0.8, 0.1, False, "of a grey wall")
IDLE = Parameter("idle", 1.0, 0.1, 9.0, 1.0, True, "no effect")
BRIGHTNESS = NAMES.index("luminance_50")


def walls(values: Mapping[str, float], draw: int, count: int = 24) -> torch.Tensor:
    """Grey walls, some lighter than others, with a little noise."""
    generator = torch.Generator().manual_seed(100 + draw)
    noise = 0.02 * torch.randn(count, 3, 16, 16, generator=generator)
    paint = 0.02 * torch.arange(count)[:, None, None, None] / count
    return (values["level"] + paint + noise).clamp(0, 1)


@pytest.fixture
def moments() -> Moments:
    made = Moments(walls({"level": 0.6}, 7, 30), walls, (LEVEL, IDLE), 1.0)
    made.weigh(np.zeros(2), shrinkage=0.3)
    return made


def test_the_means_are_those_of_the_pictures(moments: Moments) -> None:
    assert moments.measured.shape == (len(BENT_NAMES),)
    assert moments.measured[BRIGHTNESS] == pytest.approx(255 * 0.61, abs=1)
    assert moments.simulated(np.array([1.0, 0.0]))[BRIGHTNESS] == pytest.approx(255 * 0.61, abs=1)
    assert moments.simulated(np.zeros(2))[BRIGHTNESS] == pytest.approx(255 * 0.51, abs=1)


def test_chance_falls_with_the_number_of_people(moments: Moments) -> None:
    paint = 255 * 0.02 * np.arange(24).std(ddof=1) / 24  # dominates the noise of a median
    expected = paint * np.sqrt(1 / 30 + 1 / 24)
    assert moments.spread[BRIGHTNESS] == pytest.approx(expected, rel=0.1)


def test_at_the_answer_only_chance_is_left(moments: Moments) -> None:
    assert moments.misfit(moments.simulated(np.array([1.0, 0.0]))) < 2
    assert moments.misfit(moments.simulated(np.zeros(2))) > 100


def test_slopes_are_those_of_long_differences(moments: Moments) -> None:
    place, step = np.array([1.0, 0.0]), np.array([0.5, 0.5])
    jacobian = moments.jacobian(moments.slopes(place, step))
    by_hand = moments.residuals(np.array([1.5, 0.0])) - moments.residuals(np.array([0.5, 0.0]))
    assert np.allclose(jacobian[:, 0], by_hand)
    assert np.allclose(jacobian[:-2, 1], 0)
    assert np.array_equal(jacobian[-2:], np.eye(2))


def test_what_has_no_effect_keeps_the_guess_s_doubt(moments: Moments) -> None:
    slopes = moments.slopes(np.array([1.0, 0.0]), np.array([0.3, 0.3]), draws=2)
    covariance = moments.covariance(slopes)
    assert covariance[1, 1] == pytest.approx(1)
    assert covariance[0, 1] == pytest.approx(0, abs=1e-9)


def test_the_level_is_as_uncertain_as_the_paint_allows(moments: Moments) -> None:
    slopes = moments.slopes(np.array([1.0, 0.0]), np.array([0.3, 0.3]))
    paint = 0.02 * np.arange(24).std(ddof=1) / 24 * np.sqrt(1 / 30 + 1 / 24)
    error = 0.1 * np.sqrt(moments.covariance(slopes)[0, 0])
    assert 0.3 * paint < error < 1.5 * paint  # the colours help a little


def test_no_trial_leaves_the_range() -> None:
    tried: list[float] = []

    def camera(values: Mapping[str, float], draw: int) -> torch.Tensor:
        tried.append(values["level"])
        return walls(values, draw)

    made = Moments(walls({"level": 0.6}, 7), camera, (LEVEL, IDLE), 1.0)
    made.weigh(None, shrinkage=0.3)
    made.slopes(np.array([2.9, 0.0]), np.array([1.0, 1.0]))
    assert max(tried) == pytest.approx(0.8)
    assert made.trials == len(tried)


def test_without_the_bent_columns_there_are_fewer_residuals(moments: Moments) -> None:
    place = np.zeros(2)
    assert len(moments.residuals(place)) == len(BENT_NAMES) + 2
    moments.weigh(None, shrinkage=0.3, bent=False)
    assert len(moments.residuals(place)) == len(NAMES) + 2


def test_too_few_strangers_are_refused() -> None:
    real = walls({"level": 0.6}, 7)
    with pytest.raises(InputError, match="3 rendered people: give at least 20"):
        Moments(real, lambda values, draw: walls(values, draw, 3), (LEVEL,), 1.0)


def test_too_few_pictures_are_refused() -> None:
    with pytest.raises(InputError, match="19 pictures to fit: give at least 20"):
        Moments(walls({"level": 0.6}, 7, 19), walls, (LEVEL,), 1.0)
