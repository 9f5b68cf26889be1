"""Two cameras of a few lines, so that what has to come out is known, and a whole one."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
import torch

from lrsr.calibration import fit as fitting
from lrsr.calibration.fit import Fit, fit_camera
from lrsr.calibration.objective import Objective
from lrsr.calibration.parameters import Parameter
from lrsr.camera.processing import _sharpen, _tone
from lrsr.camera.smoothing import gaussian_blur
from lrsr.errors import InputError

TOY = (
    Parameter("blur_px", 0.7, 0.1, 2.4, 1.0, True, "Gaussian"),
    Parameter("noise", 0.01, 0.0005, 0.1, 1.0, True, "after the blur"),
    Parameter("sharpen_amount", 0.5, 0.0, 5.0, 1.0, False, "after the noise"),
    Parameter("contrast", 1.0, 0.4, 2.5, 0.2, True, "at the end"),
    Parameter("weather", 2.0, 0.1, 9.0, 0.5, False, "has no effect"),
)
HIDDEN = {"blur_px": 1.1, "noise": 0.02, "sharpen_amount": 1.0, "contrast": 0.8, "weather": 5.0}


def people(seed: int, count: int = 30) -> torch.Tensor:
    """Patches of random tones with sharp edges: nobody twice."""
    generator = torch.Generator().manual_seed(seed)
    tones = 0.25 + 0.5 * torch.rand(count, 3, 6, 6, generator=generator)
    return torch.nn.functional.interpolate(tones, size=(32, 32), mode="nearest")


def shoot(scene: torch.Tensor, values: Mapping[str, float], seed: int) -> torch.Tensor:
    """Blur, add noise, sharpen, bend; one seed for all."""
    blurred = gaussian_blur(scene, values["blur_px"])
    noise = torch.randn(scene.shape, generator=torch.Generator().manual_seed(seed))
    sharp = _sharpen(blurred + values["noise"] * noise, 1.0, values["sharpen_amount"])
    return _tone(sharp, values["contrast"]).clamp(0, 1).mul(255).round() / 255


@pytest.fixture
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    """Stop after the first settling: where it leads does not matter here."""
    monkeypatch.setattr(fitting, "_SETTLINGS", (1,))


@pytest.fixture(scope="module")
def fit() -> Fit:
    strangers = people(2, 50)
    real = shoot(people(1, 40), HIDDEN, seed=1008)
    return fit_camera(
        real, lambda values, draw: shoot(strangers, values, seed=9 + draw), parameters=TOY, rounds=5
    )


@pytest.mark.parametrize(
    ("name", "tolerance"),
    [("blur_px", 0.1), ("noise", 0.1), ("sharpen_amount", 0.35), ("contrast", 0.1)],
)
def test_hidden_parameters_are_recovered_from_other_people(
    fit: Fit, name: str, tolerance: float
) -> None:
    assert fit.plain[name] == pytest.approx(HIDDEN[name], rel=tolerance)


@pytest.mark.parametrize("name", ["blur_px", "noise", "contrast"])
def test_what_the_pictures_show_is_known(fit: Fit, name: str) -> None:
    found = fit.values[name]
    assert found.known
    assert abs(found.value - HIDDEN[name]) < 4 * found.error


def test_what_has_no_effect_stays_at_the_guess_and_is_said_to_be_unknown(fit: Fit) -> None:
    weather = fit.values["weather"]
    assert weather.value == pytest.approx(2.0, abs=1e-3)
    assert weather.error == pytest.approx(0.5, rel=1e-3)  # the guess's own doubt
    assert not weather.known


def test_intervals_hold_the_value_and_a_factor_is_as_far_both_ways(fit: Fit) -> None:
    noise, sharpening = fit.values["noise"], fit.values["sharpen_amount"]
    assert noise.high / noise.value == pytest.approx(noise.value / noise.low)
    assert sharpening.high - sharpening.value == pytest.approx(1.96 * sharpening.error)
    assert noise.low < HIDDEN["noise"] < noise.high


def test_a_product_has_the_error_of_the_sum_of_logarithms(fit: Fit) -> None:
    noise, contrast = fit.values["noise"], fit.values["contrast"]
    both = fit.product("noise", "contrast")
    i, j = (list(fit.values).index(name) for name in ("noise", "contrast"))
    together = 2 * 1.0 * 0.2 * fit.covariance[i, j]  # of doubts 1 and 0.2
    apart = (noise.error / noise.value) ** 2 + (contrast.error / contrast.value) ** 2
    assert both.value == pytest.approx(noise.value * contrast.value)
    assert (both.error / both.value) ** 2 == pytest.approx(apart + together)
    assert fit.product("noise").error == pytest.approx(noise.error)


def test_the_statistics_agree_afterwards(fit: Fit) -> None:
    assert fit.misfit_before > 10 * fit.misfit_after
    assert fit.misfit_after < 2
    away = (fit.after - fit.measured) / fit.spread
    assert abs(away).max() < 4


@pytest.mark.usefixtures("short")
def test_the_same_question_has_the_same_answer() -> None:
    real, strangers = shoot(people(1, 20), HIDDEN, 8), people(2, 20)

    def camera(values: Mapping[str, float], draw: int) -> torch.Tensor:
        return shoot(strangers, {**HIDDEN, **values}, 9 + draw)

    answers = [fit_camera(real, camera, parameters=TOY[:2], rounds=1) for _ in range(2)]
    assert answers[0].plain == answers[1].plain


@pytest.mark.usefixtures("short")
def test_a_value_never_leaves_its_range() -> None:
    tight = (replace(TOY[0], low=0.5, high=0.9), *TOY[1:])
    real, strangers = shoot(people(1, 20), HIDDEN, 8), people(2, 20)
    tried: list[float] = []

    def camera(values: Mapping[str, float], draw: int) -> torch.Tensor:
        tried.append(values["blur_px"])
        return shoot(strangers, values, 9 + draw)

    found = fit_camera(real, camera, parameters=tight, rounds=3)
    assert 0.5 <= min(tried) <= max(tried) <= 0.9
    assert found.trials == len(tried)


@pytest.mark.parametrize("sign", [1, -1], ids=["good slopes", "misleading ones"])
def test_steps_are_taken_downhill_and_never_uphill(sign: int) -> None:
    strangers = people(2, 40)
    real = shoot(people(1, 40), HIDDEN, seed=1008)
    objective = Objective(real, lambda values, draw: shoot(strangers, values, 9 + draw), TOY, 0.75)
    start = np.array([parameter.coordinate(HIDDEN[parameter.name]) for parameter in TOY])
    start[1] += 0.5  # the noise by a factor of 1.6 too strong
    objective.weigh(start, shrinkage=0.3)
    first, second = objective.slopes(start, np.full(len(TOY), 0.3))
    place = fitting._settled(objective, start, (sign * first, sign * second))
    if sign < 0:
        assert np.array_equal(place, start)
    else:
        # Its standard error is about 0.1.
        assert place[1] - start[1] == pytest.approx(-0.5, abs=0.2)


def test_the_number_of_trials_is_about_what_was_expected(fit: Fit) -> None:
    expected = fitting.expected_trials(len(TOY), rounds=5)
    assert 0.5 * expected < fit.trials < 1.2 * expected


def test_too_few_pictures_are_refused() -> None:
    with pytest.raises(InputError, match="19 pictures to fit: give at least 20"):
        fit_camera(people(1, 19), lambda *_: people(2))


def test_too_few_strangers_are_refused() -> None:
    with pytest.raises(InputError, match="5 rendered people: give at least 20"):
        fit_camera(people(1), lambda *_: people(2, 5))


def test_no_round_at_all_is_refused() -> None:
    with pytest.raises(InputError, match="rounds=0"):
        fit_camera(people(1), lambda *_: people(2), rounds=0)
