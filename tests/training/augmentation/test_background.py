import numpy as np
import pytest
import torch

from lrsr.errors import InputError
from lrsr.training.augmentation.background import Background, _background

Y, X = torch.meshgrid(torch.arange(112.0), torch.arange(112.0), indexing="ij")
HEAD = ((X - 56) / 40) ** 2 + ((Y - 70) / 65) ** 2 < 1


@pytest.fixture
def before_grey(faces: torch.Tensor) -> torch.Tensor:
    """Heads before an even grey with a camera's noise of 8 bits."""
    noise = torch.randint(-2, 3, faces.shape, generator=torch.Generator().manual_seed(0)) / 255
    return torch.where(HEAD, faces * 0.2, 0.55 + noise)


def test_what_is_keyed_is_what_was_put_behind(before_grey: torch.Tensor) -> None:
    """But for the pixel at the outline, which is half and half."""
    edge = torch.nn.functional.max_pool2d(HEAD[None].float(), 3, 1, 1)[0] > 0
    inside = torch.nn.functional.max_pool2d(~HEAD[None] * 1.0, 3, 1, 1)[0] == 0
    behind = _background(before_grey)[:, 0]
    assert bool((behind[:, ~edge] == 1).all())
    assert bool((behind[:, inside] == 0).all())


def test_faces_stay_and_what_is_behind_changes(
    before_grey: torch.Tensor, rng: np.random.Generator
) -> None:
    moved = Background(1.0)(before_grey, rng)
    inside = torch.nn.functional.max_pool2d(~HEAD[None] * 1.0, 3, 1, 1)[0] == 0
    assert torch.equal(moved[:, :, inside], before_grey[:, :, inside])
    assert float((moved - before_grey)[:, :, 0, 0].abs().amax(dim=1).min()) > 0.01


def test_a_skin_of_the_colour_of_the_wall_is_no_hole() -> None:
    even = torch.full((1, 3, 112, 112), 0.5)
    assert float(_background(even)[0, 0, 50:95, 45:68].max()) == 0


def test_nothing_asked_nothing_changed(before_grey: torch.Tensor, rng: np.random.Generator) -> None:
    assert torch.equal(Background()(before_grey, rng), before_grey)


def test_an_impossible_share_is_refused() -> None:
    with pytest.raises(InputError, match=r"background.share=2: wanted 0 to 1"):
        Background(2)
