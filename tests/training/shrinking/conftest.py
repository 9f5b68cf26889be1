import pytest
import torch
from fakes.lessons import draw_pictures


@pytest.fixture
def pictures() -> torch.Tensor:
    """Four pictures of discs, 48 px, in 8 bits."""
    return draw_pictures(4, 48, seed=3).mul(255).round().div(255)
