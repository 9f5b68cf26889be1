"""What does a lens cost beside the pinhole, and how many kernels do lenses and lightings compile?

pytest tests/benchmarks/test_lens_speed.py --benchmark-enable --benchmark-group-by=group -s
"""

import sys

import pytest
from fakes.scenes import LENSES, LIGHTINGS, POSES, ROOMS, STANDPOINTS, Studio
from pytest_benchmark.fixture import BenchmarkFixture

from lrsr.identities.head import Head
from lrsr.identities.morphable import sample_head
from lrsr.rendering.backend import _start
from lrsr.rendering.mounted_lens import mount


@pytest.fixture(scope="module")
def renderer() -> Studio:
    return Studio()


@pytest.fixture(scope="module")
def head() -> Head:
    return sample_head(0)


@pytest.mark.parametrize("lens", LENSES)
def test_a_probe_through_a_lens(
    benchmark: BenchmarkFixture, renderer: Studio, head: Head, lens: str
) -> None:
    benchmark.group = "probe, 32 px, 2048 samples"
    benchmark.pedantic(renderer.render, (head,), {"lens": lens}, rounds=5, warmup_rounds=1)


@pytest.mark.parametrize("lighting", ["side", "room_yellow"])
def test_a_probe_in_a_lighting(
    benchmark: BenchmarkFixture, renderer: Studio, head: Head, lighting: str
) -> None:
    benchmark.group = "probe, far and near light"
    benchmark.pedantic(renderer.render, (head,), {"lighting": lighting}, rounds=5, warmup_rounds=1)


def test_a_pose_moves_near_lights(
    benchmark: BenchmarkFixture, renderer: Studio, head: Head
) -> None:
    """Panels are part of the acceleration structure, which is built anew; far light costs 1 ms."""
    benchmark.group = "update"
    poses = iter(list(POSES.values()) * 10)
    benchmark.pedantic(
        lambda pose: renderer._live.show(head, ROOMS["room_blue"], pose),
        setup=lambda: ((next(poses),), {}),
        rounds=8,
        warmup_rounds=1,
    )


def test_mounting_a_lens(benchmark: BenchmarkFixture) -> None:
    benchmark.group = "mount"
    lens = LENSES["double_gauss"]
    benchmark(mount.__wrapped__, lens, 3.0, 1100.0, 0.5)


def test_count_the_kernels_of_all_lenses_lightings_and_standpoints(
    renderer: Studio, head: Head
) -> None:
    """Print how many kernels are compiled: one a number of panels, for pinholes and for lenses."""
    _start()
    import drjit as dr  # only now: it takes the LLVM that was chosen

    ask = {"ipd_px": 4.0, "samples_per_pixel": 61}  # no other test has kernels of that number
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory):
        dr.kernel_history_clear()
        for lighting in (*LIGHTINGS, *ROOMS):
            for lens in LENSES:
                for place in STANDPOINTS:
                    renderer.render(head, lighting=lighting, lens=lens, standpoint=place, **ask)
        history = dr.kernel_history([dr.KernelType.JIT])
    compiled = [entry for entry in history if not entry["cache_hit"]]
    large = sum(entry["operation_count"] > 1000 for entry in compiled)
    launches = f"{len(history)} launches, {len(compiled)} kernels compiled"
    sys.stdout.write(f"\n{launches}, {large} of them path tracers\n")
