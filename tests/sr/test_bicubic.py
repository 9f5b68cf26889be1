import numpy as np
import pytest
import torch

from lrsr.images import resize_bicubic
from lrsr.sr.upscaler import Bicubic
from lrsr.sr.weights import ENLARGED_BY


def keys(x: np.ndarray, a: float = -0.5) -> np.ndarray:
    """Keys' cubic, as MATLAB's imresize writes it: `cubic(x)` of toolbox/images/imresize.m."""
    x = np.abs(x)
    near = (a + 2) * x**3 - (a + 3) * x**2 + 1
    far = a * x**3 - 5 * a * x**2 + 8 * a * x - 4 * a
    return np.where(x <= 1, near, np.where(x <= 2, far, 0.0))


def imresize_line(line: np.ndarray, scale: float) -> np.ndarray:
    """One line by imresize's rule, edge pixels repeated: centre u = (x + 0.5) / s - 0.5."""
    widen = min(scale, 1.0)
    result = []
    for x in range(round(len(line) * scale)):
        u = (x + 0.5) / scale - 0.5
        taps = np.arange(np.floor(u - 2 / widen), np.ceil(u + 2 / widen) + 1)
        weights = keys((taps - u) * widen)
        values = line[np.clip(taps, 0, len(line) - 1).astype(int)]
        result.append((weights * values).sum() / weights.sum())
    return np.array(result)


@pytest.mark.parametrize(
    ("scale", "weights"),
    [
        # keys at distances 1.75, 0.75, 0.25, 1.25 by hand
        pytest.param(2, [-0.0234375, 0.2265625, 0.8671875, -0.0703125], id="2x"),
        # keys at distances 1.625, 0.625, 0.375, 1.375 by hand
        pytest.param(4, [-0.0439453125, 0.3896484375, 0.7275390625, -0.0732421875], id="4x"),
    ],
)
def test_kernel_is_matlabs_with_a_of_minus_one_half(scale: int, weights: list[float]) -> None:
    impulses = torch.eye(16)[:, None, None].expand(16, 1, 16, 16).contiguous()
    row = resize_bicubic(impulses, scale)[:, 0, 8 * scale]
    np.testing.assert_allclose(row[6:10, 8 * scale].numpy(), weights, atol=1e-6)


@pytest.mark.parametrize("scale", [0.25, 0.5, 2, 4])
def test_lines_follow_imresizes_rule_to_the_edge(scale: int) -> None:
    line = np.random.default_rng(0).random(16)
    image = torch.from_numpy(line).float().expand(1, 1, 16, 16).contiguous()
    resized = resize_bicubic(image, scale)[0, 0, 0]
    np.testing.assert_allclose(resized.numpy(), imresize_line(line, scale), atol=2e-6)


def test_there_is_one_bicubic_and_reports_name_it() -> None:
    picture = torch.rand(1, 3, 6, 5, generator=torch.Generator().manual_seed(0))
    assert torch.equal(Bicubic(2)(picture), resize_bicubic(picture, 2).clamp(0, 1))
    assert Bicubic(2).describe()["kernel"] == ENLARGED_BY
    assert "a=-0.5" in ENLARGED_BY
