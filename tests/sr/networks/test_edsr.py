import numpy as np
import pytest
import torch
from scipy.signal import correlate

from lrsr.errors import InputError
from lrsr.images import resize_bicubic
from lrsr.sr.networks.edsr import EDSR


def convolved(channels: np.ndarray, weights: dict[str, np.ndarray], name: str) -> np.ndarray:
    """A 3x3 convolution by scipy, zeros around, one output channel after the other."""
    padded = np.pad(channels, ((0, 0), (1, 1), (1, 1)))
    return np.stack(
        [
            correlate(padded, kernel, mode="valid")[0] + bias
            for kernel, bias in zip(weights[f"{name}.weight"], weights[f"{name}.bias"], strict=True)
        ]
    )


def shuffled(channels: np.ndarray) -> np.ndarray:
    """Shi et al. (2016), equation 4: channel 4c + 2y + x is pixel (y, x) of channel c's 2x2."""
    count, height, width = channels.shape
    result = np.empty((count // 4, 2 * height, 2 * width))
    for k, channel in enumerate(channels):
        result[k // 4, k % 4 // 2 :: 2, k % 2 :: 2] = channel
    return result


def independent_edsr(
    srgb: np.ndarray, weights: dict[str, np.ndarray], blocks: int, steps: int
) -> np.ndarray:
    """The paper's figure 3, by NumPy."""
    mean = np.array([0.4488, 0.4371, 0.4040])[:, None, None]  # the authors' DIV2K
    head = convolved(srgb - mean, weights, "head")
    features = head
    for block in range(blocks):
        inner = np.maximum(convolved(features, weights, f"body.{block}.first"), 0)
        features = features + convolved(inner, weights, f"body.{block}.second")
    features = head + convolved(features, weights, "after")
    for step in range(steps):
        features = shuffled(convolved(features, weights, f"enlarge.{step}"))
    return convolved(features, weights, "tail") + mean


# Lim et al. (2017), table 1 gives 1.5 M for the baseline; the authors' own code, EDSR-PyTorch,
# prints 1,369,859 for x2 and 1,517,571 for x4 without its two fixed mean shifts.
@pytest.mark.parametrize(("scale", "count"), [(2, 1_369_859), (4, 1_517_571)])
def test_baseline_has_the_published_number_of_parameters(scale: int, count: int) -> None:
    assert sum(parameter.numel() for parameter in EDSR(scale=scale).parameters()) == count


@pytest.mark.parametrize("scale", [2, 4])
def test_forward_is_the_papers_figure(scale: int) -> None:
    torch.manual_seed(3)
    network = EDSR(scale=scale, blocks=2, features=6).double()
    weights = {name: p.detach().numpy() for name, p in network.named_parameters()}
    srgb = torch.rand(1, 3, 5, 7, dtype=torch.float64)
    with torch.no_grad():
        larger = network(srgb)[0].numpy()
    expected = independent_edsr(srgb[0].numpy(), weights, 2, scale // 2)
    assert larger.shape == (3, 5 * scale, 7 * scale)
    np.testing.assert_allclose(larger, expected, atol=1e-6)  # the mean is kept as float32


def test_there_is_no_batch_norm() -> None:
    assert not any("norm" in type(part).__name__.lower() for part in EDSR(blocks=1).modules())


@pytest.mark.parametrize("scale", [2, 4])
def test_near_bicubic_start_is_within_three_percent_of_bicubic_inside(scale: int) -> None:
    torch.manual_seed(0)
    noise = torch.rand(1, 3, 28, 28, generator=torch.Generator().manual_seed(0))
    smooth = torch.nn.functional.avg_pool2d(noise, 5, 1)
    with torch.no_grad():
        larger = EDSR(scale=scale, initialisation="near-bicubic")(smooth)
    inside = (..., slice(4 * scale, -4 * scale), slice(4 * scale, -4 * scale))
    assert 0.0 < float((larger - resize_bicubic(smooth, scale))[inside].abs().max()) < 0.03


def test_near_bicubic_start_can_learn_in_every_layer() -> None:
    network = EDSR(scale=4, blocks=2, features=8, initialisation="near-bicubic")
    network(torch.rand(1, 3, 9, 9)).square().mean().backward()
    assert all(bool((p.grad != 0).any()) for p in network.parameters())


def test_one_pixel_can_be_enlarged() -> None:
    assert EDSR(scale=4, blocks=1, features=4)(torch.rand(1, 3, 1, 1)).shape == (1, 3, 4, 4)


@pytest.mark.parametrize(
    "arguments",
    [{"scale": 3}, {"scale": 1}, {"blocks": 0}, {"blocks": 10**9}, {"features": 2}],
    ids=str,
)
def test_arguments_out_of_range_are_refused(arguments: dict[str, int]) -> None:
    with pytest.raises(InputError, match=r"EDSR: scale=.*wanted scale 2 or 4"):
        EDSR(**arguments)
