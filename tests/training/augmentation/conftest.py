import numpy as np
import pytest
import torch


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(0)


@pytest.fixture
def faces() -> torch.Tensor:
    """Eight smooth coloured pictures, srgb."""
    tones = torch.rand(8, 3, 6, 6, generator=torch.Generator().manual_seed(0))
    return torch.nn.functional.interpolate(tones, size=(112, 112), mode="bilinear")
