import numpy as np
import pytest
import torch
from scipy.signal import correlate

from lrsr.errors import InputError
from lrsr.images import resize_bicubic
from lrsr.sr.networks.fsrcnn import FSRCNN


def convolved(channels: np.ndarray, kernels: np.ndarray, biases: np.ndarray) -> np.ndarray:
    """A convolution by scipy that repeats the edge, one output channel after the other."""
    side = kernels.shape[-1] // 2
    padded = np.pad(channels, ((0, 0), (side, side), (side, side)), mode="edge")
    outputs = [correlate(padded, kernel, mode="valid")[0] for kernel in kernels]
    return np.stack(outputs) + biases[:, None, None]


def independent_fsrcnn(
    luminance: np.ndarray, weights: dict[str, np.ndarray], scale: int
) -> np.ndarray:
    """The paper's figure 2, by NumPy; the deconvolution adds a kernel at each small pixel."""
    features, count = luminance[None], sum(name.startswith("rect") for name in weights)
    for layer in range(count):
        features = convolved(
            features, weights[f"layers.{layer}.weight"], weights[f"layers.{layer}.bias"]
        )
        slope = weights[f"rectifiers.{layer}.weight"][:, None, None]
        features = np.where(features > 0, features, slope * features)
    features = np.pad(features, ((0, 0), (2, 2), (2, 2)), mode="edge")
    _, height, width = features.shape
    canvas = np.zeros((scale * (height - 1) + 9, scale * (width - 1) + 9))
    for y in range(height):
        for x in range(width):
            stamp = np.tensordot(features[:, y, x], weights["reconstruct.weight"][:, 0], 1)
            canvas[scale * y : scale * y + 9, scale * x : scale * x + 9] += stamp
    first = {2: 4, 3: 3, 4: 3}[scale] + 2 * scale  # a kernel's middle is the small pixel's
    shown = slice(first, first + scale * luminance.shape[0])
    columns = slice(first, first + scale * luminance.shape[1])
    return canvas[shown, columns] + weights["reconstruct.bias"]


def test_weights_without_biases_are_as_many_as_published() -> None:
    """Dong et al. (2016), table 1: FSRCNN (56, 12, 4) has 12,464."""
    assert sum(p.numel() for p in FSRCNN().parameters() if p.ndim == 4) == 12_464


def test_layers_are_those_of_the_paper() -> None:
    shapes = [tuple(p.shape) for name, p in FSRCNN().named_parameters() if p.ndim == 4]
    maps = [(12, 12, 3, 3)] * 4
    assert shapes == [(56, 1, 5, 5), (12, 56, 1, 1), *maps, (56, 12, 1, 1), (56, 1, 9, 9)]


@pytest.mark.parametrize("scale", [2, 3, 4])
def test_forward_is_the_papers_figure(scale: int) -> None:
    torch.manual_seed(scale)
    network = FSRCNN(scale=scale, features=5, shrunken=3, maps=2).double()
    weights = {name: p.detach().numpy() for name, p in network.named_parameters()}
    luminance = torch.rand(1, 1, 4, 6, dtype=torch.float64)
    with torch.no_grad():
        larger = network(luminance)[0, 0].numpy()
    assert larger.shape == (4 * scale, 6 * scale)
    expected = independent_fsrcnn(luminance[0, 0].numpy(), weights, scale)
    np.testing.assert_allclose(larger, expected, atol=1e-12)


@pytest.mark.parametrize(("scale", "within"), [(2, 0.02), (3, 0.06), (4, 0.06)])
def test_near_bicubic_start_is_near_bicubic_up_to_the_border(scale: int, within: float) -> None:
    """Nine pixels hold the cubic of 2x whole; of 3x and 4x they lack its tails."""
    torch.manual_seed(0)
    noise = torch.rand(1, 1, 20, 20, generator=torch.Generator().manual_seed(0))
    smooth = 0.1 + 0.8 * torch.nn.functional.avg_pool2d(noise, 5, 1)
    with torch.no_grad():
        larger = FSRCNN(scale=scale, initialisation="near-bicubic")(smooth)
    assert 0.0 < float((larger - resize_bicubic(smooth, scale)).abs().max()) < within


def test_near_bicubic_start_can_learn_in_every_layer() -> None:
    network = FSRCNN(initialisation="near-bicubic")
    network(torch.rand(1, 1, 9, 9)).square().mean().backward()
    assert all(bool((p.grad != 0).any()) for p in network.parameters())


def test_one_pixel_can_be_enlarged() -> None:
    assert FSRCNN(scale=3)(torch.rand(1, 1, 1, 1)).shape == (1, 1, 3, 3)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"scale": 5}, "module.arguments.scale=5: wanted a whole number, 2 to 4"),
        ({"features": 0}, "module.arguments.features=0: wanted a whole number, 1 to"),
        ({"shrunken": 1.5}, "module.arguments.shrunken=1.5: wanted a whole number"),
        ({"maps": True}, "module.arguments.maps=true: wanted a whole number"),
        ({"initialisation": "zero"}, "module.arguments.initialisation=zero: wanted one of"),
    ],
    ids=str,
)
def test_arguments_out_of_range_are_refused(arguments: dict[str, int], message: str) -> None:
    with pytest.raises(InputError, match=message):
        FSRCNN(**arguments)
