"""How much faster is a training step of lrsr than the plain one that the common ports take?

Run with: pytest tests/benchmarks/test_srcnn_speed.py --benchmark-enable -n 0
"""

import time
from collections.abc import Callable
from functools import partial

import pytest
import torch
from pytest_benchmark.fixture import BenchmarkFixture
from torch.nn import functional as F

from lrsr.sr.networks.srcnn import SRCNN
from lrsr.training.precision import choose_precision
from lrsr.training.restoration import Restoration

BATCH = 128


def make_plain_step(patches: torch.Tensor, targets: torch.Tensor) -> Callable[[], None]:
    """One Adam step on 128 patches, eager, float32, contiguous."""
    network = SRCNN()
    optimizer = torch.optim.Adam(network.parameters(), lr=1e-4)

    def step() -> None:
        loss = F.mse_loss(network(patches), targets)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()

    return step


def make_step(patches: torch.Tensor, targets: torch.Tensor) -> Callable[[], None]:
    """The same through the learner, in the precision that this processor is trained in."""
    adam = partial(torch.optim.Adam, lr=1e-4)
    module = Restoration(architecture="srcnn", scale=4, loss="mse", optimizer=adam)
    optimizer = module.make_optimizer(module.parameter_groups())
    bfloat16 = choose_precision("cpu")[0] == "bf16-mixed"

    def step() -> None:
        with torch.autocast("cpu", torch.bfloat16, enabled=bfloat16):
            loss = module.loss((patches, targets))
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
    torch.manual_seed(0)
    patches, targets = torch.rand(BATCH, 1, 33, 33), torch.rand(BATCH, 1, 21, 21)
    plain_s = cpu_seconds(make_plain_step(patches, targets))
    ours = make_step(patches, targets)
    ours_s = cpu_seconds(ours)
    benchmark.extra_info["patches_per_cpu_second"] = BATCH / ours_s
    benchmark.extra_info["plain_patches_per_cpu_second"] = BATCH / plain_s
    benchmark.extra_info["ratio_to_plain_float32"] = plain_s / ours_s
    benchmark.pedantic(ours, rounds=5)
