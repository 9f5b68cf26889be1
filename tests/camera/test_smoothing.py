"""Blurs, against SciPy, kornia and their own laws."""

from collections.abc import Callable

import numpy as np
import pytest
import torch
from kornia.filters import bilateral_blur as kornia_bilateral
from scipy.ndimage import gaussian_filter

from lrsr.camera.smoothing import bilateral_blur, gaussian_blur
from lrsr.errors import ImageContractError, InputError

Blur = Callable[[torch.Tensor], torch.Tensor]
BLURS = [lambda x: gaussian_blur(x, 1.2), lambda x: bilateral_blur(x, 1.2, 0.3)]
both = pytest.mark.parametrize("blur", BLURS, ids=["gaussian", "bilateral"])


def image(height: int = 12, width: int = 9, batch: int = 1) -> torch.Tensor:
    generator = torch.Generator().manual_seed(0)
    return torch.rand(batch, 1, height, width, generator=generator, dtype=torch.float64)


@pytest.mark.parametrize("sigma_px", [0.4, 1.0, 2.5])
def test_the_gaussian_is_that_of_scipy(sigma_px: float) -> None:
    radius = int(np.ceil(3 * sigma_px))
    theirs = gaussian_filter(image()[0, 0].numpy(), sigma_px, mode="nearest", radius=radius)
    assert np.allclose(gaussian_blur(image(), sigma_px)[0, 0].numpy(), theirs, atol=1e-12)


def test_the_bilateral_filter_is_that_of_kornia() -> None:
    theirs = kornia_bilateral(image(20, 24), 5, 0.3, (0.8, 0.8), "replicate")
    assert torch.allclose(bilateral_blur(image(20, 24), 0.8, 0.3), theirs, atol=1e-12)


def test_the_bilateral_filter_spares_an_edge_that_the_gaussian_blurs() -> None:
    edge = (torch.arange(16) > 7).double().expand(1, 1, 16, 16)
    assert float((bilateral_blur(edge, 1.0, 0.05) - edge).abs().max()) < 1e-6
    assert float((gaussian_blur(edge, 1.0) - edge).abs().max()) > 0.2


@both
def test_a_flat_image_stays(blur: Blur) -> None:
    assert torch.allclose(blur(torch.full((1, 1, 3, 2), 0.7)), torch.tensor(0.7))


@both
def test_noise_gets_less(blur: Blur) -> None:
    noise = 0.5 + 0.05 * (image(64, 64) - 0.5)
    assert float(blur(noise).std()) < 0.5 * float(noise.std())


def test_no_width_is_no_blur() -> None:
    assert torch.equal(gaussian_blur(image(), 0), image())
    assert torch.equal(bilateral_blur(image(), 0, 0.1), image())


@both
def test_no_image_sees_the_others_of_its_batch(blur: Blur) -> None:
    images = image(batch=5).float()
    assert torch.equal(blur(images), torch.cat([blur(one[None]) for one in images]))


def test_broken_images_and_widths_are_refused() -> None:
    with pytest.raises(ImageContractError, match="got shape"):
        gaussian_blur(torch.zeros(4, 4), 1.0)
    with pytest.raises(ImageContractError, match="images: got shape"):
        bilateral_blur(torch.zeros(1, 3, 4, 4), 1.0, 0.1)
    with pytest.raises(InputError, match=r"sigma_px=-1: wanted 0..20 pixels"):
        gaussian_blur(image(), -1)
    with pytest.raises(InputError, match="sigma_px=21"):
        bilateral_blur(image(), 21, 0.1)
    with pytest.raises(InputError, match="sigma_level=0: wanted a level > 0"):
        bilateral_blur(image(), 1, 0)
