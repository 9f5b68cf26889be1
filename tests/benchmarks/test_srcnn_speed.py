"""How much faster is a training step of lrsr than the plain one that the common ports take?

Run with: pytest tests/benchmarks/test_srcnn_speed.py --benchmark-only --benchmark-enable -s
"""

import time
from collections.abc import Callable

import pytest
import torch
from lrsr.sr.module import SRCNNModule
from lrsr.sr.precision import choose_precision
from lrsr.sr.srcnn import SRCNN
from pytest_benchmark.fixture import BenchmarkFixture
from torch.nn import functional as F

BATCH = 128


def make_step(*, plain: bool) -> Callable[[], None]:
    """One Adam step on 128 patches: float32 and contiguous, or as SRCNNModule trains here."""
    torch.manual_seed(0)
    patches, target = torch.rand(BATCH, 1, 33, 33), torch.rand(BATCH, 1, 21, 21)
    network = SRCNN() if plain else SRCNNModule(scale=4).network
    bfloat16 = not plain and choose_precision("cpu")[0] == "bf16-mixed"
    optimizer = torch.optim.Adam(network.parameters(), lr=1e-4)
    layout = torch.contiguous_format if plain else torch.channels_last

    def step() -> None:
        with torch.autocast("cpu", torch.bfloat16, enabled=bfloat16):
            restored = network(patches.contiguous(memory_format=layout))
        loss = F.mse_loss(restored.float(), target)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()

    return step


@pytest.fixture(autouse=True)
def _one_thread() -> object:
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


def cpu_seconds(step: Callable[[], None], rounds: int = 10) -> float:
    """Processor time of one step: on a busy machine the clock on the wall says nothing."""
    step()
    begin = time.process_time()
    for _ in range(rounds):
        step()
    return (time.process_time() - begin) / rounds


def test_training_step(benchmark: BenchmarkFixture) -> None:
    plain_s = cpu_seconds(make_step(plain=True))
    ours = make_step(plain=False)
    ours_s = cpu_seconds(ours)
    benchmark.extra_info["patches_per_cpu_second"] = BATCH / ours_s
    benchmark.extra_info["plain_patches_per_cpu_second"] = BATCH / plain_s
    benchmark.extra_info["ratio_to_plain_float32"] = plain_s / ours_s
    benchmark.pedantic(ours, rounds=5)
