"""How much does one matrix for both rounds of subdivision save? Shape of a head, three ways.

Run with ``pytest tests/benchmarks/test_head_speed.py --benchmark-enable -s``.
"""

import sys
import time
from collections.abc import Callable

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from lrsr.identities.morphable import sample_head
from lrsr.identities.shape.basis import load_basis
from lrsr.identities.shape.subdivision import subdivide


def cpu_s(work: Callable[[], object], rounds: int = 5) -> float:
    times = []
    for _ in range(rounds):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return min(times)


def test_shaping_a_head_with_the_kept_matrix(benchmark: BenchmarkFixture) -> None:
    basis = load_basis()
    surface, weights = basis.surface, basis.neutral

    def from_matrix() -> object:
        return surface.matrix @ basis.shape(weights).skin

    def from_scratch() -> object:
        smooth = subdivide(basis.quads, basis.n_skin, 2, smooth=True)
        return smooth.matrix @ basis.shape(weights).skin

    benchmark(from_matrix)
    fast, slow = cpu_s(from_matrix), cpu_s(from_scratch, rounds=3)
    sys.stdout.write(f"\nshape {1e3 * fast:.1f} ms CPU; rebuilt subdivision {slow / fast:.0f} x\n")


@pytest.mark.parametrize("texture_size", [256, 512])
def test_a_whole_head(benchmark: BenchmarkFixture, texture_size: int) -> None:
    sample_head(0, texture_size=texture_size)
    seeds = iter(range(1, 1_000_000))
    head = benchmark(lambda: sample_head(next(seeds), texture_size=texture_size))
    assert np.isfinite(head.landmarks).all()
