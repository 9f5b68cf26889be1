"""How fast is the AUC with its interval, beside a sort of the scores and beside scikit-learn?

Run with ``pytest tests/benchmarks/test_delong_speed.py --benchmark-enable -s``: each line gives
CPU seconds and the ratio to two references timed in the same process on the same scores.
"""

import sys
import time
import tracemalloc
from collections.abc import Callable

import numpy as np
import pytest
from lrsr.evaluation.streaming import estimate_auc_of_embeddings
from pytest_benchmark.fixture import BenchmarkFixture
from sklearn.metrics import roc_auc_score

from lrsr.evaluation.delong import compare_aucs, estimate_auc

M, N = 500, 249_500


def least_cpu_s(work: Callable[[], object], rounds: int) -> float:
    times = []
    for _ in range(rounds):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return min(times)


def draw(kind: str, dtype: type, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    genuine, impostor = rng.normal(1.8, 1, M), rng.normal(0, 1, N)
    if kind == "one-decimal":
        genuine, impostor = genuine.round(1), impostor.round(1)
    if kind == "cauchy":
        genuine, impostor = rng.standard_cauchy(M) + 2, rng.standard_cauchy(N)
    if kind == "stray":
        genuine[0] = -1e6
    if kind == "separated":
        genuine += 3
    return genuine.astype(dtype), impostor.astype(dtype)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("kind", ["normal", "separated", "one-decimal", "cauchy", "stray"])
def test_estimate(benchmark: BenchmarkFixture, kind: str, dtype: type) -> None:
    genuine, impostor = draw(kind, dtype)
    scores = np.concatenate((genuine, impostor))
    labels = np.repeat([1, 0], [M, N])
    ours = least_cpu_s(lambda: estimate_auc(genuine, impostor), 15)
    sort = least_cpu_s(lambda: np.sort(scores), 15)
    sklearn = least_cpu_s(lambda: roc_auc_score(labels, scores), 5)
    benchmark.extra_info.update(over_sort=ours / sort, over_sklearn=ours / sklearn)
    sys.stdout.write(
        f"\n{kind} {ours * 1e3:.2f} ms = {ours / sort:.2f} sort = {ours / sklearn:.4f} sklearn\n"
    )
    estimate = benchmark(estimate_auc, genuine, impostor)
    assert estimate.auc == pytest.approx(roc_auc_score(labels, scores), rel=1e-9)


def test_comparison(benchmark: BenchmarkFixture) -> None:
    a, b = draw("normal", np.float32, 0), draw("normal", np.float32, 1)
    scores, labels = np.concatenate(a), np.repeat([1, 0], [M, N])
    ours = least_cpu_s(lambda: compare_aucs(*a, *b), 15)
    sort = least_cpu_s(lambda: np.sort(scores), 15)
    sklearn = least_cpu_s(lambda: roc_auc_score(labels, scores), 5)
    benchmark.extra_info.update(over_sort=ours / sort, over_sklearn=ours / sklearn)
    sys.stdout.write(
        f"\npaired {ours * 1e3:.2f} ms = {ours / sort:.2f} sort = {ours / sklearn:.4f} sklearn\n"
    )
    assert benchmark(compare_aucs, *a, *b).p > 0


def test_a_hundred_million_pairs(benchmark: BenchmarkFixture) -> None:
    rng = np.random.default_rng(0)
    centres = rng.normal(size=(10_000, 64)).astype(np.float32)
    faces = [centres + 1.2 * rng.normal(size=centres.shape).astype(np.float32) for _ in "pg"]
    probes, gallery = (f / np.linalg.norm(f, axis=1, keepdims=True) for f in faces)
    ids = [str(k) for k in range(10_000)]
    product = least_cpu_s(
        lambda: [probes[k : k + 200] @ gallery.T for k in range(0, 10_000, 200)], 1
    )
    start = time.process_time()
    estimate = benchmark.pedantic(
        estimate_auc_of_embeddings, args=(probes, gallery, ids, ids), rounds=1
    )
    ours = time.process_time() - start
    tracemalloc.start()
    estimate_auc_of_embeddings(probes, gallery, ids, ids)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    sys.stdout.write(
        f"\n1e8 pairs: {ours:.1f} s, the product alone {product:.1f} s, {peak / 2**20:.0f} MiB\n"
    )
    assert estimate.n_impostor == 10_000 * 9_999
    assert peak < 30 * 2**20
