"""Weights files, written on the spot."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import torch

from lrsr.sr.networks import NETWORKS
from lrsr.sr.weights import ENLARGED_BY, Card, write_weights


@pytest.fixture(autouse=True, scope="session")
def _one_thread() -> Iterator[None]:
    """Two threads on a busy machine are slower than one, and round differently."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


def card_of(architecture: str, scale: int, **arguments: object) -> Card:
    """A card without errors."""
    by = ENLARGED_BY if architecture == "srcnn" else ""
    takes = NETWORKS[architecture].input
    return Card(architecture, arguments, scale, takes, lr_made_by="test", enlarged_by=by)


@pytest.fixture
def weights_file(tmp_path: Path) -> Callable[..., Path]:
    """Write random weights for a scale; near the identity unless told otherwise."""

    def write(scale: int, initialisation: str = "near-identity") -> Path:
        torch.manual_seed(scale)
        path = tmp_path / f"srcnn{scale}x.safetensors"
        card = card_of("srcnn", scale, initialisation=initialisation)
        write_weights(path, NETWORKS["srcnn"](**card.arguments), card)
        return path

    return write


@pytest.fixture
def edsr_file(tmp_path: Path) -> Callable[..., Path]:
    """Write a small EDSR with random weights."""

    def write(scale: int) -> Path:
        torch.manual_seed(scale)
        path = tmp_path / f"edsr{scale}x.safetensors"
        card = card_of("edsr", scale, scale=scale, blocks=1, features=8)
        write_weights(path, NETWORKS["edsr"](**card.arguments), card)
        return path

    return write
