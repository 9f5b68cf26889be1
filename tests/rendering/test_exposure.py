"""The film, as a sample: against Mitsuba's own, and against itself at other scales and passes."""

import numpy as np
import pytest
from fakes.scenes import LIGHTINGS, POSES, Studio
from oracles.heads import stand_in
from scipy.stats import norm

from lrsr.errors import InputError
from lrsr.rendering import exposure
from lrsr.rendering.backend import _start
from lrsr.rendering.exposure import _describe_pinhole, _pass_seed, expose
from lrsr.rendering.geometry import place_camera
from lrsr.rendering.lighting import Lighting

POSE = POSES["left"]


def pictures(renderer: Studio, count: int, samples: int, *, own: bool) -> np.ndarray:
    head = stand_in(0)
    scene = renderer._live.show(head, LIGHTINGS["side"], POSE)
    viewpoint = place_camera(head.pupils, 6.0, offset_mm=POSE.frame_offset_mm())
    integrator = renderer._path()
    if own:
        return np.array(
            [
                expose(scene, integrator, viewpoint, POSE, scale=1, samples=samples, seed=seed)
                for seed in range(count)
            ]
        )
    mi = _start()
    sensor = mi.load_dict(_describe_pinhole(viewpoint, POSE, viewpoint.film_px, samples))
    return np.array(
        [
            np.array(mi.render(scene, sensor=sensor, integrator=integrator, spp=samples, seed=seed))
            for seed in range(1000, 1000 + count)
        ]
    )


def test_every_pixel_agrees_with_mitsubas_splatting_film(renderer: Studio) -> None:
    ours, theirs = (pictures(renderer, 8, 256, own=own) for own in (True, False))
    # Mitsuba's filter is lowered to end at zero (by e^-8); its pixels differ by up to 0.1 %.
    variance = (ours.var(axis=0, ddof=1) + theirs.var(axis=0, ddof=1)) / 8
    tolerance = np.sqrt(variance + (2e-3 * ours.mean(axis=0)) ** 2)
    z = np.abs(ours.mean(axis=0) - theirs.mean(axis=0)) / tolerance
    assert z.max() < 1.5 * norm.isf(0.001 / z.size)  # t with 14 degrees of freedom has longer tails


def test_passes_do_not_change_the_expectation(
    renderer: Studio, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = pictures(renderer, 4, 256, own=True)
    monkeypatch.setattr(exposure, "_MAX_RAYS", 24 * 24 * 70)
    split = pictures(renderer, 4, 256, own=True)
    assert not np.array_equal(whole, split)
    assert split.mean() == pytest.approx(whole.mean(), rel=2e-3)


def test_passes_and_seeds_have_seeds_of_their_own() -> None:
    seeds = [_pass_seed(seed, number) for seed in range(30) for number in range(30)]
    assert len(set(seeds)) == len(seeds)


def test_finer_films_are_aligned(renderer: Studio) -> None:
    cloudy = Lighting("cloudy", (), fill_share=1.0)
    ask = {"pose": "left", "lighting": cloudy, "ipd_px": 6, "samples_per_pixel": 512}
    centroids = []
    for scale in (1, 2, 4):
        image = renderer.render(stand_in(0, grey=0.0), scale=scale, **ask).image
        darkness = (1 - image).sum(0).numpy()
        y, x = np.mgrid[: darkness.shape[0], : darkness.shape[1]]
        centre = np.array([(darkness * axis).sum() for axis in (x, y)]) / darkness.sum()
        centroids.append((centre + 0.5) / scale)
    np.testing.assert_allclose(centroids[1:], centroids[:1] * 2, atol=0.01)


def test_what_the_observer_sees_of_bands_is_the_film_of_three_colours(
    traced: dict[str, np.ndarray],
) -> None:
    observed, plain = traced["observed"], traced["plain"]
    runs = len(plain)
    variance = (observed.var(axis=0, ddof=1) + plain.var(axis=0, ddof=1)) / runs
    # Curves are averaged over bands of 10 nm, which changes colours by 0.1 %.
    tolerance = np.sqrt(variance + (2e-3 * plain.mean(axis=0)) ** 2)
    z = np.abs(observed.mean(axis=0) - plain.mean(axis=0)) / tolerance
    assert z.max() < 1.3 * norm.isf(0.001 / z.size)  # t with 22 degrees of freedom
    assert observed.mean(axis=(0, 2, 3)) == pytest.approx(plain.mean(axis=(0, 2, 3)), rel=2e-3)


def test_bands_of_one_seed_are_the_same_bytes(traced: dict[str, np.ndarray]) -> None:
    assert np.array_equal(*traced["again"])
    assert traced["again"].shape == (2, 35, 16, 16)


def test_a_lens_delivers_the_bands_of_a_pinhole(traced: dict[str, np.ndarray]) -> None:
    lens, pinhole = (traced[name].mean(axis=(1, 2)) for name in ("by_lens", "by_pinhole"))
    assert lens == pytest.approx(pinhole, rel=0.05)  # one wavelength a ray: a band is known to 1 %
    assert lens.mean() == pytest.approx(pinhole.mean(), rel=5e-3)


def test_bands_of_a_variant_of_three_colours_are_refused(renderer: Studio) -> None:
    with pytest.raises(InputError, match=r"bands=35: .* set LRSR_VARIANT=llvm_ad_spectral"):
        renderer.render(stand_in(0), ipd_px=4, samples_per_pixel=16, bands=35)
