"""What do three models of skin cost for a picture as free of noise, on the same face?

pytest tests/benchmarks/test_skin_speed.py --benchmark-enable -s
"""

import gc
import sys
import time
from collections.abc import Iterator

import numpy as np
import pytest
from fakes.scenes import Studio
from numpy.typing import NDArray

from lrsr.identities.head import Head
from lrsr.identities.morphable import sample_head
from lrsr.images import linear_to_srgb
from lrsr.rendering.backend import _start

SAMPLES = {"reflective": 512, "subsurface": 512, "volumetric_tone": 128}
CONVERGED = 16
"""The reference of each skin has so many times the samples (and shares none with what is timed)."""

FILMS = [
    pytest.param(8, 1, "frontal", id="32px-frontal"),
    pytest.param(8, 1, "side", id="32px-side"),
]
FILMS += [pytest.param(64, 16, "frontal", id="256px-frontal")]


@pytest.fixture(scope="module")
def head() -> Head:
    return sample_head(3)


def pictures(
    renderer: Studio, head: Head, ipd_px: float, lighting: str, samples: int, seeds: range
) -> tuple[NDArray, float]:
    """Return pictures and the seconds that the processor works for one, whoever else is there."""
    shown, seconds = [], []
    for seed in seeds:
        began = time.process_time()
        result = renderer.render(
            head, lighting=lighting, ipd_px=ipd_px, samples_per_pixel=samples, seed=seed
        )
        seconds.append(time.process_time() - began)
        shown.append((result.image / result.metered).numpy())
    return np.array(shown), float(np.median(seconds))


@pytest.mark.parametrize(("ipd_px", "fewer", "lighting"), FILMS)
def test_the_three_skins_at_equal_noise(
    head: Head, ipd_px: float, fewer: int, lighting: str
) -> None:
    """Print time, RMSE against a converged picture of the same skin, and what a picture costs."""
    costs, lines = {}, [f"\n{ipd_px * 4} px, {lighting} light"]
    for skin, samples in SAMPLES.items():
        renderer, count = Studio(skin), samples // fewer
        pictures(renderer, head, ipd_px, lighting, count, range(1))  # compiles
        timed, seconds = pictures(renderer, head, ipd_px, lighting, count, range(1, 5))
        many = range(100, 100 + CONVERGED)
        truth = pictures(renderer, head, ipd_px, lighting, count, many)[0].mean(axis=0)
        # The reference's own noise is 1/16 of the variance; taken off.
        square = float(((timed - truth) ** 2).mean()) / (1 + 1 / CONVERGED)
        costs[skin] = seconds * square
        lines.append(f"{skin:16} {count:4} spp {seconds:7.3f} s  RMSE {square**0.5:.5f}")
        del renderer
        gc.collect()
    base = costs["subsurface"]
    lines.append(f"speed-up over volumetric {costs['volumetric_tone'] / base:.0f}")
    lines.append(f"cost over reflective {base / costs['reflective']:.1f}")
    sys.stdout.write("\n".join(lines) + "\n")


@pytest.fixture(scope="module")
def both() -> Iterator[dict[str, Studio]]:
    yield {skin: Studio(skin) for skin in ("reflective", "subsurface")}
    gc.collect()


@pytest.mark.parametrize("lighting", ["frontal", "side"])
def test_how_far_the_two_skins_differ(head: Head, both: dict[str, Studio], lighting: str) -> None:
    """Print the difference in 8-bit steps at four sizes, exposed alike."""
    for ipd_px in (8, 16, 32, 64):
        shown = []
        for renderer in both.values():
            rays = max(2048 * 64 // ipd_px**2, 128)
            result = renderer.render(head, lighting=lighting, ipd_px=ipd_px, samples_per_pixel=rays)
            shown.append(255 * linear_to_srgb(0.9 * result.image / result.metered).numpy())
        steps = shown[1] - shown[0]
        face = np.abs(steps).max(axis=0) > 0.5
        bias = steps[:, face].mean(axis=1).round(1)
        rms = np.sqrt((steps[:, face] ** 2).mean(axis=1)).round(1)
        largest = np.abs(steps).max()
        sys.stdout.write(
            f"\nIPD {ipd_px} {lighting}: mean {bias}, RMS {rms}, largest {largest:.0f} (RGB)"
        )


def test_count_the_kernels_of_20_heads_at_three_scales() -> None:
    """Print how many kernels are compiled for 20 people, 6 options and 3 scales."""
    _start()  # chooses the LLVM that Dr.Jit loads
    import drjit as dr

    renderer = Studio("subsurface")
    options = [("frontal", "frontal"), ("above", "frontal"), ("above", "down")]
    options += [("frontal", "down"), ("below", "up"), ("below", "left")]
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory):
        dr.kernel_history_clear()
        for seed in range(20):
            head = sample_head(seed)
            for lighting, pose in options:
                for scale in (1, 2, 4):
                    renderer.render(
                        head, pose=pose, lighting=lighting, scale=scale, samples_per_pixel=256
                    )
        history = dr.kernel_history([dr.KernelType.JIT])
    large = {entry["hash"] for entry in history if entry["operation_count"] > 2000}
    compiled = [entry for entry in history if not entry["cache_hit"]]
    sys.stdout.write(
        f"\n{len(history)} launches, {len(compiled)} kernels compiled, {len(large)} of them tracers"
    )
