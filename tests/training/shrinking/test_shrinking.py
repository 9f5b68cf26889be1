"""What holds of every degradation of ``conf/degradation`` for super-resolution."""

import pytest
import torch

from lrsr.camera import Camera
from lrsr.presets import preset, presets
from lrsr.training.patches import Pair
from lrsr.training.shrinking.shrinking import Shrinking

NAMES = [name for name in presets("degradation") if name not in ("photographs", "portraits")]


def shrunk(name: str, true: torch.Tensor, scale: int, start: int = 0) -> Pair:
    degradation: Shrinking = preset("degradation", name)
    seeds = list(range(start, start + len(true)))
    small, same = zip(*degradation(true, scale, seeds, Camera()), strict=True)
    return torch.cat(small), torch.cat(same)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("scale", [2, 3, 4])
def test_small_pictures_are_whole_in_8_bits_and_near_the_shrunken_true_one(
    name: str, scale: int, pictures: torch.Tensor
) -> None:
    small, true = shrunk(name, pictures, scale)
    assert small.shape == (4, 3, 48 // scale, 48 // scale)
    assert true.shape == pictures.shape
    for images in (small, true):
        assert images.dtype == torch.float32
        assert torch.equal((images * 255).round() / 255, images)
    shown = torch.nn.functional.avg_pool2d(true, scale)
    assert float((small - shown).square().mean(dim=(1, 2, 3)).max()) < 0.03


@pytest.mark.parametrize("name", NAMES)
def test_what_is_drawn_follows_from_the_seeds_alone(name: str, pictures: torch.Tensor) -> None:
    first, again, other = (shrunk(name, pictures, 2, start)[0] for start in (0, 0, 7))
    assert torch.equal(first, again)
    assert torch.equal(first, other) != preset("degradation", name).redrawn


@pytest.mark.parametrize("name", NAMES)
def test_small_and_true_pictures_show_the_same_place(name: str, pictures: torch.Tensor) -> None:
    """Over many draws no shift by half a small pixel is nearer than none at all."""
    true = pictures.repeat(8, 1, 1, 1)
    small, same = shrunk(name, true, 4)
    wide = torch.nn.functional.pad(same.mean(1, keepdim=True), (4, 4, 4, 4), mode="replicate")

    def distance(right: int, down: int) -> float:
        moved = wide[..., 4 + down : 52 + down, 4 + right : 52 + right]
        shown = torch.nn.functional.avg_pool2d(moved, 4)
        return float((small.mean(1, keepdim=True) - shown).square().mean())

    here = distance(0, 0)
    assert all(here < distance(*away) for away in [(2, 0), (-2, 0), (0, 2), (0, -2)])


@pytest.mark.parametrize("name", NAMES)
def test_every_degradation_says_in_words_what_it_does(name: str) -> None:
    degradation: Shrinking = preset("degradation", name)
    told = {degradation.in_words(Camera(), of_films=films) for films in (True, False)}
    assert all(len(words) > 20 for words in told)
