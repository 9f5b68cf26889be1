"""Translucent skin: energy, invariance, brute force, bytes, kernels and variants."""

import logging
from dataclasses import replace

import numpy as np
import pytest
from fakes.scenes import LIGHTINGS, POSES, SKINS, Studio
from oracles.half_space import diffuse_albedo
from oracles.heads import dots, stand_in
from oracles.translucent import mean_of_ball

from lrsr.images import linear_to_srgb
from lrsr.rendering import live_scene
from lrsr.rendering.painted_skin import Sampling

SKIN1 = (0.74 / 0.772, 0.88 / 1.05, 1.01 / 1.49)


@pytest.fixture(scope="module")
def translucent(renderer: Studio) -> Studio:
    """Return one renderer of translucent skin; the fixture it asks for has chosen the variant."""
    return Studio("subsurface")


def test_a_white_furnace_stays_white(renderer: Studio) -> None:
    """Nothing is absorbed at an albedo of 1, however light splits between surface and inside."""
    mean, error = mean_of_ball(1.0, samples=512)
    np.testing.assert_allclose(mean, 1.0, atol=0.002)
    assert error.max() < 0.001


@pytest.fixture(scope="module")
def usual(renderer: Studio) -> tuple[np.ndarray, np.ndarray]:
    """A ball so large that where the profile is cut does not matter."""
    return mean_of_ball((0.6, 0.3, 0.1), radius_mm=3000.0)


@pytest.mark.parametrize(
    "other",
    [
        {"sampling": Sampling(normal_share=0.6)},
        {"sampling": Sampling(least_lobe_share=0.35)},
        {"skin": replace(SKINS["subsurface"], reach_mm=6.0)},
        {"skin": replace(SKINS["subsurface"], reach_mm=20.0)},
    ],
    ids=["axis weights", "lobe probability", "short probes", "long probes"],
)
def test_no_choice_of_sampling_moves_the_mean(
    usual: tuple[np.ndarray, np.ndarray], other: dict
) -> None:
    mean, error = usual
    changed, other_error = mean_of_ball((0.6, 0.3, 0.1), radius_mm=3000.0, **other)
    bound = 4.5 * np.hypot(error, other_error) + 2e-4
    assert (np.abs(changed - mean) < bound).all()


BRUTE_FORCE = {100.0: (0.4508, 0.2362, 0.1480), 20.0: (0.5015, 0.2500, 0.1527)}
"""Mean radiance of the disc of a ball of that radius, mm, with skin1 inside, in white light:
:func:`oracles.translucent.brute_force`, one grey medium per channel, 256 samples, 12 runs; standard
errors of 0.0005 and less."""


@pytest.mark.parametrize("radius_mm", BRUTE_FORCE)
def test_a_sphere_is_as_bright_as_brute_force_says(renderer: Studio, radius_mm: float) -> None:
    smooth = 1 - 0.0768  # what of diffuse light enters
    albedo = [smooth * diffuse_albedo(scattering) for scattering in SKIN1]
    mean, _ = mean_of_ball(albedo, radius_mm=radius_mm, roughness=0.04)
    np.testing.assert_allclose(mean, BRUTE_FORCE[radius_mm], rtol=0.02)


def test_the_same_request_is_the_same_bytes_whoever_came_before(translucent: Studio) -> None:
    ask = {"pose": "down", "lighting": "side", "ipd_px": 4, "samples_per_pixel": 64}
    first = translucent.render(stand_in(1), **ask)
    translucent.render(stand_in(2), pose="left", ipd_px=4, samples_per_pixel=16)
    assert translucent.render(stand_in(1), **ask).image.equal(first.image)


def test_skin_is_as_bright_as_reflective_skin(renderer: Studio, translucent: Studio) -> None:
    """The albedo texture means the same in both: within 4 %, curvature and index included."""
    ask = {"lighting": "side", "ipd_px": 6, "samples_per_pixel": 512}
    one = renderer.render(stand_in(1, grey=0.4), **ask).image.mean(dim=(1, 2))
    other = translucent.render(stand_in(1, grey=0.4), **ask).image.mean(dim=(1, 2))
    np.testing.assert_allclose(other.numpy(), one.numpy(), rtol=0.04)


def test_what_spreads_farther_reaches_deeper_into_the_shadow() -> None:
    """Grey skin whose red light goes far and whose blue light stays: red past the terminator."""
    coefficients = {"absorption_per_mm": (0, 0, 0), "scattering_per_mm": (0.2, 1, 5)}
    translucent = Studio(replace(SKINS["subsurface"], reach_mm=40, **coefficients))
    image = translucent.render(
        stand_in(1, ipd_mm=63, grey=0.5), lighting="side", ipd_px=8, samples_per_pixel=512
    ).image.numpy()
    redness = (image[0] / image[2])[14:20].mean(axis=0)
    assert redness[13:15].mean() > 1.1 * redness[18:23].mean()


@pytest.mark.parametrize("lighting", ["frontal", "side"])
def test_2048_samples_leave_no_fireflies(translucent: Studio, lighting: str) -> None:
    a, b = (translucent.render(stand_in(1), lighting=lighting, ipd_px=6, seed=s) for s in (0, 1))
    shown = [255 * linear_to_srgb(picture.image / picture.metered) for picture in (a, b)]
    difference = (shown[0] - shown[1]).abs() / 2**0.5
    assert float(difference.median()) < 0.5
    assert float(difference.max()) < 4


def test_heads_poses_lights_and_seeds_compile_nothing_new(translucent: Studio) -> None:
    import drjit as dr

    ask = {"ipd_px": 4, "samples_per_pixel": 64}
    for scale in (1, 2):
        translucent.render(stand_in(0), scale=scale, **ask)
        translucent.render(stand_in(1), scale=scale, pose="up", lighting="below", **ask)
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory):
        dr.kernel_history_clear()
        for number, (pose, lighting) in enumerate(zip(POSES, LIGHTINGS, strict=False)):
            for scale in (1, 2):
                settings = {"pose": pose, "lighting": lighting, "seed": 7 + number}
                translucent.render(stand_in(2 + number), scale=scale, **settings, **ask)
        history = dr.kernel_history([dr.KernelType.JIT])
    assert len(history) > 8
    assert [entry["hash"] for entry in history if not entry["cache_hit"]] == []


def test_a_head_without_skin_is_traced_as_ever(translucent: Studio) -> None:
    image = (
        Studio("subsurface")
        .render(dots(stand_in(0).landmarks), ipd_px=4, samples_per_pixel=16)
        .image
    )
    assert 0 < float(image.min()) < float(image.max())


def test_without_a_compiler_skin_is_reflective_and_that_is_said_once(
    renderer: Studio, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    class Scalar:
        @staticmethod
        def variant() -> str:
            return "scalar_rgb"

    live_scene._warn_of_scalar.cache_clear()
    monkeypatch.setattr(live_scene, "mi", Scalar)
    with caplog.at_level(logging.WARNING, logger=live_scene.__name__):
        assert [live_scene.LiveScene(SKINS["subsurface"])._model() for _ in range(3)] == [
            "reflective"
        ] * 3
    assert len(caplog.messages) == 1
    assert "reflective instead" in caplog.text


def test_a_spectral_variant_sees_the_same_grey(
    renderer: Studio, traced: dict[str, np.ndarray]
) -> None:
    mean, _ = mean_of_ball(0.4, samples=128, runs=2)
    np.testing.assert_allclose(traced["translucent"], mean, rtol=0.02)
