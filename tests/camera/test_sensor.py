"""Electrons, their noise and the numbers they become."""

from collections.abc import Callable

import numpy as np
import pytest
import torch

from lrsr.camera.sensor import _PATTERN_PX, Sensor, _noise_generator
from lrsr.errors import ImageContractError, InputError


def flat(value: float, batch: int = 1, side: int = 128) -> torch.Tensor:
    return torch.full((batch, 1, side, side), value)


def random_light(batch: int = 2) -> torch.Tensor:
    return torch.rand(batch, 3, 9, 7, generator=torch.Generator().manual_seed(0))


@pytest.mark.parametrize("differentiable", [False, True], ids=["poisson", "reparametrised"])
def test_variance_against_mean_is_the_photon_transfer_line(differentiable: bool) -> None:
    # EMVA 1288: var = K (mean - black) + (K read)^2 + 1/12. 12 e- of read noise, as a bad
    # camera has, make the intercept measurable. 8 levels of 262144 photosites: slope +- 0.2 %,
    # intercept +- 0.3 %.
    sensor = Sensor(4000.0, read_noise_e=12.0, prnu=0.0, bits=14, black_level_dn=1000)
    levels = torch.arange(8) / 16
    raw = torch.cat([flat(float(level), 16) for level in levels])
    raw = sensor(raw, range(len(raw)), differentiable=differentiable).reshape(8, -1).double()
    mean, variance = raw.mean(1) - 1000, raw.var(1)
    weights = 1 / variance  # the scatter of a variance grows with it
    lines = torch.stack([mean, torch.ones(8)], 1).double()
    fit = torch.linalg.lstsq(lines * weights[:, None], (variance * weights)[:, None]).solution
    gain, intercept = fit.flatten().tolist()
    assert gain == pytest.approx((2**14 - 1 - 1000) / 4000, rel=0.02)
    assert intercept == pytest.approx((gain * 12.0) ** 2 + 1 / 12, rel=0.02)


def test_the_mean_light_is_kept() -> None:
    sensor = Sensor(2000.0, read_noise_e=5.0, dark_current_e_per_s=1000, prnu=0.0, gain=4.0)
    light = sensor.light(sensor(flat(0.3, 4), range(4)))
    error_of_mean = float(light.std()) / light.numel() ** 0.5
    assert float(light.mean()) == pytest.approx(0.3, abs=4 * error_of_mean)


def test_dark_current_grows_with_the_exposure_and_brings_its_own_shot_noise() -> None:
    dark = {"dark_current_e_per_s": 400.0, "read_noise_e": 0.0, "prnu": 0.0, "bits": 16}
    raw = Sensor(1000.0, exposure_s=0.5, black_level_dn=0, **dark)(flat(0.0, 4), range(4))
    electrons = raw / ((2**16 - 1) / 1000)
    assert float(electrons.mean()) == pytest.approx(200, rel=0.005)
    assert float(electrons.var()) == pytest.approx(200, rel=0.03)


def test_pictures_of_one_sensor_share_its_pattern_and_pictures_of_another_do_not() -> None:
    def pattern(sensor: Sensor, seed: int) -> torch.Tensor:
        return sensor.light(sensor(flat(0.5), [seed])).flatten() / 0.5 - 1

    ours, theirs = Sensor(1e6, prnu=0.02), Sensor(1e6, prnu=0.02, pattern_seed=1)
    first, second, other = pattern(ours, 1), pattern(ours, 2), pattern(theirs, 1)
    assert float(first.std()) == pytest.approx(0.02, rel=0.05)
    assert float(torch.corrcoef(torch.stack([first, second]))[0, 1]) > 0.9
    assert abs(float(torch.corrcoef(torch.stack([first, other]))[0, 1])) < 4 / 128


def test_a_crop_has_the_photosites_of_its_place() -> None:
    sensor = Sensor(noise=False, prnu=0.1)
    whole = sensor(flat(0.5, side=40))
    crop = sensor(flat(0.5, side=8), origin_px=(5, 12))
    assert torch.equal(crop, whole[..., 12:20, 5:13])
    assert torch.equal(crop, sensor(flat(0.5, side=8), origin_px=(5 + _PATTERN_PX, 12)))


