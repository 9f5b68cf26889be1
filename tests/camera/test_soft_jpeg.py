"""The JPEG with a slope, against kornia's, and against the real codec."""

import numpy as np
import pytest
import torch
from kornia.color import rgb_to_ycbcr
from kornia.enhance import jpeg_codec_differentiable
from scipy.fft import dctn

from lrsr.camera.codec import _CHROMAS, jpeg
from lrsr.camera.soft_jpeg import (
    SHARING,
    _soft_round,
    _through_blocks,
    cosine_transform,
    soft_jpeg,
)
from lrsr.errors import ImageContractError, InputError
from lrsr.images import linear_to_srgb

pytestmark = pytest.mark.usefixtures("one_thread")


def as_srgb(faces: torch.Tensor) -> torch.Tensor:
    return (linear_to_srgb(faces) * 255).round() / 255


def psnr_db(a: torch.Tensor, b: torch.Tensor) -> float:
    return float(-10 * torch.log10((a - b).square().mean()))


def test_luminance_is_that_of_kornias_codec(faces: torch.Tensor) -> None:
    # At quality 50 kornia's soft tables are the whole numbers of the standard's. Colours are not
    # compared: theirs are half a level off the middle.
    images = 0.2 + 0.5 * as_srgb(faces)[..., 2:50, 2:50]
    theirs = jpeg_codec_differentiable(images, torch.tensor([50.0]))
    difference = rgb_to_ycbcr(soft_jpeg(images, 50))[:, 0] - rgb_to_ycbcr(theirs)[:, 0]
    assert float(difference.abs().max()) * 255 < 0.01
    assert psnr_db(theirs, images) < 40


@pytest.mark.parametrize("chroma", SHARING)
@pytest.mark.parametrize("quality", [20, 60, 95])
def test_it_is_near_the_real_codec_for_every_sampling(
    faces: torch.Tensor, quality: int, chroma: str
) -> None:
    # Measured 42.3 to 46.0 dB; the file is 28 to 42 dB from its original.
    images = as_srgb(faces)
    file = jpeg(images, quality, chroma=chroma)
    gap = psnr_db(soft_jpeg(images, quality, chroma), file)
    assert gap > 41.5
    assert gap > psnr_db(file, images) + 4


def test_samplings_are_those_of_the_real_codec() -> None:
    assert list(SHARING) == list(_CHROMAS)


def test_every_size_keeps_its_shape_and_a_flat_picture_its_level() -> None:
    for size in ((1, 1), (7, 9), (17, 33)):
        for chroma in SHARING:
            flat = torch.full((2, 3, *size), 0.6)
            decoded = soft_jpeg(flat, 50, chroma)
            assert decoded.shape == flat.shape
            assert float((decoded - flat).abs().max()) * 255 < 1


def test_a_coefficient_is_rounded_to_a_multiple_of_its_step() -> None:
    # One wave along x of 10 levels: its coefficient is 10 sqrt(4) sqrt(8) = 56.57,
    # in steps of 20 2.828, softly 3 - 0.172³.
    places = (2 * torch.arange(8, dtype=torch.float64) + 1) * torch.pi / 16
    wave = 10 * torch.cos(2 * places).expand(1, 1, 8, 8)
    kept = _through_blocks(wave, torch.full((8, 8), 20.0))
    coefficient = 8**0.5
    wanted = 3 + (coefficient - 3) ** 3
    assert torch.allclose(kept, wave * wanted / coefficient)


def test_soft_rounding_follows_the_papers_cubic() -> None:
    numbers = torch.tensor([-3.0, 0.4, 0.6, 2.75], dtype=torch.float64, requires_grad=True)
    rounded = _soft_round(numbers)
    assert rounded.tolist() == pytest.approx([-3.0, 0.064, 0.936, 2.984375])
    rounded.sum().backward()
    assert numbers.grad is not None
    assert numbers.grad.tolist() == pytest.approx([0.0, 0.48, 0.48, 0.1875])


def test_no_image_sees_the_others_of_its_batch(faces: torch.Tensor) -> None:
    alone = torch.cat([soft_jpeg(face[None], 30) for face in as_srgb(faces)])
    assert torch.equal(soft_jpeg(as_srgb(faces), 30), alone)


def test_unknown_settings_and_broken_images_are_refused() -> None:
    image = torch.zeros(1, 3, 8, 8)
    with pytest.raises(InputError, match="quality=0: wanted 1 to 100"):
        soft_jpeg(image, 0)
    with pytest.raises(InputError, match="chroma=4:1:1: wanted one of 4:4:4"):
        soft_jpeg(image, 50, "4:1:1")
    with pytest.raises(ImageContractError, match="srgb: got shape"):
        soft_jpeg(image[0], 50)


def test_the_transform_is_that_of_scipy() -> None:
    generator = torch.Generator().manual_seed(4)
    block = torch.randn(8, 8, generator=generator, dtype=torch.float64)
    d = cosine_transform()
    assert np.allclose((d @ block @ d.T).numpy(), dctn(block.numpy(), norm="ortho"))
