"""What does a head cost, and how much does one matrix for both rounds of subdivision save?

Run with ``pytest tests/benchmarks/test_head_speed.py --benchmark-enable -s``.
"""

import sys
import time
from collections.abc import Callable
from functools import partial

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


@pytest.mark.parametrize("texture_size", [256, 512, 1024])
def test_a_whole_head(benchmark: BenchmarkFixture, texture_size: int) -> None:
    """Print median and worst of 50 people, beside the sorting of a million numbers, in turns."""
    sample_head(0, texture_size=texture_size)
    numbers = np.random.default_rng(0).random(1_000_000)
    heads, sorts = [], []
    for seed in range(1, 51):
        heads.append(cpu_s(partial(sample_head, seed, texture_size=texture_size), rounds=1))
        sorts.append(cpu_s(lambda: np.sort(numbers), rounds=1))
    median, worst, sort = float(np.median(heads)), max(heads), float(np.median(sorts))
    sys.stdout.write(
        f"\n{texture_size} texels: {1e3 * median:.0f} ms CPU, worst of 50 {1e3 * worst:.0f} ms; "
        f"{median / sort:.2f} and {worst / sort:.2f} sorts of a million float64\n"
    )
    seeds = iter(range(51, 1_000_000))
    head = benchmark(lambda: sample_head(next(seeds), texture_size=texture_size))
    assert np.isfinite(head.landmarks).all()
