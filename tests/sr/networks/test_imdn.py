import numpy as np
import pytest
import torch
from scipy.signal import correlate

from lrsr.errors import InputError
from lrsr.images import resize_bicubic
from lrsr.sr.networks.imdn import IMDN

Weights = dict[str, np.ndarray]


def convolved(channels: np.ndarray, weights: Weights, name: str) -> np.ndarray:
    """A convolution by scipy that repeats the edge, one output channel after the other."""
    kernels, biases = weights[f"{name}.weight"], weights[f"{name}.bias"]
    side = kernels.shape[-1] // 2
    padded = np.pad(channels, ((0, 0), (side, side), (side, side)), mode="edge")
    outputs = [correlate(padded, kernel, mode="valid")[0] for kernel in kernels]
    return np.stack(outputs) + biases[:, None, None]


def leaky(channels: np.ndarray) -> np.ndarray:
    return np.where(channels > 0, channels, 0.05 * channels)


def independent_block(features: np.ndarray, weights: Weights, name: str) -> np.ndarray:
    """The paper's figure 3, with the attention of its equation 3."""
    quarter = len(features) // 4
    first = leaky(convolved(features, weights, f"{name}.steps.0"))
    second = leaky(convolved(first[quarter:], weights, f"{name}.steps.1"))
    third = leaky(convolved(second[quarter:], weights, f"{name}.steps.2"))
    fourth = convolved(third[quarter:], weights, f"{name}.steps.3")
    found = np.concatenate([first[:quarter], second[:quarter], third[:quarter], fourth])
    contrast = (found.std((1, 2)) + found.mean((1, 2)))[:, None, None]
    squeezed = np.maximum(convolved(contrast, weights, f"{name}.attention.squeeze"), 0)
    gain = 1 / (1 + np.exp(-convolved(squeezed, weights, f"{name}.attention.widen")))
    return features + convolved(found * gain, weights, f"{name}.fuse")


def independent_imdn(srgb: np.ndarray, weights: Weights, blocks: int, scale: int) -> np.ndarray:
    """The paper's figure 2, by NumPy."""
    head = convolved(srgb, weights, "head")
    found = [head]
    for block in range(blocks):
        found.append(independent_block(found[-1], weights, f"blocks.{block}"))
    fused = leaky(convolved(np.concatenate(found[1:]), weights, "fuse"))
    small = convolved(head + convolved(fused, weights, "after"), weights, "enlarge")
    larger = np.empty((3, scale * srgb.shape[1], scale * srgb.shape[2]))
    for k, channel in enumerate(small):
        colour, place = divmod(k, scale**2)
        larger[colour, place // scale :: scale, place % scale :: scale] = channel
    return larger


# Hui et al. (2019), table 5: 694 K, 703 K and 715 K.
@pytest.mark.parametrize(("scale", "count"), [(2, 694_404), (3, 703_059), (4, 715_176)])
def test_the_papers_size_has_the_published_number_of_parameters(scale: int, count: int) -> None:
    assert sum(parameter.numel() for parameter in IMDN(scale=scale).parameters()) == count


@pytest.mark.parametrize("scale", [2, 3])
def test_forward_is_the_papers_figure(scale: int) -> None:
    torch.manual_seed(3)
    network = IMDN(scale=scale, blocks=2, features=16).double()
    weights = {name: p.detach().numpy() for name, p in network.named_parameters()}
    srgb = torch.rand(1, 3, 5, 7, dtype=torch.float64)
    with torch.no_grad():
        larger = network(srgb)[0].numpy()
    expected = independent_imdn(srgb[0].numpy(), weights, 2, scale)
    np.testing.assert_allclose(larger, expected, atol=1e-9)


@pytest.mark.parametrize("scale", [2, 3, 4])
def test_near_bicubic_start_is_within_three_percent_of_bicubic(scale: int) -> None:
    torch.manual_seed(0)
    noise = torch.rand(1, 3, 20, 20, generator=torch.Generator().manual_seed(0))
    smooth = torch.nn.functional.avg_pool2d(noise, 5, 1)
    with torch.no_grad():
        larger = IMDN(scale=scale, blocks=2, features=16, initialisation="near-bicubic")(smooth)
    assert 0.0 < float((larger - resize_bicubic(smooth, scale)).abs().max()) < 0.03


def test_near_bicubic_start_can_learn_in_every_layer() -> None:
    torch.manual_seed(0)
    network = IMDN(blocks=2, features=32, initialisation="near-bicubic")
    network(torch.rand(2, 3, 9, 9)).square().mean().backward()
    assert all(bool((p.grad != 0).any()) for p in network.parameters())


def test_a_flat_picture_has_a_gradient() -> None:
    """Its standard deviation is zero, where a square root has none."""
    network = IMDN(blocks=1, features=16)
    network(torch.full((1, 3, 1, 1), 0.5)).sum().backward()
    assert all(bool(torch.isfinite(p.grad).all()) for p in network.parameters())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"scale": 1}, "module.arguments.scale=1: wanted a whole number, 2 to 4"),
        ({"blocks": 0}, "module.arguments.blocks=0: wanted a whole number, 1 to 64"),
        ({"features": 24}, "module.arguments.features=24: wanted a multiple of 16"),
        ({"features": 8}, "module.arguments.features=8: wanted a whole number, 16 to"),
    ],
    ids=str,
)
def test_arguments_out_of_range_are_refused(arguments: dict[str, int], message: str) -> None:
    with pytest.raises(InputError, match=message):
        IMDN(**arguments)