def test_noise_depends_on_the_seed_and_not_on_the_batch() -> None:
    sensor, light = Sensor(), random_light(3)
    together = sensor(light, [4, 5, 6])
    for i in range(3):
        assert torch.equal(together[i : i + 1], sensor(light[i : i + 1], [4 + i]))
    assert not torch.equal(sensor(light[:1], [4]), sensor(light[:1], [5]))


def test_each_frame_has_noise_of_its_own() -> None:
    sensor = Sensor(prnu=0.0)
    first, second = (sensor(flat(0.5), [3], frame=frame) for frame in (0, 1))
    frames = torch.stack([first.flatten(), second.flatten()])
    assert abs(float(torch.corrcoef(frames)[0, 1])) < 4 / 128


def test_seeds_that_share_their_low_bits_differ() -> None:
    drawn = [torch.rand(1, generator=_noise_generator(seed)) for seed in (1, 1 + 2**32)]
    assert not torch.equal(*drawn)


def test_a_full_well_and_the_converter_both_saturate() -> None:
    sensor = Sensor(1000.0, bits=10, black_level_dn=0, noise=False, prnu=0.0)
    assert sensor(flat(50.0)).unique().tolist() == [1023.0]
    noisy = Sensor(1000.0, bits=10, black_level_dn=0, read_noise_e=0.0, prnu=0.0)
    assert noisy(flat(50.0), [0]).unique().tolist() == [1023.0]


def test_numbers_are_whole_and_within_the_converter() -> None:
    raw = Sensor(500.0, read_noise_e=50.0, bits=8, black_level_dn=3)(random_light(), [0, 1])
    assert torch.equal(raw, raw.round())
    assert (float(raw.min()), float(raw.max())) == (0.0, 255.0)


def test_no_light_has_a_finite_gradient() -> None:
    light = torch.zeros(1, 1, 4, 4, requires_grad=True)
    Sensor(black_level_dn=256)(light, [0], differentiable=True).sum().backward()
    assert light.grad is not None
    assert bool(torch.isfinite(light.grad).all())


@pytest.mark.parametrize("seeds", [None, [1], [1, 2, 3]], ids=["none", "too few", "too many"])
def test_noise_without_a_seed_for_each_image_is_refused(seeds: list[int] | None) -> None:
    with pytest.raises(InputError, match="for 2 noisy images, wanted one for each"):
        Sensor()(random_light(2), seeds)


@pytest.mark.parametrize("seeds", [7, torch.tensor(7), "78", [1.0, 2.0], [True, False], ["1", "2"]])
def test_seeds_are_whole_numbers_one_for_each_image(seeds: list[int]) -> None:
    with pytest.raises(InputError, match="seeds"):
        Sensor()(random_light(2), seeds)


@pytest.mark.parametrize("kind", [np.array, torch.tensor, lambda seeds: list(map(np.uint8, seeds))])
def test_seeds_may_be_of_any_width(kind: Callable[[list[int]], list[int]]) -> None:
    light = random_light(2)
    assert torch.equal(Sensor()(light, kind([1, 2])), Sensor()(light, [1, 2]))


def test_broken_light_is_refused() -> None:
    with pytest.raises(ImageContractError, match=r"light: got shape \(2, 2, 4, 4\)"):
        Sensor(noise=False)(torch.zeros(2, 2, 4, 4))
    with pytest.raises(ImageContractError, match=r"light: got torch.int64"):
        Sensor(noise=False)(torch.zeros(1, 1, 4, 4, dtype=torch.int64))
    with pytest.raises(InputError, match="origin_px"):
        Sensor(noise=False)(flat(0.0, side=4), origin_px=(-1, 0))


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("full_well_e", 0.0),
        ("gain", 0.5),
        ("read_noise_e", -1.0),
        ("dark_current_e_per_s", -1.0),
        ("exposure_s", -1.0),
        ("prnu", 0.6),
        ("bits", 7),
        ("black_level_dn", 4095),
    ],
)
def test_a_setting_out_of_range_is_refused(name: str, value: float) -> None:
    with pytest.raises(InputError, match=f"{name}={value}: wanted"):
        Sensor(**{name: value})
