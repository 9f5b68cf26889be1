"""How fast is a face aligned, embedded and learned, beside OpenCV and beside bare PyTorch?

Run with ``pytest tests/benchmarks/test_embedding_speed.py --benchmark-enable -s``: each line gives
CPU milliseconds a face and the ratio to the named reference, timed in the same process.
"""

import sys
import time
from collections.abc import Callable
from functools import partial

import cv2
import numpy as np
import pytest
import torch
from pytest_benchmark.fixture import BenchmarkFixture

from lrsr.paths import asset
from lrsr.recognition.alignment import TEMPLATE_PX, align, fit_similarities
from lrsr.recognition.embedding import Embedder
from lrsr.training.backbone import Backbone
from lrsr.training.degradation import Degradation
from lrsr.training.identification import Identification
from lrsr.training.precision import choose_precision

COUNT = 128
GENERATOR = torch.Generator().manual_seed(0)
PROBES = torch.rand(COUNT, 3, 128, 128, generator=GENERATOR)  # IPD 8, enlarged by 4
CROPS = torch.rand(COUNT, 3, 112, 112, generator=GENERATOR)
LANDMARKS = np.random.default_rng(0).normal(TEMPLATE_PX * 0.9, 1.0, (COUNT, 5, 2))


def cpu_ms(work: Callable[[], object], rounds: int = 5) -> float:
    times = []
    for _ in range(rounds):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return 1000 * min(times) / COUNT


@pytest.mark.benchmark(group="align")
def test_alignment(benchmark: BenchmarkFixture) -> None:
    images = [image.permute(1, 2, 0).contiguous().numpy() for image in PROBES]

    def opencv() -> None:
        for image, matrix in zip(images, fit_similarities(LANDMARKS), strict=True):
            cv2.warpAffine(image, matrix, (112, 112), flags=cv2.INTER_LINEAR)

    benchmark(align, PROBES, LANDMARKS, antialias=False)
    ours = cpu_ms(lambda: align(PROBES, LANDMARKS, antialias=False))
    ratio = ours / cpu_ms(opencv)
    sys.stdout.write(f"\nalignment: {ours:.2f} ms a face, {ratio:.1f} times OpenCV's warpAffine\n")


@pytest.mark.benchmark(group="embed")
def test_embedding(benchmark: BenchmarkFixture) -> None:
    network = Backbone().eval()
    embedder = Embedder(asset("weights/arcface_small.onnx"))

    @torch.no_grad()
    def bare() -> None:
        network(CROPS)

    benchmark(embedder, CROPS)
    ours = cpu_ms(lambda: embedder(CROPS))
    ratio = ours / cpu_ms(bare)
    sys.stdout.write(
        f"\nembedding: {ours:.2f} ms a face, {ratio:.2f} times the network in PyTorch\n"
    )


@pytest.mark.benchmark(group="learn")
def test_training_step(benchmark: BenchmarkFixture) -> None:
    optimizer = partial(torch.optim.AdamW, lr=1e-3)
    module = Identification(people=500, optimizer=optimizer, degradation=Degradation())
    people, sharp = torch.arange(COUNT), torch.arange(COUNT) % 2 == 0
    crops = CROPS.mul(255).to(torch.uint8)

    has_bfloat16 = choose_precision("cpu")[0] == "bf16-mixed"

    def learn(faces: torch.Tensor, fast: bool) -> None:
        with torch.autocast("cpu", torch.bfloat16, enabled=fast):
            loss = torch.nn.functional.cross_entropy(module.head(module(faces), people), people)
        loss.backward()

    def step() -> None:
        faces = module.degradation(crops, sharp, np.random.default_rng(0))
        learn(faces, has_bfloat16)

    benchmark(step)
    ours, plain = cpu_ms(step), cpu_ms(lambda: learn(CROPS, False))
    sys.stdout.write(
        f"\ntraining: {ours:.2f} ms a face with its degradation, bfloat16 {has_bfloat16}; "
        f"{ours / plain:.2f} times the float32 step without degradation\n"
    )
