"""The profile within a kernel: it is whole, and distances are drawn from it."""

import numpy as np
import pytest
from fakes.scenes import Studio

from lrsr.rendering.backend import _start
from lrsr.rendering.diffusion import NEAR, far_width, near_weight
from lrsr.rendering.exit_points import Profile

ALBEDO = (0.41, 0.2, 0.1)
PATH_MM = (1.3, 0.95, 0.67)


@pytest.fixture(scope="module", params=[10.0, 3.0], ids=["10 mm", "3 mm"])
def profile(request: pytest.FixtureRequest, renderer: Studio) -> Profile:
    mi = _start()
    return Profile(mi.Color3f(*ALBEDO), mi.Color3f(*PATH_MM), mi.Float(request.param))


def test_each_channel_is_whole_within_the_reach(profile: Profile) -> None:
    mi = _start()
    reach = float(profile.reach.numpy()[0])
    distance = (np.arange(40_000) + 0.5) * reach / 40_000
    rings = 2 * np.pi * distance * reach / 40_000
    for channel in profile.at(mi.Float(distance.astype(np.float32))):
        assert (channel.numpy() * rings).sum() == pytest.approx(1, abs=2e-3)


def test_a_far_reach_leaves_the_fits_as_they_are(renderer: Studio) -> None:
    mi = _start()
    whole = Profile(mi.Color3f(*ALBEDO), mi.Color3f(*PATH_MM), mi.Float(1000.0))
    for channel, (albedo, path) in enumerate(zip(ALBEDO, PATH_MM, strict=True)):
        near, far, weight = NEAR * path, far_width(albedo) * path, near_weight(albedo)
        heights = weight / near * np.exp(-2 / near) + (1 - weight) / far * np.exp(-2 / far)
        seen = whole.at(mi.Float(2.0))[channel].numpy()[0]
        assert seen == pytest.approx(heights / (4 * np.pi), rel=1e-3)


def test_distances_are_drawn_from_the_mean_of_the_channels(profile: Profile) -> None:
    mi = _start()
    count = 30_000
    uniform = mi.Float(((np.arange(count) + 0.5) / count).astype(np.float32))
    drawn = np.sort(profile.draw_distance(uniform).numpy())
    reach = float(profile.reach.numpy()[0])
    assert 0 <= drawn[0] <= drawn[-1] <= reach * (1 + 1e-5)
    grid = np.linspace(0, reach, 20_001)[1:]
    rings = 2 * np.pi * grid * np.mean(profile.at(mi.Float(grid.astype(np.float32))), axis=0)
    inside = np.cumsum(rings) * reach / 20_000
    for share in (0.1, 0.5, 0.9):
        wanted = np.interp(share, inside, grid)
        assert drawn[int(share * count)] == pytest.approx(wanted, rel=0.01)


def test_distances_have_no_jumps_where_channels_meet(profile: Profile) -> None:
    """Neighbours among stratified numbers are neighbours in distance, but for the two tails."""
    mi = _start()
    uniform = mi.Float(((np.arange(6000) + 0.5) / 6000).astype(np.float32))
    steps = np.abs(np.diff(profile.draw_distance(uniform).numpy()))
    reach = float(profile.reach.numpy()[0])
    assert (steps > 0.25 * reach).sum() <= 4
    assert np.median(steps) < 0.01 * reach
