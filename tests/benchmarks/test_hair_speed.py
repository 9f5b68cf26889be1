"""What does hair cost beside the rest of a head?

Run with ``pytest tests/benchmarks/test_hair_speed.py --benchmark-enable -s``: each line gives CPU
seconds and the ratio to making the whole head, timed in the same process on the same person.
"""

import sys
import time
from collections.abc import Callable

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from lrsr.identities.hair.hair import build_hair
from lrsr.identities.hair.scalp import Scalp
from lrsr.identities.hair.styles import STYLES, style_parameters
from lrsr.identities.morphable import _position_map, sample_head

COLOUR = {"hair_colour": [0.1, 0.05, 0.02], "grey": 0.2}


def cpu_s(work: Callable[[], object], rounds: int = 5) -> float:
    times = []
    for _ in range(rounds):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return min(times)


@pytest.mark.benchmark(group="hair")
@pytest.mark.parametrize("style", STYLES)
def test_mesh_and_texture(benchmark: BenchmarkFixture, style: str) -> None:
    head = sample_head(0)
    skin = head.part("skin").vertices
    hair = style_parameters(style, np.random.default_rng(0)) | COLOUR
    benchmark(build_hair, hair, skin, 0)
    grown, whole = cpu_s(lambda: build_hair(hair, skin, 0)), cpu_s(lambda: sample_head(0), 2)
    sys.stdout.write(f"\n{style}: {1e3 * grown:.0f} ms, {grown / whole:.0%} of a whole head\n")


@pytest.mark.benchmark(group="hair")
def test_roots(benchmark: BenchmarkFixture) -> None:
    scalp = Scalp(_position_map(512).points)
    hair = style_parameters("crop", np.random.default_rng(0))
    benchmark(scalp.roots, hair, 0)
    painted, whole = cpu_s(lambda: scalp.roots(hair, 0)), cpu_s(lambda: sample_head(0), 2)
    sys.stdout.write(f"\nroots: {1e3 * painted:.0f} ms, {painted / whole:.0%} of a whole head\n")
