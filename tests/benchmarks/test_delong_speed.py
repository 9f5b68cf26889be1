"""How fast is the AUC with its interval, beside a sort of the scores and beside scikit-learn?

Run with ``pytest tests/benchmarks/test_delong_speed.py --benchmark-enable -s``: each line gives
CPU seconds and the ratio to two references timed in the same process on the same scores.

How long NumPy sorts 250,000 float32 depends on the processor: 21 ms by the plain sort, which the
bound of 0.3 is held against, and 1.6 ms (0.5 ms with heavy ties) where it has AVX2 or AVX-512. That
is the time of three plain passes of a look-up, so there the bounds only say that nothing got lost.
``NPY_DISABLE_CPU_FEATURES=X86_V3`` asks for the plain sort.
"""

import sys
import time
import tracemalloc
from collections.abc import Callable

import numpy as np
import pytest
from numpy._core._multiarray_umath import __cpu_features__
from pytest_benchmark.fixture import BenchmarkFixture
from sklearn.metrics import roc_auc_score

from lrsr.evaluation.delong import AucEstimate, compare_aucs, estimate_auc, estimate_auc_of
from lrsr.evaluation.placements import Placements
from lrsr.evaluation.scores import CosineScores, ScoreSource
from lrsr.evaluation.summary import summarise

M, N = 500, 249_500
SORTS_BY_VECTORS = any(__cpu_features__.get(name) for name in ("X86_V3", "AVX2", "AVX512_SKX"))
MOST_SORTS = {"one-decimal": 6.0, "cauchy": 3.5} if SORTS_BY_VECTORS else {}


def least_cpu_s(work: Callable[[], object], rounds: int) -> float:
    times = []
    for _ in range(rounds):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return min(times)


def stream_auc(source: ScoreSource) -> AucEstimate:
    placements = Placements(source.genuine())
    for tile in source.tiles():
        placements.count(placements.classes(tile.impostors))
    return estimate_auc_of(placements)


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
    ours = least_cpu_s(lambda: estimate_auc(genuine, impostor), 25)
    sort = least_cpu_s(lambda: np.sort(scores), 25)
    sklearn = least_cpu_s(lambda: roc_auc_score(labels, scores), 5)
    benchmark.extra_info.update(over_sort=ours / sort, over_sklearn=ours / sklearn)
    sys.stdout.write(
        f"\n{kind} {ours * 1e3:.2f} ms = {ours / sort:.2f} sort = {ours / sklearn:.4f} sklearn\n"
    )
    estimate = benchmark(estimate_auc, genuine, impostor)
    assert estimate.auc == pytest.approx(roc_auc_score(labels, scores), rel=1e-9)
    assert ours < MOST_SORTS.get(kind, 2.0 if SORTS_BY_VECTORS else 0.3) * sort


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


def ten_thousand(methods: int) -> dict[str, CosineScores]:
    rng = np.random.default_rng(0)
    centres = rng.normal(size=(10_000, 64))

    def photographs(noise: float) -> np.ndarray:
        faces = centres + noise * rng.normal(size=centres.shape)
        faces /= np.linalg.norm(faces, axis=1, keepdims=True)
        return faces.astype(np.float32)

    ids, gallery = [str(k) for k in range(10_000)], photographs(1.2)
    return {
        f"method {k}": CosineScores(photographs(1.2 + 0.1 * k), gallery, ids, ids)
        for k in range(methods)
    }


def peak_mib(work: Callable[[], object]) -> float:
    tracemalloc.start()
    work()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak / 2**20


def test_a_hundred_million_pairs(benchmark: BenchmarkFixture) -> None:
    (source,) = ten_thousand(1).values()
    start = time.process_time()
    estimate = benchmark.pedantic(stream_auc, args=(source,), rounds=1)
    ours = time.process_time() - start
    peak = peak_mib(lambda: stream_auc(source))
    sys.stdout.write(f"\n1e8 pairs: {ours:.1f} CPU s, {peak:.0f} MiB\n")
    assert estimate.n_impostor == 10_000 * 9_999
    assert peak < 30


def test_everything_of_two_methods_with_a_hundred_million_pairs(
    benchmark: BenchmarkFixture,
) -> None:
    methods = ten_thousand(2)
    start = time.process_time()
    found = benchmark.pedantic(summarise, args=(methods,), rounds=1)
    ours = time.process_time() - start
    peak = peak_mib(lambda: summarise(methods))
    sys.stdout.write(f"\n2 x 1e8 pairs, all measures: {ours:.1f} CPU s, {peak:.0f} MiB\n")
    assert found.comparisons["method 1", "method 0"].p < 1e-9
    assert peak < 300
