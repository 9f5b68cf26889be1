"""The sampler: Mitsuba's own numbers, each at the ray that starts where it should."""

import math

import numpy as np
import pytest
from fakes.scenes import LIGHTINGS, Studio
from oracles.heads import stand_in

from lrsr.rendering import exposure
from lrsr.rendering.backend import _start
from lrsr.rendering.strata import _STRIP, grid, order_rays, stratified

SEED, PIXELS = 12345, 5


@pytest.fixture(autouse=True)
def _started(renderer: Studio) -> None:
    """Have Mitsuba loaded."""


def given(samples: int) -> np.ndarray:
    import drjit as dr

    return np.array(dr.arange(_start().UInt32, samples * PIXELS))


def mitsubas(samples: int) -> object:
    sampler = _start().load_dict({"type": "multijitter", "sample_count": samples})
    sampler.set_samples_per_wavefront(samples)
    sampler.seed(SEED, samples * PIXELS)
    return sampler


@pytest.mark.parametrize("samples", [1, 16, 17, 100, 128, 512, 2048])
def test_a_grid_has_at_least_the_samples_and_few_more(samples: int) -> None:
    filled = math.prod(grid(samples))
    assert samples <= filled <= samples + np.sqrt(samples) + 1
    assert math.prod(grid(filled)) == filled


@pytest.mark.parametrize("samples", [1, 2, 16, 20, 132, 2070])
def test_every_lane_gets_the_numbers_that_mitsuba_gives_it(samples: int) -> None:
    lanes = order_rays(samples, PIXELS, SEED)
    theirs, ours, order = mitsubas(samples), stratified(samples, SEED, lanes), np.array(lanes)
    for dimensions in (2, 1, 1, 2, 2, 1):
        wanted = np.array(getattr(theirs, f"next_{dimensions}d")())
        np.testing.assert_array_equal(
            np.array(getattr(ours, f"next_{dimensions}d")()), wanted[..., order]
        )


@pytest.mark.parametrize("samples", [1, 16, 20, 132])
def test_every_ray_of_every_pixel_is_traced_once(samples: int) -> None:
    order = np.array(order_rays(samples, PIXELS, SEED)).reshape(PIXELS, samples)
    np.testing.assert_array_equal(np.sort(order, axis=1).ravel(), given(samples))


def test_neighbours_start_near_each_other() -> None:
    samples = 2070
    start_at = np.array(stratified(samples, SEED, order_rays(samples, 1, SEED)).next_2d())
    packets = start_at[:, : samples // 8 * 8].reshape(2, -1, 8)
    widths = np.ptp(packets, axis=2)
    assert np.median(widths[0]) < 4 / 45
    assert np.median(widths[1]) <= _STRIP / 45


def test_an_active_lane_does_not_care_for_the_others(renderer: Studio) -> None:
    mi = _start()
    lanes = order_rays(16, 2, SEED)
    whole, half = stratified(16, SEED, lanes), stratified(16, SEED, lanes)
    some = mi.Bool([number % 2 == 0 for number in range(32)])
    wanted = [np.array(whole.next_2d()), np.array(whole.next_1d())]
    seen = [np.array(half.next_2d(some)), np.array(half.next_1d(some))]
    for a, b in zip(wanted, seen, strict=True):
        np.testing.assert_array_equal(a[..., ::2], b[..., ::2])


@pytest.mark.parametrize("lens", ["pinhole", "double_gauss"])
def test_the_order_changes_next_to_no_ray(
    renderer: Studio, monkeypatch: pytest.MonkeyPatch, lens: str
) -> None:
    """Embree meets a grazed edge or not as the packet goes: a few rays in a million."""
    import drjit as dr

    ask = {"lens": lens, "lighting": LIGHTINGS["side"], "samples_per_pixel": 64, "ipd_px": 6.0}
    ordered = renderer.render(stand_in(1), **ask).image
    as_given = lambda samples, pixels, _: dr.arange(_start().UInt32, samples * pixels)  # noqa: E731
    monkeypatch.setattr(exposure, "order_rays", as_given)
    usual = renderer.render(stand_in(1), **ask).image
    assert (ordered != usual).float().mean() < 2e-3
    assert ordered.mean() == pytest.approx(float(usual.mean()), rel=1e-5)
