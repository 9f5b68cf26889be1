import numpy as np
import torch

from lrsr.training.augmentation.texture import draw_textures


def test_textures_are_pictures_and_differ(rng: np.random.Generator) -> None:
    textures = draw_textures(20, 16, rng)
    assert textures.shape == (20, 3, 16, 16)
    assert 0 <= float(textures.min()) < float(textures.max()) <= 1
    means = textures.mean(dim=(2, 3))
    assert float(torch.cdist(means, means).add(torch.eye(20)).min()) > 1e-3


def test_the_same_numbers_give_the_same_textures() -> None:
    one, two = (draw_textures(3, 8, np.random.default_rng(5)) for _ in range(2))
    assert torch.equal(one, two)


def test_none_are_none(rng: np.random.Generator) -> None:
    assert draw_textures(0, 8, rng).shape == (0, 3, 8, 8)
