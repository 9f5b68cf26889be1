"""Frames in any order and number; what does not reach a place says nothing of it."""

import pytest
import torch

from lrsr.errors import InputError
from lrsr.sr.networks.fusion import Fusion

PLACES = 4
"""Of 2x."""


def frames(count: int = 4, seed: int = 0) -> torch.Tensor:
    """Laid over each other, all reaching everywhere."""
    laid = torch.rand(2, count, 4 * PLACES, 6, 5, generator=torch.Generator().manual_seed(seed))
    return laid.clamp_min(0.1)


@pytest.fixture
def network() -> Fusion:
    """One that has learned something: no weight is small."""
    torch.manual_seed(0)
    network = Fusion(scale=2, features=6).eval().requires_grad_(False)
    for layer in (network.weigh, network.enlarge):
        for parameter in layer.parameters():
            parameter.mul_(100)
    return network


def test_the_order_of_later_frames_does_not_matter(network: Fusion) -> None:
    laid = frames()
    torch.testing.assert_close(network(laid[:, [0, 3, 1, 2]]), network(laid))
    assert float((network(laid[:, [1, 0, 2, 3]]) - network(laid)).abs().max()) > 0.01


def test_a_frame_that_reaches_nowhere_counts_nowhere(network: Fusion) -> None:
    laid = frames()
    nowhere = torch.cat([laid, torch.zeros_like(laid[:, :2])], dim=1)
    torch.testing.assert_close(network(nowhere), network(laid))


def test_it_begins_at_the_mean_of_those_that_reach_a_place() -> None:
    torch.manual_seed(0)
    laid = frames()
    laid[:, 2, :, :, 3:] = 0
    begun = Fusion(scale=2)(laid).detach()
    colours = torch.nn.functional.pixel_shuffle(laid[:, :, : 3 * PLACES], 2)
    mean = torch.cat([colours[..., :6].mean(1), colours[:, [0, 1, 3]][..., 6:].mean(1)], dim=-1)
    assert 0 < float((begun - mean).abs().max()) < 0.02


def test_every_layer_can_learn_from_the_beginning() -> None:
    network = Fusion(scale=2, features=8)
    network(frames()).square().mean().backward()
    assert all(bool((p.grad != 0).any()) for p in network.parameters())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"scale": 5}, "module.arguments.scale=5: wanted a whole number, 2 to 4"),
        ({"features": 0}, "module.arguments.features=0: wanted a whole number, 1 to 1024"),
        ({"blocks": 0}, "module.arguments.blocks=0: wanted a whole number, 1 to 64"),
    ],
    ids=str,
)
def test_arguments_out_of_range_are_refused(arguments: dict[str, int], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Fusion(**arguments)
