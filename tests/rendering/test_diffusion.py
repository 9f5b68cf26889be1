"""The fits, against photons that are followed one by one."""

import numpy as np
import pytest
from oracles.half_space import diffuse_albedo, pencil_beam

from lrsr.rendering.diffusion import (
    _FIT_RANGE,
    NEAR,
    far_width,
    near_weight,
    scattering_albedo,
)

SKIN1 = {"red": 0.74 / 0.772, "green": 0.88 / 1.05, "blue": 1.01 / 1.49}


def cumulated(distance: np.ndarray, albedo: float) -> np.ndarray:
    """Share of the profile within a distance, mean free paths."""
    weight, far = near_weight(albedo), far_width(albedo)
    return 1 - weight * np.exp(-distance / NEAR) - (1 - weight) * np.exp(-distance / far)


@pytest.mark.parametrize("channel", SKIN1)
@pytest.mark.parametrize("diffuse", [False, True], ids=["perpendicular", "diffuse"])
def test_a_pencil_beam_comes_out_where_photons_do(channel: str, diffuse: bool) -> None:
    """Ten rings that carry 95 % of the light, each within 10 %."""
    scattering = SKIN1[channel]
    distances, shares = pencil_beam(scattering, 240_000, seed=3, diffuse=diffuse)
    order = np.argsort(distances)
    inside = np.cumsum(shares[order]) / shares.sum()
    edges = np.interp(np.linspace(0, 0.95, 11), inside, distances[order])
    edges[0] = 0
    rings = np.diff(cumulated(edges, diffuse_albedo(scattering)))
    np.testing.assert_allclose(rings, 0.095, rtol=0.10)


@pytest.mark.parametrize("channel", SKIN1)
def test_as_much_diffuse_light_comes_back_as_photons_bring(channel: str) -> None:
    _, shares = pencil_beam(SKIN1[channel], 60_000, seed=4, diffuse=True)
    assert diffuse_albedo(SKIN1[channel]) == pytest.approx(shares.sum(), rel=0.015)


def test_burleys_own_width_would_be_too_small() -> None:
    """The mean distance of skin1's red light, against l / s(A) of Christensen and Burley 2015."""
    distances, shares = pencil_beam(SKIN1["red"], 30_000, seed=5)
    seen = (distances * shares).sum() / shares.sum()
    albedo = diffuse_albedo(SKIN1["red"])
    burley = 2.5 / (1.9 - albedo + 3.5 * (albedo - 0.8) ** 2)  # the mean of its profile is 2.5 d
    ours = near_weight(albedo) * NEAR + (1 - near_weight(albedo)) * far_width(albedo)
    assert ours == pytest.approx(seen, rel=0.05)
    assert burley < 0.65 * seen


def test_albedo_and_its_inverse_agree() -> None:
    for albedo in (0.02, 0.2, 0.6, 0.8):
        assert diffuse_albedo(scattering_albedo(albedo)) == pytest.approx(albedo, abs=1e-6)


def test_lighter_skin_spreads_light_farther() -> None:
    widths = [far_width(albedo) for albedo in np.linspace(*_FIT_RANGE, 40).tolist()]
    assert (np.diff(widths) > 0).all()


def test_beyond_the_fit_the_nearest_width_serves() -> None:
    assert far_width(0.0) == far_width(_FIT_RANGE[0])
    assert near_weight(1.0) == near_weight(_FIT_RANGE[1])
    assert scattering_albedo(0.0) == pytest.approx(0, abs=1e-3)
