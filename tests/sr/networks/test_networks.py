"""What every network of the list keeps; a new one is tested by being listed."""

import json

import pytest
import torch

from lrsr.sr.networks import NETWORKS
from lrsr.sr.networks.network import Network


@pytest.mark.parametrize("name", NETWORKS)
def test_network_says_what_it_takes(name: str) -> None:
    assert issubclass(NETWORKS[name], Network)
    assert NETWORKS[name].input in ("luminance", "rgb", "burst")


@pytest.mark.parametrize("name", NETWORKS)
def test_network_in_use_returns_the_whole_picture(name: str) -> None:
    kind = NETWORKS[name]
    network = kind(**kind.in_use)
    channels = 1 if kind.input == "luminance" else 3
    shape = network(torch.rand(network.takes(9, 5))).shape
    scale = 2 if kind.enlarges else 1
    assert shape == (1, channels, 9 * scale, 5 * scale)


@pytest.mark.parametrize("name", NETWORKS)
def test_arguments_in_use_are_plain(name: str) -> None:
    assert json.loads(json.dumps(dict(NETWORKS[name].in_use))) == dict(NETWORKS[name].in_use)
