"""What the rough surface reflects: against its limits, against sampling, and energy."""

import numpy as np
import pytest
from fakes.scenes import Studio

from lrsr.rendering.backend import _start
from lrsr.rendering.reflection import (
    RoughReflection,
    _albedo_table,
    _directional_albedo,
    _fresnel,
)

COUNT = 1 << 18


@pytest.fixture(scope="module")
def reflection(renderer: Studio) -> RoughReflection:
    return RoughReflection(1.4)


def test_fresnel_at_normal_incidence_brewsters_angle_and_beyond_the_critical_one() -> None:
    assert _fresnel(1.0, 1.5) == pytest.approx(0.04)
    brewster = np.cos(np.arctan(1.5))
    assert _fresnel(brewster, 1.5) == pytest.approx(((1.5**2 - 1) / (1.5**2 + 1)) ** 2 / 2)
    assert _fresnel(0.1, 1 / 1.5) == 1.0


def test_a_nearly_smooth_surface_reflects_as_fresnel_says() -> None:
    cosines = np.array([0.2, 0.5, 1.0])
    np.testing.assert_allclose(
        _directional_albedo(cosines, 1e-3, 1.4), _fresnel(cosines, 1.4), rtol=2e-3
    )


def test_the_mean_of_a_smooth_surface_is_7_68_percent() -> None:
    """Diffuse Fresnel reflectance of n = 1.4 from outside: 0.0768 (quadrature)."""
    _, mean = _albedo_table(1.4)
    assert mean[0] == pytest.approx(0.0768, abs=3e-4)
    assert (np.diff(mean) <= 1e-5).all()


@pytest.mark.parametrize("cosine", [0.15, 0.6, 0.95])
@pytest.mark.parametrize("roughness", [0.3, 0.5, 0.75])
def test_table_quadrature_and_samples_agree(
    reflection: RoughReflection, cosine: float, roughness: float
) -> None:
    import drjit as dr

    mi = _start()
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(1, COUNT)
    view = mi.Vector3f(float(np.sqrt(1 - cosine**2)), 0, cosine)
    _, _, weight = reflection.sample(view, mi.Float(roughness), sampler.next_2d())
    exact = _directional_albedo(np.array([cosine]), roughness**2, 1.4)[0]
    table = reflection.directional(mi.Float(cosine), mi.Float(roughness)).numpy()[0]
    noise = float(np.std(weight.numpy())) / COUNT**0.5
    assert float(dr.mean(weight).numpy()[0]) == pytest.approx(exact, abs=3e-4 + 4 * noise)
    assert table == pytest.approx(exact, abs=1e-3)


def test_the_density_integrates_to_the_samples_above_the_surface(
    reflection: RoughReflection,
) -> None:
    mi = _start()
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(2, COUNT)
    view = mi.Vector3f(0.6, 0, 0.8)
    light = mi.warp.square_to_uniform_hemisphere(sampler.next_2d())
    _, density = reflection.eval_pdf(view, light, mi.Float(0.5))
    total = 2 * np.pi * float(density.numpy().mean())
    drawn, _, _ = reflection.sample(view, mi.Float(0.5), sampler.next_2d())
    assert total == pytest.approx(float((drawn.z.numpy() > 0).mean()), abs=0.01)


def test_nothing_is_reflected_below_the_surface(reflection: RoughReflection) -> None:
    mi = _start()
    value, density = reflection.eval_pdf(
        mi.Vector3f(0, 0, 1), mi.Vector3f(0.6, 0, -0.8), mi.Float(0.5)
    )
    assert (value.numpy()[0], density.numpy()[0]) == (0, 0)


def test_the_mean_is_that_of_the_directions(reflection: RoughReflection) -> None:
    mi = _start()
    cosines = (np.arange(200) + 0.5) / 200
    wanted = 2 * (_directional_albedo(cosines, 0.25, 1.4) * cosines).mean()
    assert reflection.mean(mi.Float(0.5)).numpy()[0] == pytest.approx(wanted, abs=3e-4)
