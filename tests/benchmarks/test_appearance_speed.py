"""How much does it save to carve each line within its own box, and to paint from set-up maps?

Run with ``pytest tests/benchmarks/test_appearance_speed.py --benchmark-enable -s``: each line gives
CPU seconds and the ratio to the plain way, timed in the same process on the same person.
"""

import sys
import time
from collections.abc import Callable

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture
from scipy import ndimage

from lrsr.identities.appearance import SkinPainter
from lrsr.identities.face.template import template
from lrsr.identities.morphable import _position_map, sample_parameters
from lrsr.identities.skin import regions
from lrsr.identities.skin.lines import draw_lines, sample_lines

LINES = sample_lines(np.random.default_rng(0), age=0.9, masculinity=0.5)
N_LINES = 12 + LINES["forehead_count"]


def cpu_s(work: Callable[[], object], rounds: int = 5) -> float:
    times = []
    for _ in range(rounds):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return min(times)


def blur_whole_sheets() -> None:
    """The prototype's way: every line is blurred over the whole sheet."""
    sheet = np.zeros(regions.FACE.shape, dtype=np.float32)
    for _ in range(N_LINES):
        ndimage.gaussian_filter(sheet, 3.0)


@pytest.mark.benchmark(group="lines")
def test_lines(benchmark: BenchmarkFixture) -> None:
    benchmark(draw_lines, LINES, regions.FACE)
    ratio = cpu_s(blur_whole_sheets, 2) / cpu_s(lambda: draw_lines(LINES, regions.FACE))
    sys.stdout.write(f"\nlines: {ratio:.0f} times faster than {N_LINES} blurs of the whole sheet\n")


@pytest.mark.benchmark(group="skin")
def test_skin(benchmark: BenchmarkFixture) -> None:
    layout = _position_map(512)
    painter, person = SkinPainter(layout, template().skin), sample_parameters(0)["appearance"]
    benchmark(painter.paint, person, 0)
    kept = cpu_s(lambda: painter.paint(person, 0))
    once = cpu_s(lambda: SkinPainter(layout, template().skin).paint(person, 0), 2)
    sys.stdout.write(
        f"\nskin, 512 texels: {kept:.3f} s; without a kept painter {once / kept:.1f} x\n"
    )
